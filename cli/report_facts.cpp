#include "cli/report_facts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "cli/score_trial.h"
#include "db/files/curve_files.h"
#include "db/files/recording_logs.h"
#include "model/median.h"

namespace tendril::cli {
namespace {

namespace fs = std::filesystem;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

NodeSight SightOf(const CurveSeries& series, std::size_t frame, Eigen::Index node) {
  if (!series.sigma.empty() && std::isnan(series.sigma[frame][node])) return NodeSight::kNotSeen;
  const bool bridged = !series.interpolated.empty() && series.interpolated[frame][node] != 0;
  return bridged ? NodeSight::kBridged : NodeSight::kSeen;
}

TentacleFacts FactsOf(const CurveSeries& series) {
  TentacleFacts facts;
  facts.name = series.name;
  const std::size_t frames = series.curves.size();
  const Eigen::Index nodes = frames == 0 ? 0 : series.curves.front().points.cols();
  std::vector<std::vector<double>> at_node(static_cast<std::size_t>(nodes));
  std::vector<double> of_seen;
  facts.worst_sigma = kNone;
  for (std::size_t f = 0; f < frames; ++f) {
    double seen = 0;
    double bridged = 0;
    std::vector<NodeSight> sights;
    for (Eigen::Index i = 0; i < nodes; ++i) {
      sights.push_back(SightOf(series, f, i));
      seen += sights.back() == NodeSight::kSeen ? 1 : 0;
      bridged += sights.back() == NodeSight::kBridged ? 1 : 0;
      const double sigma = series.sigma.empty() ? kNone : series.sigma[f][i];
      if (!std::isfinite(sigma)) continue;
      at_node[static_cast<std::size_t>(i)].push_back(sigma);
      if (sights.back() == NodeSight::kSeen) of_seen.push_back(sigma);
      if (sigma <= facts.worst_sigma) continue;
      facts.worst_sigma = sigma;
      facts.worst_node = static_cast<int>(i);
      facts.worst_frame = static_cast<int>(f);
    }
    const auto share = [&](double count) { return nodes > 0 ? count / static_cast<double>(nodes) : 0; };
    facts.seen_by_frame.push_back(share(seen));
    facts.bridged_by_frame.push_back(share(bridged));
    facts.seen += share(seen) / static_cast<double>(frames);
    facts.bridged += share(bridged) / static_cast<double>(frames);
    facts.sights.push_back(std::move(sights));
  }
  facts.not_seen = std::max(0.0, 1 - facts.seen - facts.bridged);
  facts.median_sigma = Median(of_seen);
  for (std::size_t i = 0; i < at_node.size(); ++i) {
    facts.median_sigma_at.push_back(Median(at_node[i]));
    facts.worst_sigma_at.push_back(
        at_node[i].empty() ? kNone : *std::max_element(at_node[i].begin(), at_node[i].end()));
    if (at_node[i].empty() && !series.sigma.empty()) facts.never_known.push_back(static_cast<int>(i));
  }
  return facts;
}

// Sums over corners, turned into what CameraFacts states.
struct CornerSums {
  double squares = 0;
  double corners = 0;
  void Add(const Eigen::Matrix<double, 2, 4>& corners_px) {
    squares += corners_px.squaredNorm();
    corners += 4;
  }
  double Rms() const { return corners > 0 ? std::sqrt(squares / corners) : kNone; }
};

void AddResidualFacts(const std::vector<ResidualRow>& rows, std::size_t frames,
                      std::vector<CameraFacts>& cameras) {
  std::vector<CornerSums> sums(cameras.size());
  std::vector<std::vector<CornerSums>> by_frame(cameras.size(), std::vector<CornerSums>(frames));
  std::vector<std::vector<double>> distances(cameras.size());
  std::vector<std::map<int, Eigen::Vector3d>> by_tag(cameras.size());  // sums of x and y; corners
  for (const ResidualRow& row : rows) {
    const auto c = static_cast<std::size_t>(row.camera);
    if (c >= cameras.size() || static_cast<std::size_t>(row.frame) >= frames) continue;
    CameraFacts& camera = cameras[c];
    ++camera.on_facet;
    ++(row.used ? camera.used : camera.left_out);
    if (!row.used || !row.corners_px.allFinite()) continue;
    CornerSums one;
    one.Add(row.corners_px);
    camera.tag_rms.push_back(one.Rms());
    sums[c].Add(row.corners_px);
    by_frame[c][static_cast<std::size_t>(row.frame)].Add(row.corners_px);
    for (int k = 0; k < 4; ++k) distances[c].push_back(row.corners_px.col(k).norm());
    const Eigen::Vector2d sum = row.corners_px.rowwise().sum();
    camera.shift_px += sum;
    by_tag[c].try_emplace(row.tag, Eigen::Vector3d::Zero()).first->second +=
        Eigen::Vector3d(sum.x(), sum.y(), 4);
  }
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    cameras[c].rms_px = sums[c].Rms();
    cameras[c].median_px = Median(distances[c]);
    cameras[c].shift_px /= sums[c].corners > 0 ? sums[c].corners : kNone;
    cameras[c].shift_error_px.setZero();
    for (const auto& [tag, of_tag] : by_tag[c]) {
      const Eigen::Vector2d off = of_tag.head<2>() - of_tag.z() * cameras[c].shift_px;
      cameras[c].shift_error_px += off.cwiseAbs2();
    }
    // Tags are the sample: one alone says nothing of its own spread.
    const auto tags = static_cast<double>(by_tag[c].size());
    const double few = tags > 1 ? std::sqrt(tags / (tags - 1)) : kNone;
    cameras[c].shift_error_px =
        few * cameras[c].shift_error_px.cwiseSqrt() / (sums[c].corners > 0 ? sums[c].corners : kNone);
    for (const CornerSums& frame : by_frame[c]) cameras[c].rms_by_frame.push_back(frame.Rms());
  }
}

void CountContradictions(const std::vector<ResidualRow>& rows, TrialFacts& facts) {
  struct Sightings {
    int all = 0, used = 0;
  };
  std::map<std::pair<std::int64_t, int>, Sightings> of_tag;
  for (const ResidualRow& row : rows) {
    Sightings& sightings = of_tag[{row.frame, row.tag}];
    ++sightings.all;
    sightings.used += row.used ? 1 : 0;
  }
  for (const auto& [tag, sightings] : of_tag) {
    if (sightings.all < 2) continue;
    ++facts.shared;
    facts.shared_contradicted += sightings.used < sightings.all ? 1 : 0;
  }
}

// What `track` kept with its row: one object per camera, cause -> count.
void AddRejected(const TrialDetails& details, std::vector<CameraFacts>& cameras) {
  for (const DerivedResult& result : details.results) {
    if (result.what != "track") continue;
    const auto parameters =
        nlohmann::json::parse(result.parameters_json, nullptr, /*allow_exceptions=*/false);
    if (!parameters.is_object() || !parameters.contains("tags_rejected")) return;
    const auto& all = parameters["tags_rejected"];
    for (std::size_t c = 0; c < cameras.size() && all.is_array() && c < all.size(); ++c) {
      cameras[c].rejected.emplace();
      for (const auto& [cause, count] : all[c].items()) {
        if (count.is_number_integer()) cameras[c].rejected->emplace_back(cause, count.get<long>());
      }
      std::sort(cameras[c].rejected->begin(), cameras[c].rejected->end(),
                [](const auto& a, const auto& b) { return a.second > b.second; });
    }
  }
}

Status AddCameras(const fs::path& folder, TrialFacts& facts) {
  const std::size_t frames = facts.curves.front().curves.size();
  for (std::size_t c = 0; c < facts.rig.cameras.size(); ++c) {
    CameraFacts camera;
    camera.number = static_cast<int>(c);
    camera.name = facts.rig.cameras[c].name;
    camera.rms_px = camera.median_px = camera.stated_sigma_px = kNone;
    camera.shift_px.setConstant(kNone);
    camera.shift_error_px.setConstant(kNone);
    const fs::path log = folder / fmt::format("cam{}.csv", c);
    if (fs::exists(log)) {
      const Result<std::vector<FrameRow>> rows = ReadFrameLog(log);
      if (!rows.ok()) return rows.error();
      camera.pictures = static_cast<long>(rows.value().size());
      for (const FrameRow& row : rows.value()) camera.dropped += static_cast<long>(row.dropped_before);
    }
    facts.cameras.push_back(std::move(camera));
  }
  if (fs::exists(folder / "detections.csv")) {
    const Result<std::vector<DetectionRow>> rows = ReadDetections(folder / "detections.csv");
    if (!rows.ok()) return rows.error();
    std::vector<std::vector<double>> sigmas(facts.cameras.size());
    for (const DetectionRow& row : rows.value()) {
      const auto c = static_cast<std::size_t>(row.camera);
      if (c >= facts.cameras.size()) continue;
      ++facts.cameras[c].found;
      if (std::isfinite(row.sigma_px)) sigmas[c].push_back(row.sigma_px);
    }
    for (std::size_t c = 0; c < sigmas.size(); ++c) facts.cameras[c].stated_sigma_px = Median(sigmas[c]);
  }
  AddRejected(facts.details, facts.cameras);
  if (!fs::exists(folder / "residuals.csv")) {
    if (fs::exists(folder / "cam0.mkv")) {
      facts.gaps.push_back(
          "no residuals.csv, as trials tracked before this version have none; it is made by: tendril track " +
          facts.details.overview.label);
    }
    return Ok{};
  }
  const Result<std::vector<ResidualRow>> rows = ReadResiduals(folder / "residuals.csv");
  if (!rows.ok()) return rows.error();
  for (CameraFacts& camera : facts.cameras) camera.shift_px.setZero();
  AddResidualFacts(rows.value(), frames, facts.cameras);
  CountContradictions(rows.value(), facts);
  facts.residuals_known = true;
  return Ok{};
}

// At most `most` of 0 .. frames - 1, evenly spread, both ends among them.
std::vector<int> Moments(int frames, int most) {
  std::vector<int> moments;
  const int count = std::min(frames, most);
  for (int i = 0; i < count; ++i) {
    moments.push_back(
        count < 2 ? frames - 1
                  : static_cast<int>(std::lround(static_cast<double>(i) * (frames - 1) / (count - 1))));
  }
  return moments;
}

// Neighbouring moments of the same two strands become one span.
void AddUndecided(int frame, std::size_t moment, const std::vector<int>& frames,
                  const std::vector<UndecidedCrossing>& crossings, std::vector<UndecidedSpan>& spans) {
  const auto sigmas = [](const UndecidedCrossing& c) { return c.separation / c.sigma; };
  for (const UndecidedCrossing& crossing : crossings) {
    const auto goes_on = std::find_if(spans.begin(), spans.end(), [&](const UndecidedSpan& span) {
      const int last = span.frames.back();
      return span.a == crossing.a && span.b == crossing.b &&
             (last == frame || (moment > 0 && last == frames[moment - 1]));
    });
    if (goes_on == spans.end()) {
      spans.push_back({.a = crossing.a, .b = crossing.b, .frames = {frame}, .nearest = crossing});
      continue;
    }
    if (goes_on->frames.back() != frame) goes_on->frames.push_back(frame);
    if (sigmas(crossing) < sigmas(goes_on->nearest)) goes_on->nearest = crossing;
  }
}

Status AddLink(const ReportOptions& report, const Progress& progress, TrialFacts& facts) {
  LinkFacts& link = facts.link;
  const auto frames = facts.curves.front().curves.size();
  LinkOptions options;
  options.method = LinkMethod::kFast;
  options.axis = AxisOf(facts.trial);
  link.axis = options.axis.has_value();
  for (const CurveSeries& series : facts.curves) {
    if (series.covariance_factor.size() == frames && frames > 0) continue;
    link.why_none = series.name + " states no covariance, without which there are no bands";
    return Ok{};
  }
  for (const int frame : Moments(static_cast<int>(frames), report.most_moments)) {
    std::vector<FramedCurve> moment;
    std::vector<Eigen::MatrixXd> factors;
    std::vector<Eigen::MatrixXd> turns;
    for (const CurveSeries& series : facts.curves) {
      moment.push_back(series.curves[static_cast<std::size_t>(frame)]);
      factors.push_back(series.covariance_factor[static_cast<std::size_t>(frame)]);
      turns.push_back(series.turn_factor.size() == frames
                          ? series.turn_factor[static_cast<std::size_t>(frame)]
                          : Eigen::MatrixXd());
    }
    link.frames.push_back(frame);
    Result<LinkBands> bands = MeasureLinkBands(moment, factors, options, {.draws = report.draws}, {}, turns);
    if (!bands.ok()) return Error(bands.error()).Within(fmt::format("link at frame {}", frame));
    AddUndecided(frame, link.frames.size() - 1, link.frames, bands.value().undecided, link.undecided);
    link.bands.push_back(std::move(bands).value());
    if (progress && !progress(static_cast<double>(link.frames.size()) /
                              static_cast<double>(std::min<std::size_t>(
                                  frames, static_cast<std::size_t>(report.most_moments))))) {
      return Error{ErrorKind::kStopped, "stopped while links were measured; no page was written"};
    }
  }
  return Ok{};
}

}  // namespace

