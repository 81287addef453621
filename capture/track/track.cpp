#include "capture/track/track.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <future>
#include <limits>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "capture/record/pull_log.h"
#include "capture/record/video_file.h"
#include "capture/rig/rig.h"
#include "db/files/curve_files.h"
#include "db/files/safe_file.h"
#include "db/files/trial_toml.h"
#include "db/trial_store.h"
#include "model/fold/fold.h"

namespace tendril {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Progress of several threads as one number.
class SharedProgress {
 public:
  SharedProgress(Progress progress, double from, double to, double steps)
      : progress_(std::move(progress)), from_(from), to_(to), steps_(std::max(1.0, steps)) {}

  // One step is done; whether to go on.
  bool Step() {
    const std::lock_guard<std::mutex> lock(mutex_);
    done_ += 1;
    if (progress_ && !progress_(from_ + (to_ - from_) * std::min(1.0, done_ / steps_))) stopped_ = true;
    return !stopped_;
  }

 private:
  Progress progress_;
  double from_;
  double to_;
  double steps_;
  std::mutex mutex_;
  double done_ = 0;
  bool stopped_ = false;
};

Error Stopped() { return {ErrorKind::kStopped, "tracking was stopped; nothing was written"}; }

// Runs work(0) .. work(count - 1), `threads` at a time; the first error in order.
template <class Work>
Status ForEach(int count, int threads, const Work& work) {
  std::vector<Status> done(static_cast<std::size_t>(count), Status(Ok{}));
  const int workers = std::clamp(threads, 1, std::max(1, count));
  std::vector<std::future<void>> running;
  for (int w = 0; w < workers; ++w) {
    running.push_back(std::async(workers == 1 ? std::launch::deferred : std::launch::async, [&, w] {
      for (int i = w; i < count; i += workers) done[static_cast<std::size_t>(i)] = work(i);
    }));
  }
  for (std::future<void>& r : running) r.get();
  for (Status& s : done) {
    if (!s.ok()) return s;
  }
  return Ok{};
}

using FrameLog = std::vector<FrameRow>;

// All pictures of one camera.
Result<std::vector<DetectionRow>> DetectInVideo(const fs::path& video, int camera, std::size_t frames,
                                                const TagDetectOptions& options, SharedProgress& progress) {
  Result<TagDetector> detector = TagDetector::Create(options);
  if (!detector.ok()) return detector.error();
  Result<VideoReader> reader = VideoReader::Open(video);
  if (!reader.ok()) return reader.error();
  std::vector<DetectionRow> found;
  for (std::size_t frame = 0;; ++frame) {
    Result<std::optional<VideoFrame>> next = reader.value().Next();
    if (!next.ok()) return next.error();
    if (!next.value()) {
      if (frame == frames) return found;
      return Error{ErrorKind::kBadInput, fmt::format("{}: {} frames, but its frame log has {} rows",
                                                     video.string(), frame, frames)};
    }
    const cv::Mat& image = next.value()->image;
    const auto tags =
        detector.value().Detect({image.data, image.cols, image.rows, static_cast<int>(image.step)});
    if (!tags.ok()) return Error(tags.error()).Within(fmt::format("{}: frame {}", video.string(), frame));
    for (const TagDetection& tag : tags.value()) {
      found.push_back({.camera = camera,
                       .frame = static_cast<std::int64_t>(frame),
                       .tag = tag.id,
                       .hamming = tag.hamming,
                       .margin = tag.margin,
                       .corners_px = tag.corners_px});
    }
    if (!progress.Step()) return Stopped();
  }
}

// For each frame of camera 0 the frame of every camera that shows the same moment, or -1.
std::vector<std::vector<std::int64_t>> SameMoments(const std::vector<FrameLog>& cameras, double share) {
  const std::vector<FrameRow>& first = cameras.front();
  double interval = std::numeric_limits<double>::infinity();
  if (first.size() > 1) {
    interval = static_cast<double>(first.back().host_ns - first.front().host_ns) /
               static_cast<double>(first.size() - 1);
  }
  std::vector<std::vector<std::int64_t>> moments(first.size());
  for (std::size_t f = 0; f < first.size(); ++f) {
    moments[f].assign(cameras.size(), -1);
    moments[f][0] = static_cast<std::int64_t>(f);
    for (std::size_t c = 1; c < cameras.size(); ++c) {
      const std::vector<FrameRow>& rows = cameras[c];
      const auto after =
          std::lower_bound(rows.begin(), rows.end(), first[f].host_ns,
                           [](const FrameRow& row, std::int64_t ns) { return row.host_ns < ns; });
      double nearest = share * interval;
      for (auto candidate = after == rows.begin() ? after : after - 1;
           candidate != rows.end() && candidate <= after; ++candidate) {
        const double apart = std::abs(static_cast<double>(candidate->host_ns - first[f].host_ns));
        if (apart > nearest) continue;
        nearest = apart;
        moments[f][c] = candidate - rows.begin();
      }
    }
  }
  return moments;
}

// Everything about a recording that the solver needs, sorted by frame and tentacle.
struct Sightings {
  std::vector<double> time;                              // s                               (frames)
  std::vector<std::vector<std::vector<TagView>>> views;  // (frames) x (tentacles) x views
  int unknown_tags = 0;
};

Sightings Sort(const std::vector<DetectionRow>& rows, const std::vector<FrameLog>& cameras,
               const TagLayout& tags, const TrialSpec& trial, double same_moment) {
  Sightings sorted;
  const std::vector<FrameRow>& first = cameras.front();
  const auto moments = SameMoments(cameras, same_moment);
  std::vector<std::vector<int>> frame_of(cameras.size());  // camera's own frame -> frame of camera 0
  for (std::size_t c = 0; c < cameras.size(); ++c) frame_of[c].assign(cameras[c].size(), -1);
  for (std::size_t f = 0; f < moments.size(); ++f) {
    sorted.time.push_back(1e-9 * static_cast<double>(first[f].host_ns - trial.started_ns));
    for (std::size_t c = 0; c < cameras.size(); ++c) {
      if (moments[f][c] >= 0) frame_of[c][static_cast<std::size_t>(moments[f][c])] = static_cast<int>(f);
    }
  }
  sorted.views.assign(moments.size(),
                      std::vector<std::vector<TagView>>(static_cast<std::size_t>(trial.gripper.tentacles)));
  for (const DetectionRow& row : rows) {
    const auto camera = static_cast<std::size_t>(row.camera);
    const int frame = frame_of[camera][static_cast<std::size_t>(row.frame)];
    const TagPlace* place = tags.Find(row.tag);
    if (place == nullptr) ++sorted.unknown_tags;
    if (place == nullptr || frame < 0) continue;
    sorted.views[static_cast<std::size_t>(frame)][static_cast<std::size_t>(place->tentacle)].push_back(
        {.camera = row.camera, .place = place, .corners_px = row.corners_px});
  }
  return sorted;
}

// Rows of a detections.csv that somebody else may have made.
Status CheckDetections(const std::vector<DetectionRow>& rows, const std::vector<FrameLog>& cameras,
                       const fs::path& file) {
  for (const DetectionRow& row : rows) {
    if (row.camera < 0 || static_cast<std::size_t>(row.camera) >= cameras.size()) {
      return Error{ErrorKind::kBadInput, fmt::format("{}: camera {}, but the rig has cameras 0 .. {}",
                                                     file.string(), row.camera, cameras.size() - 1)};
    }
    const std::size_t frames = cameras[static_cast<std::size_t>(row.camera)].size();
    if (row.frame < 0 || static_cast<std::size_t>(row.frame) >= frames) {
      return Error{ErrorKind::kBadInput,
                   fmt::format("{}: frame {} of camera {}, but its frame log has {} rows", file.string(),
                               row.frame, row.camera, frames)};
    }
  }
  return Ok{};
}

// One tentacle through all frames, each started also from the frame before.
Status SolveTentacle(int tentacle, const TrialSpec& trial, const Rig& rig, const PullLog& pulls,
                     const Sightings& sightings, const ChainOptions& options, TrackedTrial& tracked,
                     SharedProgress& progress) {
  const TentacleDesign design = DesignOfTentacle(trial.gripper, trial.design, tentacle);
  const Result<TentacleLayout> layout = LayOut(design);
  if (!layout.ok()) return layout.error();
  ChainModel model{.layout = layout.value(),
                   .expected_angle = {},
                   .closed_angle = design.closed_angle,
                   .lab_from_tentacle = LabFromTentacle(trial.gripper, tentacle)};

  CurveSeries& series = tracked.curves[static_cast<std::size_t>(tentacle)];
  TrackedTentacle& summary = tracked.tentacles[static_cast<std::size_t>(tentacle)];
  const auto frames = sightings.time.size();
  series.name = fmt::format("tentacle{}", tentacle);
  series.time = Eigen::Map<const Eigen::VectorXd>(sightings.time.data(), static_cast<Eigen::Index>(frames));
  std::vector<double> sigmas;
  double squares = 0;
  Eigen::Index seen = 0;
  Eigen::Index nodes = 0;
  std::optional<ChainSolution> previous;
  for (std::size_t f = 0; f < frames; ++f) {
    const double pull =
        std::clamp(pulls.At(tentacle, sightings.time[f]), 0.0, LargestPull(design.closed_angle));
    const Result<Fold> fold = SolveFold(design, pull);
    if (!fold.ok()) return fold.error();
    model.expected_angle = fold.value().angle;
    ChainSolution solution =
        SolveChain(model, rig.cameras, sightings.views[f][static_cast<std::size_t>(tentacle)], options,
                   previous ? &*previous : nullptr);
    for (Eigen::Index i = 0; i < solution.sigma.size(); ++i) {
      ++nodes;
      if (solution.interpolated[i] != 0) continue;
      ++seen;
      sigmas.push_back(solution.sigma[i]);
    }
    if (solution.views_used > 0) {
      squares += solution.views_used * solution.rms_reprojection_px * solution.rms_reprojection_px;
    }
    summary.views_used += solution.views_used;
    summary.views_rejected += solution.views_rejected;
    series.curves.push_back(solution.curve);
    series.sigma.push_back(solution.sigma);
    series.interpolated.push_back(solution.interpolated);
    if (solution.covariance_factor.size() > 0) series.covariance_factor.push_back(solution.covariance_factor);
    previous = std::move(solution);
    if (!progress.Step()) return Stopped();
  }
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  summary.seen_fraction = nodes > 0 ? static_cast<double>(seen) / static_cast<double>(nodes) : 0;
  summary.rms_reprojection_px = summary.views_used > 0 ? std::sqrt(squares / summary.views_used) : kNone;
  summary.median_sigma = kNone;
  if (!sigmas.empty()) {
    const auto middle = sigmas.begin() + static_cast<std::ptrdiff_t>(sigmas.size() / 2);
    std::nth_element(sigmas.begin(), middle, sigmas.end());
    summary.median_sigma = *middle;
  }
  return Ok{};
}

fs::path CameraFile(const fs::path& folder, std::size_t camera, const char* extension) {
  return folder / fmt::format("cam{}{}", camera, extension);
}

}  // namespace

