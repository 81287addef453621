// tendril fold: the shape that a design takes at a given pull.
#include "cli/fold_command.h"

#include <filesystem>
#include <memory>
#include <numbers>
#include <optional>
#include <vector>

#include "cli/fold_answer.h"
#include "db/files/curve_files.h"
#include "db/files/design_toml.h"
#include "db/files/origami_files.h"
#include "model/fold/crease_pattern.h"
#include "model/fold/facet_chain.h"
#include "model/fold/facet_overlap.h"

namespace tendril::cli {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

struct FoldCall {
  std::string design;
  double pull = 0;
  std::string law = "paper";
  std::vector<double> path;
  std::string curves;
  std::string fold;
  int frames = 10;
  std::string origami_svg;
};

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

// Files for programs that fold paper: pulls at equal steps, from the last of the path to the call's own.
Status WriteForOrigami(const FoldCall& call, const TentacleDesign& design, const TentacleLayout& layout,
                       const Eigen::VectorXd& angle, Output& out) {
  const Result<CreasePattern> pattern = CreasePatternOf(design, layout);
  if (!pattern.ok()) return Error(pattern.error()).Within(call.design);
  if (!call.fold.empty()) {
    std::vector<FoldedFrame> frames;
    const double from = call.path.empty() ? 0 : call.path.back();
    for (int i = 1; i <= call.frames; ++i) {
      const double pull = i == call.frames ? call.pull : from + (call.pull - from) * i / call.frames;
      const Result<FoldAnswer> fold = AnswerFold(call.law, design, layout, call.path, pull);
      if (!fold.ok()) return Error(fold.error()).Within(call.design);
      frames.push_back({fmt::format("pull {:.6g}", pull), fold.value().angle,
                        FoldedVertices(layout, FoldChain(layout, fold.value().angle))});
    }
    const Status written =
        WriteFoldText(call.fold, pattern.value(), frames, std::filesystem::path(call.design).stem().string(),
                      "tendril " TENDRIL_VERSION);
    if (!written.ok()) return written.error();
    out.fields()["fold"] = call.fold;
    out.Print("FOLD 1.2               {}: crease pattern and {} folded form{}", call.fold, frames.size(),
              frames.size() == 1 ? "" : "s");
  }
  if (!call.origami_svg.empty()) {
    const Status written = WriteOrigamiSvg(call.origami_svg, pattern.value(), angle);
    if (!written.ok()) return written.error();
    out.fields()["origami_svg"] = call.origami_svg;
    out.Print("for Origami Simulator  {}", call.origami_svg);
  }
  return Ok{};
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
  const Result<FoldAnswer> fold = AnswerFold(call.law, design.value(), layout.value(), call.path, call.pull);
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
  if (call.fold.empty() && call.origami_svg.empty()) return Ok{};
  return WriteForOrigami(call, design.value(), layout.value(), fold.value().angle, out);
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
            app.add_option("--fold", call->fold,
                           "write the crease pattern and folded forms up to this pull (FOLD 1.2, metres)");
            app.add_option("--frames", call->frames, "folded forms in the --fold file (count)")
                ->check(CLI::Range(1, 10000))
                ->capture_default_str();
            app.add_option("--origami-svg", call->origami_svg,
                           "write the crease pattern with its target angles for Origami Simulator (SVG)");
          },
      .run = [call](Output& out) { return RunFold(*call, out); },
  };
}

}  // namespace tendril::cli
