#include "cli/demo_study.h"

#include <fmt/core.h>

#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>
#include <numbers>
#include <thread>
#include <utility>

#include "analysis/link/link.h"
#include "capture/record/virtual_trial.h"
#include "capture/rig/portable_random.h"
#include "capture/rig/virtual_rig.h"
#include "capture/track/track.h"
#include "cli/program_version.h"
#include "cli/score_trial.h"
#include "db/files/curve_files.h"
#include "db/files/design_toml.h"
#include "db/files/safe_file.h"
#include "db/trial_store.h"

namespace tendril::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMark = ".made-by-tendril-demo";
constexpr double kDegree = std::numbers::pi / 180;

// At the end of the pull the coils hang between 20 and 80 mm below the carrier: near enough for all, for
// some, for few.
constexpr std::array<double, 3> kDistances = {0.050, 0.065, 0.080};  // carrier to the object's axis, m

Gripper DemoGripper() {
  return {
      .tentacles = 2, .carrier_radius = 0.07, .first_azimuth = 0, .tilt = 0, .handedness = Handedness::kSame};
}

std::uint64_t TrialSeed(std::uint64_t seed, std::uint64_t trial) {
  // SplitMix64: neighbouring trials and seeds get unrelated streams.
  std::uint64_t z = seed * 0x9E3779B97F4A7C15ULL + trial + 1;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
  return z ^ (z >> 31);
}

TrueFold DrawFold(std::uint64_t seed) {
  std::mt19937_64 random(TrialSeed(seed, 0xF01D));
  TrueFold fold;
  fold.pull_scale = DrawUniform(random, 0.92, 1.0);
  fold.stiffness_ratio = DrawUniform(random, 0.85, 1.2);
  fold.stiffness_exponent = DrawUniform(random, 0.8, 1.3);
  return fold;
}

CenterlineError ErrorOf(const std::vector<CurveSeries>& found, const std::vector<CurveSeries>& truth) {
  CenterlineError error;
  for (std::size_t t = 0; t < found.size() && t < truth.size(); ++t) {
    for (std::size_t f = 0; f < found[t].curves.size() && f < truth[t].curves.size(); ++f) {
      const Eigen::Matrix3Xd apart = found[t].curves[f].points - truth[t].curves[f].points;
      for (Eigen::Index i = 0; i < apart.cols(); ++i) {
        const double square = apart.col(i).squaredNorm();
        error.all_squares += square;
        ++error.all_nodes;
        if (found[t].interpolated[f][i] != 0) continue;
        error.squares += square;
        ++error.nodes;
      }
    }
  }
  return error;
}

// The stated rule, on the true shapes and the object where it truly is.
Result<double> TrueObjectLink(const fs::path& folder, const std::vector<CurveSeries>& truth) {
  const Result<TruthFile> hidden = ReadTruthFile(folder / "truth.toml");
  if (!hidden.ok()) return hidden.error();
  std::vector<FramedCurve> last;
  last.reserve(truth.size());
  for (const CurveSeries& series : truth) last.push_back(series.curves.back());
  LinkOptions options;
  options.axis = Axis{hidden.value().object.center, hidden.value().object.axis};
  const Result<LinkReport> report = MeasureLink(last, options);
  if (!report.ok()) return report.error();
  return report.value().object_link;
}

Result<DemoTrialResult> RunTrial(Lab& lab, const DemoTrial& trial, const DemoPlan& plan,
                                 const DemoOptions& options, const Progress& progress) {
  const auto part = [&](double from, double to) { return PartOf(progress, from, to); };
  VirtualTrialOptions virtual_options;
  virtual_options.fold = plan.truth;
  virtual_options.frames = options.frames;
  virtual_options.seed = trial.seed;
  Result<RecordPlan> recording = PlanVirtualTrial(trial.spec, virtual_options);
  if (!recording.ok()) return recording.error();
  const Result<RecordedTrial> recorded = Record(lab, std::move(recording).value(), part(0, 0.4));
  if (!recorded.ok()) return recorded.error();
  const std::string& id = recorded.value().trial.id;
  if (recorded.value().state == TrialState::kAborted)
    return Error{ErrorKind::kStopped, "the demo was stopped"};

  TrackOptions track;
  track.threads = 1;
  const Result<TrackedTrial> tracked = TrackAndStore(lab, id, track, ProgramVersion(), part(0.4, 0.95));
  if (!tracked.ok()) return tracked.error();
  const Result<LinkSeries> scored = ScoreTrial(lab, id);
  if (!scored.ok()) return scored.error();

  const fs::path folder = lab.TrialFolder(id);
  const Result<std::vector<CurveSeries>> truth = ReadCurves(folder / "truth.h5");
  if (!truth.ok()) return truth.error();
  const Result<double> link = TrueObjectLink(folder, truth.value());
  if (!link.ok()) return link.error();
  DemoTrialResult result{.id = id,
                         .grasped = link.value() >= kGraspedLink,
                         .true_object_link = link.value(),
                         .error = ErrorOf(tracked.value().curves, truth.value())};
  const Outcome outcome{
      .grasped = result.grasped,
      .judged_by = "virtual rig",
      .by_person = false,
      .method = fmt::format("mean |object link| of the true final shapes >= {}", kGraspedLink),
      .notes = fmt::format("mean |object link| {:.3f}", result.true_object_link)};
  if (Status s = AddOutcome(lab, id, outcome); !s.ok()) return s.error();
  return result;
}

}  // namespace

void CenterlineError::Add(const CenterlineError& other) {
  squares += other.squares;
  nodes += other.nodes;
  all_squares += other.all_squares;
  all_nodes += other.all_nodes;
}