Result<TrackedTrial> TrackTrial(const fs::path& folder, const TrackOptions& options,
                                const Progress& progress) {
  const Result<TrialSpec> read = ReadTrialToml(folder / "trial.toml");
  if (!read.ok()) return read.error();
  const TrialSpec& trial = read.value();
  const Result<Rig> rig = ParseRig(trial.rig_toml, (folder / "trial.toml").string() + ": rig");
  if (!rig.ok()) return rig.error();
  const std::size_t cameras = rig.value().cameras.size();
  if (cameras == 0) {
    return Error{ErrorKind::kBadInput,
                 (folder / "trial.toml").string() + ": the rig has no camera to track with"};
  }
  const Result<TagLayout> tags = LayOutTags(
      trial.design, trial.gripper,
      {.family = trial.tags.family, .footprint = trial.tags.footprint, .first_id = trial.tags.first_id});
  if (!tags.ok()) return tags.error();
  const Result<PullLog> pulls = PullLog::Read(folder, trial);
  if (!pulls.ok()) return pulls.error();

  std::vector<FrameLog> times(cameras);
  double pictures = 0;
  for (std::size_t c = 0; c < cameras; ++c) {
    Result<std::vector<FrameRow>> log = ReadFrameLog(CameraFile(folder, c, ".csv"));
    if (!log.ok()) return log.error();
    times[c] = std::move(log).value();
    pictures += static_cast<double>(times[c].size());
  }

  TrackedTrial tracked;
  tracked.family = trial.tags.family;
  const Clock::time_point detecting = Clock::now();
  if (options.from_detections) {
    Result<std::vector<DetectionRow>> rows = ReadDetections(folder / "detections.csv");
    if (!rows.ok()) return rows.error();
    tracked.detections = std::move(rows).value();
    if (Status s = CheckDetections(tracked.detections, times, folder / "detections.csv"); !s.ok())
      return s.error();
  } else {
    TagDetectOptions detect = options.detect;
    detect.family = trial.tags.family;
    SharedProgress steps(progress, 0, 0.7, pictures);
    std::vector<std::vector<DetectionRow>> found(cameras);
    const Status done = ForEach(static_cast<int>(cameras), options.threads, [&](int c) -> Status {
      const auto camera = static_cast<std::size_t>(c);
      Result<std::vector<DetectionRow>> rows =
          DetectInVideo(CameraFile(folder, camera, ".mkv"), c, times[camera].size(), detect, steps);
      if (!rows.ok()) return rows.error();
      found[camera] = std::move(rows).value();
      return Ok{};
    });
    if (!done.ok()) return done.error();
    for (const std::vector<DetectionRow>& rows : found) {
      tracked.detections.insert(tracked.detections.end(), rows.begin(), rows.end());
    }
  }
  tracked.detect_seconds = SecondsSince(detecting);

  const Clock::time_point solving = Clock::now();
  const Sightings sightings = Sort(tracked.detections, times, tags.value(), trial, options.same_moment);
  tracked.frames = static_cast<int>(sightings.time.size());
  tracked.unknown_tags = sightings.unknown_tags;
  tracked.curves.resize(static_cast<std::size_t>(trial.gripper.tentacles));
  tracked.tentacles.resize(tracked.curves.size());
  SharedProgress steps(progress, 0.7, 1, static_cast<double>(sightings.time.size() * tracked.curves.size()));
  const Status solved = ForEach(trial.gripper.tentacles, options.threads, [&](int tentacle) {
    return SolveTentacle(tentacle, trial, rig.value(), pulls.value(), sightings, options.chain, tracked,
                         steps);
  });
  if (!solved.ok()) return solved.error();
  tracked.solve_seconds = SecondsSince(solving);

  for (std::size_t i = 0; i < tracked.tentacles.size(); ++i) {
    if (tracked.tentacles[i].views_used == 0) {
      tracked.warnings.push_back(
          fmt::format("{}: no tag of tentacle {} was seen; its curve is the model's alone",
                      folder.filename().string(), i));
    }
  }
  if (!options.from_detections) {
    if (Status s = WriteDetections(folder / "detections.csv", tracked.detections); !s.ok()) return s.error();
  }
  if (Status s = WriteCurves(folder / "curves.h5", tracked.curves, "tendril track"); !s.ok())
    return s.error();
  return tracked;
}

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
  const ChainOptions& chain = options.chain;
  made.parameters_json = nlohmann::json{{"family", tracked.value().family},
                                        {"decimate", detect.decimate},
                                        {"min_white_black_diff", detect.min_white_black_diff},
                                        {"max_hamming", detect.max_hamming},
                                        {"from_detections", options.from_detections},
                                        {"sigma_corner_px", chain.sigma_corner_px},
                                        {"sigma_tag_place_m", chain.sigma_tag_place},
                                        {"sigma_tag_turn_rad", chain.sigma_tag_turn},
                                        {"sigma_hole_m", chain.sigma_hole},
                                        {"sigma_gap_m", chain.sigma_gap},
                                        {"sigma_swing_rad", chain.sigma_swing},
                                        {"sigma_angle_rad", chain.sigma_angle},
                                        {"sigma_opening_rad", chain.sigma_opening},
                                        {"sigma_opening_walk_rad", chain.sigma_opening_walk},
                                        {"sigma_base_place_m", chain.sigma_base_place},
                                        {"sigma_base_turn_rad", chain.sigma_base_turn},
                                        {"sigma_base_fold_rad", chain.sigma_base_fold},
                                        {"largest_chi_square", chain.largest_chi_square}}
                             .dump();
  std::vector<std::string> inputs = {"trial.toml"};
  if (fs::exists(folder / "servo.csv")) inputs.emplace_back("servo.csv");
  for (int c = 0; fs::exists(CameraFile(folder, static_cast<std::size_t>(c), ".csv")); ++c) {
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
       {std::pair{"detections", "detections.csv"}, std::pair{"curves", "curves.h5"}}) {
    Result<std::string> hash = Sha256OfFile(folder / file);
    if (!hash.ok()) return hash.error();
    if (Status s = AddRecordingFile(lab, trial_id, role, file, hash.value()); !s.ok()) return s.error();
  }
  return tracked;
}

}  // namespace tendril