bool IsTracked(const TrialDetails& details, const fs::path& folder) {
  return std::any_of(details.results.begin(), details.results.end(),
                     [](const DerivedResult& result) { return result.what == "track"; }) &&
         fs::exists(folder / "curves.h5");
}

Result<TrialFacts> CollectFacts(Lab& lab, const std::string& id, const ReportOptions& options,
                                const Progress& progress) {
  TrialFacts facts;
  Result<TrialDetails> details = TrialDetailsOf(lab, id);
  if (!details.ok()) return details.error();
  facts.details = std::move(details).value();
  const TrialOverview& overview = facts.details.overview;
  const fs::path folder = lab.TrialFolder(id);
  if (overview.kind == TrialKind::kSimulated) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("trial {} is simulated: there is nothing tracked to report; expected a recorded "
                             "trial; `tendril trials show {}` tells of a simulation",
                             overview.label, overview.label)};
  }
  if (!IsTracked(facts.details, folder)) {
    return Error{ErrorKind::kNotFound,
                 fmt::format("trial {} is not tracked yet; do it with: tendril track {} --lab {}",
                             overview.label, overview.label, lab.folder().string())};
  }
  Result<TrialSpec> trial = ReadTrialToml(folder / "trial.toml");
  if (!trial.ok()) return trial.error();
  facts.trial = std::move(trial).value();
  if (!facts.trial.rig_toml.empty()) {
    Result<Rig> rig = ParseRig(facts.trial.rig_toml, (folder / "trial.toml").string() + ": rig");
    if (!rig.ok()) return rig.error();
    facts.rig = std::move(rig).value();
  }
  Result<std::vector<CurveSeries>> curves = ReadCurves(folder / "curves.h5");
  if (!curves.ok()) return curves.error();
  facts.curves = std::move(curves).value();
  if (facts.curves.empty() || facts.curves.front().curves.empty()) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("trial {}: curves.h5 has no frame; expected one or more", overview.label)};
  }
  for (const CurveSeries& series : facts.curves) facts.tentacles.push_back(FactsOf(series));
  if (Status s = AddCameras(folder, facts); !s.ok()) return s.error();
  if (facts.curves.front().angle.empty()) {
    facts.gaps.push_back(
        !fs::exists(folder / "cam0.mkv")
            ? std::string("no fold angles: these curves were not reconstructed as chains of facets")
            : "no fold angles in curves.h5, as trials tracked before this version have none; they are made "
              "by: tendril track " +
                  overview.label);
  }
  if (Status s = AddLink(options, progress, facts); !s.ok()) return s.error();
  facts.remarks = RemarksOn(facts);
  return facts;
}

}  // namespace tendril::cli
