#include "capture/track/track.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <deque>
#include <future>
#include <limits>
#include <mutex>
#include <optional>
#include <span>
#include <tuple>
#include <utility>

#include "capture/record/pull_log.h"
#include "capture/rig/rig.h"
#include "capture/track/recall.h"
#include "capture/track/sightings.h"
#include "capture/track/view_residuals.h"
#include "db/files/curve_files.h"
#include "db/files/trial_toml.h"
#include "model/fold/fold.h"
#include "model/median.h"

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

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// One tentacle through all frames, each started also from the frame before.
Status SolveTentacle(int tentacle, const TrialSpec& trial, const Rig& rig, const PullLog& pulls,
                     const Sightings& sightings, const ChainOptions& options, int lag_moments,
                     TrackedTrial& tracked, std::vector<ResidualRow>& residuals, SharedProgress& progress) {
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
  Eigen::Index told = 0;
  Eigen::Index creases = 0;
  const auto views_of = [&](std::size_t f) -> const std::vector<TagView>& {
    return sightings.views[f][static_cast<std::size_t>(tentacle)];
  };
  const auto keep = [&](std::size_t f, const ChainSolution& solution) {
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
    AppendResiduals(rig.cameras, model.layout, views_of(f), solution, static_cast<std::int64_t>(f),
                    residuals);
    series.curves.push_back(solution.curve);
    series.angle.push_back(solution.angle);
    series.angle_sigma.push_back(solution.angle_sigma);
    series.angle_by_pictures.push_back(solution.angle_by_pictures);
    for (Eigen::Index i = 0; i < solution.angle_by_pictures.size(); ++i) {
      told += solution.angle_by_pictures[i] >= kToldByPictures ? 1 : 0;
    }
    creases += solution.angle_by_pictures.size();
    series.sigma.push_back(solution.sigma);
    series.interpolated.push_back(solution.interpolated);
    if (solution.covariance_factor.size() > 0) series.covariance_factor.push_back(solution.covariance_factor);
    if (solution.turn_factor.size() > 0) series.turn_factor.push_back(solution.turn_factor);
  };

  // Each moment by itself; with a lag again, once the moments after it are known.
  const auto lag = static_cast<std::size_t>(lag_moments);
  std::vector<MomentAngles> angles;  // by itself, of each moment
  std::deque<ChainSolution> alone;   // of the moments not yet kept, and the last one
  std::size_t first_alone = 0;
  for (std::size_t f = 0; f < frames + lag; ++f) {
    if (f < frames) {
      const double pull =
          std::clamp(pulls.At(tentacle, sightings.time[f]), 0.0, LargestPull(design.closed_angle));
      const Result<Fold> fold = SolveFold(design, pull);
      if (!fold.ok()) return fold.error();
      model.expected_angle = fold.value().angle;
      model.recalled = {};
      alone.push_back(
          SolveChain(model, rig.cameras, views_of(f), options, alone.empty() ? nullptr : &alone.back()));
      angles.push_back(AnglesOf(sightings.time[f], model, alone.back()));
    }
    if (f >= lag) {
      const std::size_t now = f - lag;
      const ChainSolution& by_itself = alone[now - first_alone];
      const std::size_t from = now - std::min(now, lag);
      model.expected_angle = angles[now].expected;
      model.recalled = RecallAngles(
          angles[now], std::span(angles).subspan(from, std::min(now + lag + 1, frames) - from), options);
      if ((model.recalled.sigma.array() > 0).any()) {
        keep(now, SolveChain(model, rig.cameras, views_of(now), options, &by_itself));
      } else {
        keep(now, by_itself);
      }
      for (; alone.size() > 1 && first_alone <= now; ++first_alone) alone.pop_front();
    }
    if (!progress.Step()) return Stopped();
  }
  summary.seen_fraction = nodes > 0 ? static_cast<double>(seen) / static_cast<double>(nodes) : 0;
  summary.told_fraction = creases > 0 ? static_cast<double>(told) / static_cast<double>(creases) : 0;
  summary.rms_reprojection_px = summary.views_used > 0 ? std::sqrt(squares / summary.views_used) : kNone;
  summary.median_sigma = Median(sigmas);
  return Ok{};
}

fs::path CameraFile(const fs::path& folder, std::size_t camera, const char* extension) {
  return folder / fmt::format("cam{}{}", camera, extension);
}

}  // namespace

