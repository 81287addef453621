// TrackAndStore: what tracking gives to the lab's database.
#include <fmt/core.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "capture/track/track.h"
#include "db/files/safe_file.h"
#include "db/trial_store.h"

namespace tendril {

namespace fs = std::filesystem;

Result<TrackedTrial> TrackAndStore(Lab& lab, const std::string& trial_id, const TrackOptions& options,
                                   const std::string& program, const Progress& progress) {
  const fs::path folder = lab.TrialFolder(trial_id);
  Result<TrackedTrial> tracked = TrackTrial(folder, options, progress);
  if (!tracked.ok()) return tracked;

  TrackRow row{.frames = tracked.value().frames,
               .tentacles = static_cast<int>(tracked.value().curves.size())};
  double squares = 0;
  double views = 0;
  double seen = 0;
  for (const TrackedTentacle& t : tracked.value().tentacles) {
    if (t.views_used > 0) squares += t.views_used * t.rms_reprojection_px * t.rms_reprojection_px;
    views += t.views_used;
    seen += t.seen_fraction;
  }
  if (views > 0) row.rms_reprojection_px = std::sqrt(squares / views);
  if (row.tentacles > 0) row.seen_fraction = seen / row.tentacles;
  double sigma_squares = 0;
  double sigma_count = 0;
  for (const CurveSeries& series : tracked.value().curves) {
    for (const Eigen::VectorXd& sigma : series.sigma) {
      for (const double s : sigma) {
        if (!std::isfinite(s)) continue;
        sigma_squares += s * s;
        sigma_count += 1;
      }
    }
  }
  if (sigma_count > 0) row.rms_sigma_m = std::sqrt(sigma_squares / sigma_count);

  Provenance made{.program_version = program};
  const TagDetectOptions& detect = options.detect;
  const ChainOptions& chain = tracked.value().chain;
  nlohmann::json parameters{{"family", tracked.value().family},
                            {"decimate", detect.decimate},
                            {"min_white_black_diff", detect.min_white_black_diff},
                            {"max_hamming", detect.max_hamming},
                            {"from_detections", options.from_detections},
                            {"load", tracked.value().touching ? "contact" : "free"},
                            {"fold_law", chain.fold_law},
                            {"sigma_corner_px", chain.sigma_corner_px},
                            {"sigma_flatness_px", chain.sigma_flatness_px},
                            {"sigma_calibration_px", chain.sigma_calibration_px},
                            {"sigma_tag_place_m", chain.sigma_tag_place},
                            {"sigma_tag_turn_rad", chain.sigma_tag_turn},
                            {"sigma_tag_lift_m", chain.sigma_tag_lift},
                            {"sigma_tag_tilt_rad", chain.sigma_tag_tilt},
                            {"sigma_facet_bend_rad", chain.sigma_facet_bend},
                            {"sigma_hole_m", chain.sigma_hole},
                            {"sigma_hole_lift_m", chain.sigma_hole_lift},
                            {"sigma_bridged_lift_m", chain.sigma_bridged_lift},
                            {"sigma_gap_m", chain.sigma_gap},
                            {"sigma_gap_flat_m", chain.sigma_gap_flat},
                            {"sigma_swing_rad", chain.sigma_swing},
                            {"sigma_angle_rad", chain.sigma_angle},
                            {"sigma_opening_rad", chain.sigma_opening},
                            {"sigma_opening_walk_rad", chain.sigma_opening_walk},
                            {"sigma_base_place_m", chain.sigma_base_place},
                            {"sigma_base_turn_rad", chain.sigma_base_turn},
                            {"sigma_base_fold_rad", chain.sigma_base_fold},
                            {"largest_chi_square", chain.largest_chi_square}};
  if (options.smooth_lag > 0) {
    parameters["smooth_lag"] = options.smooth_lag;
    parameters["sigma_recall_walk_rad_per_root_s"] = chain.sigma_recall_walk;
    parameters["sigma_recall_change_share"] = chain.sigma_recall_change;
  }
  if (!chain.fold_law) {
    parameters["sigma_free_opening_rad"] = chain.sigma_free_opening;
    parameters["sigma_free_walk_rad"] = chain.sigma_free_walk;
  }
  if (!options.from_detections) {
    parameters["tag_level"] = NameOfLevel(options.tag_level);
    for (const CameraTags& camera : tracked.value().cameras) {
      nlohmann::json rejected = nlohmann::json::object();
      for (const auto& [cause, count] : RejectedByCause(camera.counts)) rejected[cause] = count;
      parameters["tags_rejected"].push_back(rejected);
    }
  }
  made.parameters_json = parameters.dump();
  std::vector<std::string> inputs = {"trial.toml"};
  if (fs::exists(folder / "servo.csv")) inputs.emplace_back("servo.csv");
  for (int c = 0; fs::exists(folder / fmt::format("cam{}.csv", c)); ++c) {
    inputs.push_back(fmt::format("cam{}.csv", c));
    if (!options.from_detections) inputs.push_back(fmt::format("cam{}.mkv", c));
  }
  if (options.from_detections) inputs.emplace_back("detections.csv");
  for (const std::string& input : inputs) {
    Result<std::string> hash = Sha256OfFile(folder / input);
    if (!hash.ok()) return hash.error();
    made.input_sha256.emplace_back(input, std::move(hash).value());
  }
  if (Status s = StoreTrack(lab, trial_id, row, made); !s.ok()) return s.error();
  for (const auto& [role, file] :
       {std::pair{"detections", "detections.csv"}, std::pair{"curves", "curves.h5"},
        std::pair{"residuals", "residuals.csv"}}) {
    Result<std::string> hash = Sha256OfFile(folder / file);
    if (!hash.ok()) return hash.error();
    if (Status s = AddRecordingFile(lab, trial_id, role, file, hash.value()); !s.ok()) return s.error();
  }
  return tracked;
}

}  // namespace tendril
