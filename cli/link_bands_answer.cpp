#include "cli/link_bands_answer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tendril::cli {
namespace {

using Json = nlohmann::ordered_json;

Json BandJson(const LinkBand& band) {
  Json json{{"mean", NumberOrNull(band.mean)},
            {"standard_deviation", NumberOrNull(band.standard_deviation)},
            {"band68", {NumberOrNull(band.low68), NumberOrNull(band.high68)}},
            {"band95", {NumberOrNull(band.low95), NumberOrNull(band.high95)}},
            {"modes", Json::array()}};
  for (const LinkMode& mode : band.modes)
    json["modes"].push_back({{"value", mode.value}, {"share", mode.share}});
  return json;
}

std::string Place(const std::vector<std::string>& names, int curve) {
  return curve < 0 ? "the axis" : names[static_cast<std::size_t>(curve)];
}

}  // namespace

std::string BandText(const LinkBand& band) {
  if (!std::isfinite(band.mean)) return "not known";
  if (band.modes.size() < 2)
    return fmt::format("{:+.3f} [{:+.3f}, {:+.3f}]", band.mean, band.low95, band.high95);
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(band.modes.size(), 3); ++i) {
    text += fmt::format("{}{:+.2f} ({:.0f} %)", i == 0 ? "" : " or ", band.modes[i].value,
                        100 * band.modes[i].share);
  }
  return band.modes.size() > 3 ? text + " or else" : text;
}

std::string UndecidedText(const UndecidedCrossing& crossing, const std::vector<std::string>& names) {
  return fmt::format("{} at node {:.1f} and {} are {:.1f} mm apart, known to {:.1f} mm (1 sigma)",
                     Place(names, crossing.a), crossing.node_a,
                     crossing.b < 0
                         ? "the axis"
                         : fmt::format("{} at node {:.1f}", Place(names, crossing.b), crossing.node_b),
                     1e3 * crossing.separation, 1e3 * crossing.sigma);
}

Status AnswerWithBands(const std::vector<CurveSeries>& curves, std::size_t frame, const LinkOptions& options,
                       int draws, const std::string& source, Output& out) {
  std::vector<FramedCurve> moment;
  std::vector<Eigen::MatrixXd> factors;
  std::vector<Eigen::MatrixXd> turns;
  std::vector<std::string> names;
  for (const CurveSeries& curve : curves) {
    if (curve.covariance_factor.size() <= frame) {
      return Error{ErrorKind::kBadInput,
                   fmt::format("--bands: {}: curve '{}' states no covariance; expected curves that tendril "
                               "track made (curves.h5)",
                               source, curve.name)};
    }
    moment.push_back(curve.curves[frame]);
    factors.push_back(curve.covariance_factor[frame]);
    turns.push_back(frame < curve.turn_factor.size() ? curve.turn_factor[frame] : Eigen::MatrixXd());
    names.push_back(curve.name);
  }
  const Result<LinkBands> measured =
      MeasureLinkBands(moment, factors, options, {.draws = draws}, out.ShowProgress("bands"), turns);
  if (!measured.ok()) return Error(measured.error()).Within(source);
  const LinkBands& bands = measured.value();

  Json& json = out.fields()["bands"];
  json["draws"] = bands.draws;
  json["normals_drawn"] = bands.normals_drawn;
  json["curves"] = Json::array();
  json["pairs"] = Json::array();
  json["undecided"] = Json::array();
  out.Print("");
  out.Print("how sure: mean and 95 % over {} draws of the curves", bands.draws);
  for (std::size_t k = 0; k < bands.curves.size(); ++k) {
    const CurveBands& curve = bands.curves[k];
    json["curves"].push_back({{"name", names[k]},
                              {"writhe", BandJson(curve.writhe)},
                              {"self_link", BandJson(curve.self_link)},
                              {"object_link", BandJson(curve.object_link)}});
    out.Print("{:<24}  self link {}", names[k], BandText(curve.self_link));
    if (options.axis) out.Print("{:<24}  object link {}", "", BandText(curve.object_link));
  }
  const bool normals = std::any_of(moment.begin(), moment.end(),
                                   [](const FramedCurve& curve) { return curve.normals.cols() > 0; });
  if (normals && !bands.normals_drawn) {
    out.Print(
        "bands of self links are too narrow: {} states no turn of the normals (`tendril track` "
        "does, of trials with videos)",
        source);
  }
  for (const PairBands& pair : bands.pairs) {
    json["pairs"].push_back({{"a", Place(names, pair.a)},
                             {"b", Place(names, pair.b)},
                             {"link", BandJson(pair.link)},
                             {"gauss", BandJson(pair.gauss)}});
    out.Print("{:<24}  link {}", Place(names, pair.a) + " - " + Place(names, pair.b), BandText(pair.link));
  }
  json["mutual_link"] = BandJson(bands.mutual_link);
  json["object_link"] = BandJson(bands.object_link);
  json["performance"] = BandJson(bands.performance);
  if (!bands.pairs.empty()) out.Print("{:<24}  {}", "mutual link", BandText(bands.mutual_link));
  if (options.axis) out.Print("{:<24}  {}", "object link", BandText(bands.object_link));
  if (options.axis && !bands.pairs.empty()) {
    out.Print("{:<24}  {}", "grasping performance", BandText(bands.performance));
  }
  for (const UndecidedCrossing& crossing : bands.undecided) {
    json["undecided"].push_back({{"a", Place(names, crossing.a)},
                                 {"b", Place(names, crossing.b)},
                                 {"node_a", crossing.node_a},
                                 {"node_b", crossing.node_b},
                                 {"separation_m", crossing.separation},
                                 {"sigma_m", crossing.sigma}});
    out.Print("undecided: {}", UndecidedText(crossing, names));
  }
  if (bands.undecided.empty())
    out.Print("every crossing is decided: strands are farther apart than 3 sigmas");
  return Ok{};
}

}  // namespace tendril::cli