Result<TrackedTrial> TrackTrial(const fs::path& folder, const TrackOptions& options,
                                const Progress& progress) {
  if (options.smooth_lag < 0) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("smooth lag {}: expected a count of frames, 0 for none", options.smooth_lag)};
  }
  const Result<TrialSpec> read = ReadTrialToml(folder / "trial.toml");
  if (!read.ok()) return read.error();
  const TrialSpec& trial = read.value();
  if (trial.kind == TrialKind::kSimulated) {
    return Error{ErrorKind::kBadInput,
                 (folder / "trial.toml").string() + ": the trial is simulated; expected one with videos"};
  }
  const bool touching = options.touching.value_or(trial.kind != TrialKind::kVirtual);
  ChainOptions chain = touching ? LoadedTentacles() : ChainOptions{};
  chain.fold_law = options.fold_law;
  const Result<Rig> rig = ParseRig(trial.rig_toml, (folder / "trial.toml").string() + ": rig");
  if (!rig.ok()) return rig.error();
  const std::size_t cameras = rig.value().cameras.size();
  if (cameras == 0) {
    return Error{ErrorKind::kBadInput,
                 (folder / "trial.toml").string() + ": the rig has no camera to track with"};
  }
  const Result<TagLayout> tags = LayOutTags(trial.design, trial.gripper, LayoutOptionsOf(trial.tags));
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
  tracked.touching = touching;
  tracked.chain = chain;
  tracked.family = trial.tags.family;
  const Clock::time_point detecting = Clock::now();
  if (options.from_detections) {
    Result<std::vector<DetectionRow>> rows = ReadDetections(folder / "detections.csv");
    if (!rows.ok()) return rows.error();
    tracked.detections = std::move(rows).value();
    if (Status s = CheckDetections(tracked.detections, times, folder / "detections.csv"); !s.ok())
      return s.error();
  } else {
    TagsInVideoOptions finding{.level = options.tag_level, .detect = options.detect};
    finding.detect.family = trial.tags.family;
    SharedProgress steps(progress, 0, 0.7, pictures);
    std::vector<TagsInVideo> found(cameras);
    const Status done = ForEach(static_cast<int>(cameras), options.threads, [&](int c) -> Status {
      const auto camera = static_cast<std::size_t>(c);
      Result<TagsInVideo> tags_seen =
          FindTagsInVideo(CameraFile(folder, camera, ".mkv"), c, times[camera].size(), finding,
                          [&steps] { return steps.Step(); });
      if (!tags_seen.ok()) return tags_seen.error();
      found[camera] = std::move(tags_seen).value();
      return Ok{};
    });
    if (!done.ok()) return done.error();
    for (const TagsInVideo& camera : found) {
      tracked.detections.insert(tracked.detections.end(), camera.rows.begin(), camera.rows.end());
      std::vector<double> sigmas;
      for (const DetectionRow& row : camera.rows) {
        if (std::isfinite(row.sigma_px)) sigmas.push_back(row.sigma_px);
      }
      tracked.cameras.push_back({.counts = camera.counts,
                                 .tags = static_cast<long>(camera.rows.size()),
                                 .seconds = camera.seconds,
                                 .median_sigma_px = Median(sigmas)});
    }
  }
  tracked.detect_seconds = SecondsSince(detecting);

  const Clock::time_point solving = Clock::now();
  const Sightings sightings =
      SortSightings(tracked.detections, times, tags.value(), trial, options.same_moment);
  tracked.frames = static_cast<int>(sightings.time.size());
  tracked.unknown_tags = sightings.unknown_tags;
  tracked.curves.resize(static_cast<std::size_t>(trial.gripper.tentacles));
  tracked.tentacles.resize(tracked.curves.size());
  SharedProgress steps(
      progress, 0.7, 1,
      static_cast<double>((sightings.time.size() + static_cast<std::size_t>(options.smooth_lag)) *
                          tracked.curves.size()));
  std::vector<std::vector<ResidualRow>> residuals(tracked.curves.size());
  const Status solved = ForEach(trial.gripper.tentacles, options.threads, [&](int tentacle) {
    return SolveTentacle(tentacle, trial, rig.value(), pulls.value(), sightings, chain, options.smooth_lag,
                         tracked, residuals[static_cast<std::size_t>(tentacle)], steps);
  });
  if (!solved.ok()) return solved.error();
  for (const std::vector<ResidualRow>& rows : residuals) {
    tracked.residuals.insert(tracked.residuals.end(), rows.begin(), rows.end());
  }
  std::stable_sort(tracked.residuals.begin(), tracked.residuals.end(), [](const auto& a, const auto& b) {
    return std::tie(a.frame, a.camera, a.tag) < std::tie(b.frame, b.camera, b.tag);
  });
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
  if (Status s = WriteResiduals(folder / "residuals.csv", tracked.residuals); !s.ok()) return s.error();
  if (Status s = WriteCurves(folder / "curves.h5", tracked.curves, "tendril track"); !s.ok())
    return s.error();
  return tracked;
}

}  // namespace tendril