double CenterlineError::Rms() const {
  return nodes > 0 ? std::sqrt(squares / static_cast<double>(nodes))
                   : std::numeric_limits<double>::quiet_NaN();
}

double CenterlineError::AllRms() const {
  return all_nodes > 0 ? std::sqrt(all_squares / static_cast<double>(all_nodes))
                       : std::numeric_limits<double>::quiet_NaN();
}

Result<DemoPlan> PlanDemo(const DemoOptions& options) {
  DemoPlan plan;
  plan.truth = DrawFold(options.seed);
  TentacleDesign coiling;  // the paper's: taper 0.5, spacing ratio 0.5, alpha 90, beta 75 degrees
  TentacleDesign bending = coiling;
  bending.beta = 90 * kDegree;
  constexpr double kPull = 0.15;
  for (const auto& [name, design] : {std::pair{"bending", bending}, std::pair{"coiling", coiling}}) {
    VirtualRigOptions rig_options;
    rig_options.largest_pull = kPull;
    Result<Rig> rig = VirtualRig(design, DemoGripper(), rig_options);
    if (!rig.ok()) return rig.error();
    rig.value().name = name;
    plan.designs.push_back({name, design, RigToml(rig.value())});
  }
  // Repeats outermost: a demo that is stopped early has something of every cell.
  for (int repeat = 0; repeat < options.repeats; ++repeat) {
    for (std::size_t d = 0; d < plan.designs.size(); ++d) {
      for (const double distance : kDistances) {
        DemoTrial trial;
        trial.design = static_cast<int>(d);
        trial.seed = TrialSeed(options.seed, plan.trials.size());
        TrialSpec& spec = trial.spec;
        spec.label = fmt::format("{}-{:.0f}mm-{}", plan.designs[d].name, 1e3 * distance, repeat + 1);
        spec.kind = TrialKind::kVirtual;
        spec.design_name = plan.designs[d].name;
        spec.design = plan.designs[d].design;
        spec.gripper = DemoGripper();
        spec.rig_name = plan.designs[d].name;
        spec.rig_toml = plan.designs[d].rig_toml;
        spec.object = {.kind = "cylinder",
                       .radius = 0.004,
                       .length = 0.200,
                       .position = {0, 0, -distance},
                       .axis = {0, 1, 0},
                       .mass = 0.015};
        spec.object_distance = distance;
        spec.pull = kPull;
        spec.pull_rate = 0.03;
        spec.notes = "recorded on the virtual rig; no contact is modelled";
        plan.trials.push_back(std::move(trial));
      }
    }
  }
  return plan;
}

Status PrepareDemoFolder(const fs::path& folder) {
  std::error_code failed;
  if (fs::exists(folder, failed) && !fs::is_empty(folder, failed) && !fs::exists(folder / kMark, failed)) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("{}: is there and was not made by a demo, so it is left alone; name "
                             "another folder with --lab",
                             folder.string())};
  }
  fs::remove_all(folder, failed);
  fs::create_directories(folder, failed);
  if (failed) return Error{ErrorKind::kIo, fmt::format("{}: {}", folder.string(), failed.message())};
  if (Status s = WriteText(folder / kMark, "A later demo may replace this folder.\n"); !s.ok()) return s;
  const Result<Lab> lab = Lab::Create(folder);
  return lab.ok() ? Status(Ok{}) : Status(lab.error());
}

Result<std::vector<DemoTrialResult>> RunDemoTrials(const fs::path& lab_folder, const DemoPlan& plan,
                                                   const DemoOptions& options, const Progress& progress) {
  for (const DemoDesign& design : plan.designs) {
    if (Status s = WriteText(lab_folder / "designs" / (design.name + ".toml"), DesignToml(design.design));
        !s.ok()) {
      return s.error();
    }
    if (Status s = WriteText(lab_folder / "rigs" / (design.name + ".toml"), design.rig_toml); !s.ok()) {
      return s.error();
    }
  }
  std::vector<DemoTrialResult> results(plan.trials.size());
  std::vector<double> done(plan.trials.size(), 0);
  std::mutex mutex;
  std::atomic<std::size_t> next{0};
  std::atomic<bool> stop{false};
  std::optional<Error> failure;
  const auto fail = [&](Error error) {
    const std::lock_guard<std::mutex> lock(mutex);
    if (!failure) failure = std::move(error);
    stop = true;
  };
  const auto work = [&] {
    Result<Lab> lab = Lab::Open(lab_folder);  // a connection of its own
    if (!lab.ok()) return fail(lab.error());
    for (std::size_t i = next++; i < plan.trials.size() && !stop; i = next++) {
      const Progress of_trial = [&, i](double share) {
        const std::lock_guard<std::mutex> lock(mutex);
        done[i] = share;
        double sum = 0;
        for (const double d : done) sum += d;
        if (progress && !progress(sum / static_cast<double>(done.size()))) stop = true;
        return !stop;
      };
      Result<DemoTrialResult> result = RunTrial(lab.value(), plan.trials[i], plan, options, of_trial);
      if (!result.ok()) return fail(Error(result.error()).Within(plan.trials[i].spec.label));
      of_trial(1);
      results[i] = std::move(result).value();
    }
  };
  std::vector<std::thread> workers;
  for (int w = 0; w < std::max(1, options.threads); ++w) workers.emplace_back(work);
  for (std::thread& worker : workers) worker.join();
  if (failure) return *failure;
  if (stop) return Error{ErrorKind::kStopped, "the demo was stopped; what was recorded is kept"};
  return results;
}

}  // namespace tendril::cli
