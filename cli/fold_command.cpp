// tendril fold: the shape that a design takes at a given pull.
#include "cli/fold_command.h"

#include <memory>
#include <numbers>
#include <optional>
#include <vector>

#include "db/files/curve_files.h"
#include "db/files/design_toml.h"
#include "model/fold/exact_law.h"
#include "model/fold/facet_chain.h"
#include "model/fold/facet_overlap.h"
#include "model/fold/fold.h"
#include "model/fold/tendon_friction.h"

namespace tendril::cli {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

struct FoldCall {
  std::string design;
  double pull = 0;
  std::string law = "paper";
  std::vector<double> path;
  std::string curves;
};

// What either law answers; none: it has no such thing.
struct FoldAnswer {
  Eigen::VectorXd angle;
  std::vector<int> closed;
  double tendon_length = 0;
  std::optional<double> scale;
  std::optional<double> tension;
  std::optional<bool> slack;
  std::optional<double> base_tension;  // where friction makes it another
};

// From flat through the path to the pull.
Result<FoldAnswer> SolveWithFriction(const FoldCall& call, const TentacleDesign& design) {
  Result<FrictionTendon> tendon = FrictionTendon::Make(design);
  if (!tendon.ok()) return tendon.error();
  for (const double pull : call.path) {
    if (const auto on_the_way = tendon.value().MoveTo(pull); !on_the_way.ok()) return on_the_way.error();
  }
  const Result<FrictionFold> fold = tendon.value().MoveTo(call.pull);
  if (!fold.ok()) return fold.error();
  const FrictionFold& f = fold.value();
  FoldAnswer answer{f.angle, {},          f.tendon_length, std::nullopt, f.tension.tail<1>()[0],
                    f.slack, f.tension[0]};
  for (Eigen::Index i = 0; i < f.angle.size(); ++i) {
    if (f.angle[i] >= design.closed_angle) answer.closed.push_back(static_cast<int>(i));
  }
  return answer;
}

Result<FoldAnswer> Solve(const FoldCall& call, const TentacleDesign& design, const TentacleLayout& layout) {
  if (call.law == "paper") {
    const Result<Fold> fold = SolveFold(layout, design.base_width, design.closed_angle, call.pull);
    if (!fold.ok()) return fold.error();
    const Fold& f = fold.value();
    return FoldAnswer{f.angle, f.closed, f.tendon_length, f.scale, std::nullopt, std::nullopt, std::nullopt};
  }
  if (design.tendon_friction > 0) return SolveWithFriction(call, design);
  const Result<ExactFold> fold = SolveExactFold(layout, HingeStiffness(design, layout), design.rest_angle,
                                                design.closed_angle, call.pull);
  if (!fold.ok()) return fold.error();
  const ExactFold& f = fold.value();
  return FoldAnswer{f.angle, f.closed, f.tendon_length, std::nullopt, f.tension, f.slack, std::nullopt};
}

template <class T>
nlohmann::ordered_json OrNull(const std::optional<T>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

// Ten angles a line, each line headed by the number of its first crease.
void PrintAngles(const Eigen::VectorXd& angle, Output& out) {
  out.Print("fold angles, degrees:");
  for (Eigen::Index first = 0; first < angle.size(); first += 10) {
    std::string line = fmt::format("  crease {:>4}: ", first);
    for (Eigen::Index i = first; i < std::min(first + 10, angle.size()); ++i) {
      line += fmt::format(" {:6.2f}", angle[i] / kDegree);
    }
    out.Print("{}", line);
  }
}

Status RunFold(const FoldCall& call, Output& out) {
  const auto design = ReadDesign(call.design);
  if (!design.ok()) return design.error();
  if (!call.path.empty() && (call.law != "exact" || design.value().tendon_friction == 0)) {
    return Error{ErrorKind::kBadInput,
                 call.design + ": --path changes nothing without --law exact and a tendon.friction above 0"};
  }
  const auto layout = LayOut(design.value());
  if (!layout.ok()) return Error(layout.error()).Within(call.design);
  const Result<FoldAnswer> fold = Solve(call, design.value(), layout.value());
  if (!fold.ok()) return Error(fold.error()).Within(call.design);

  const FacetChain chain = FoldChain(layout.value(), fold.value().angle);
  const TendonCurve curve = TendonCurveOf(layout.value(), chain, fold.value().angle);
  const double kinematic = KinematicPull(layout.value(), curve);
  const auto overlapping = OverlappingFacets(layout.value(), chain);

  auto& fields = out.fields();
  fields["law"] = call.law;
  fields["pull"] = call.pull;
  fields["fold_angle_rad"] = std::vector<double>(fold.value().angle.begin(), fold.value().angle.end());
  fields["scale"] = OrNull(fold.value().scale);
  fields["tension_N"] = OrNull(fold.value().tension);  // infinite: null too
  fields["base_tension_N"] = OrNull(fold.value().base_tension);
  fields["slack"] = OrNull(fold.value().slack);
  fields["closed"] = fold.value().closed;
  fields["flat_tendon_length_m"] = FlatTendonLength(layout.value());
  fields["tendon_length_m"] = fold.value().tendon_length;
  fields["kinematic_pull"] = kinematic;
  fields["holes_m"] = nlohmann::ordered_json::array();
  for (Eigen::Index i = 0; i < curve.holes.cols(); ++i) {
    fields["holes_m"].push_back({curve.holes(0, i), curve.holes(1, i), curve.holes(2, i)});
  }
  fields["overlapping_facets"] = overlapping;

  out.Print("tendon, hole to hole   {:.2f} mm, flat {:.2f} mm", 1e3 * fold.value().tendon_length,
            1e3 * FlatTendonLength(layout.value()));
  out.Print("pull                   {:.6g}; the rigid shape's own {:.6g}", call.pull, kinematic);
  if (fold.value().scale) out.Print("scale k                {:.9g}", *fold.value().scale);
  if (fold.value().tension) {
    if (fold.value().base_tension) out.Print("tension at the base    {:.6g} N", *fold.value().base_tension);
    out.Print("tension{}{:.6g} N{}", fold.value().base_tension ? " at the tip     " : "                ",
              *fold.value().tension,
              *fold.value().slack ? "; slack: the rest shape takes in more than this pull" : "");
  }
  out.Print("closed creases         {} of {}", fold.value().closed.size(), fold.value().angle.size());
  const Eigen::Vector3d tip = 1e3 * curve.holes.rightCols<1>();
  out.Print("last hole              x {:.2f}, y {:.2f}, z {:.2f} mm", tip.x(), tip.y(), tip.z());
  PrintAngles(fold.value().angle, out);

  if (!overlapping.empty()) {
    const size_t pairs = overlapping.size();
    out.Warn(
        fmt::format("{} of rigid facets pass{} through each other, facets {} and {} first: paper would touch "
                    "and stop there",
                    pairs == 1 ? "1 pair" : fmt::format("{} pairs", pairs), pairs == 1 ? "es" : "",
                    overlapping.front().first, overlapping.front().second));
  }
  if (!call.curves.empty()) {
    CurveSeries series{.name = "tendon",
                       .time = Eigen::VectorXd::Zero(1),
                       .curves = {NodesAtHoles(curve)},
                       .sigma = {},
                       .interpolated = {},
                       .covariance_factor = {}};
    const Status written = WriteCurves(call.curves, std::span(&series, 1), "tendril fold " TENDRIL_VERSION);
    if (!written.ok()) return written.error();
    fields["curves"] = call.curves;
    out.Print("oriented tendon curve  {}", call.curves);
  }
  return Ok{};
}

}  // namespace

Command MakeFoldCommand() {
  auto call = std::make_shared<FoldCall>();
  return {
      .path = "fold",
      .help = "fold angles and shape of one tentacle at a tendon pull",
      .example = "tendril fold examples/designs/paper.toml --pull 0.3 --curves folded.csv",
      .declare =
          [call](CLI::App& app) {
            app.add_option("design", call->design, "design file (TOML)")->required();
            app.add_option("--pull", call->pull, "tendon taken in, as a fraction of its flat length (0 to 1)")
                ->required();
            app.add_option("--law", call->law,
                           "law of the fold angles: the paper's, or least energy under the true distances")
                ->check(CLI::IsMember({"paper", "exact"}))
                ->capture_default_str();
            app.add_option("--path", call->path,
                           "pulls that were visited before, from flat, separated by commas: with tendon "
                           "friction the shape depends on them (law exact)")
                ->delimiter(',');
            app.add_option("--curves", call->curves,
                           "write the tendon's oriented curve to this file (.csv or .h5; metres)");
          },
      .run = [call](Output& out) { return RunFold(*call, out); },
  };
}

}  // namespace tendril::cli
