// tendril simulate: a scene's rods over time, with their links.
#include "cli/simulate_command.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "cli/lab_option.h"
#include "cli/program_version.h"
#include "cli/scene_film.h"
#include "cli/scene_video.h"
#include "cli/simulate_lab.h"
#include "cli/simulate_report.h"
#include "db/files/curve_files.h"
#include "db/files/design_toml.h"
#include "db/files/safe_file.h"
#include "db/files/scene_toml.h"
#include "db/files/state_file.h"
#include "db/trial_query.h"
#include "model/rods/rod_lanes.h"
#include "model/scene/holding.h"
#include "model/scene/simulate.h"

namespace tendril::cli {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

struct SimulateCall {
  std::string scene;
  std::string level;
  std::string out;
  std::string video;
  std::string picture;
  std::string checkpoint;
  std::string lab;
  std::string label;
  std::vector<double> at;
  std::vector<std::string> settings;
  std::string then;  // a test of holding
  double fps = 30;
  std::uint64_t trial = 0;
  int threads = 1;
  bool store = false;  // in a lab
  bool plan = false;
  bool full = false;
};

double Since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

// Frames at the rate, the end, and what was asked for besides.
std::vector<double> TimesOf(const SimulateCall& call, double duration) {
  std::vector<double> times = call.at;
  for (int i = 0; i / call.fps < duration * (1 - 1e-12); ++i) times.push_back(i / call.fps);
  times.push_back(duration);
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

// The state of an interrupted run: kept now and then, and gone once the run is through.
class Checkpoint {
 public:
  static constexpr double kEvery_s = 10;

  Checkpoint(std::string file, std::string run) : file_(std::move(file)), run_(std::move(run)) {}

  // The state to go on from, if there is one.
  Result<std::optional<SimulationState>> Load() const {
    if (file_.empty() || !fs::exists(file_)) return std::optional<SimulationState>();
    Result<SimulationState> state = ReadState(file_, run_);
    if (!state.ok()) return state.error();
    return std::optional(std::move(state).value());
  }

  std::function<void(const std::function<SimulationState()>&)> Keeper() {
    if (file_.empty()) return {};
    return [this](const std::function<SimulationState()>& make) {
      if (!StopRequested() && Since(kept_) < kEvery_s) return;
      const Status written = WriteState(file_, make(), run_);
      trouble_ = written.ok() ? "" : written.error().message;
      holds_ = holds_ || written.ok();
      kept_ = Clock::now();
    };
  }

  bool holds() const { return holds_; }  // a state of this run
  // A state that could not be written is no reason to lose the run.
  const std::string& trouble() const { return trouble_; }
  void Remove() const {
    std::error_code ignored;
    if (!file_.empty()) fs::remove(file_, ignored);
  }

 private:
  std::string file_, run_, trouble_;
  bool holds_ = false;
  Clock::time_point kept_ = Clock::now();
};

std::string RunId(const SimulateCall& call, const std::string& text, const Scene& scene,
                  const std::vector<double>& times) {
  // Kernels of other widths round otherwise.
  std::string all = fmt::format("{} {} {} ", ProgramVersion(), RodKernelWidth(), NameOf(scene.level)) + text;
  if (scene.gripper) all += DesignToml(scene.gripper->design);
  all += fmt::format("{} {}", call.trial, call.full);
  for (const std::string& setting : call.settings) all += " " + setting;
  all += " " + call.then;
  for (const double time : times) all += fmt::format(" {:.17g}", time);
  return Sha256(all);
}

// A test of holding that the run ends with.
struct Holding {
  HoldingTest test = HoldingTest::kLift;
  HoldingOptions options;
  HoldingTimes times;
};

HoldingTest TestNamed(const std::string& name) {
  for (const HoldingTest test : {HoldingTest::kLift, HoldingTest::kLoad, HoldingTest::kStrike}) {
    if (NameOf(test) == name) return test;
  }
  return HoldingTest::kRelease;
}

Result<HoldingResult> TellHolding(const Scene& scene, const Holding& holding, const Simulated& done,
                                  Output& out) {
  const Result<std::vector<Driven>> rods = MakeRods(scene, 0);
  if (!rods.ok()) return rods.error();
  double mass = 0;
  for (const Driven& d : rods.value()) mass += d.rod.mass.sum();
  Result<HoldingResult> judged =
      JudgeHolding(scene, holding.test, holding.times, holding.options, done, mass);
  if (!judged.ok()) return judged;
  const HoldingResult& result = judged.value();
  const auto number = [](double value) {
    return std::isnan(value) ? nlohmann::json() : nlohmann::json(value);
  };
  out.fields()["holding"] = {{"test", NameOf(result.test)},
                             {"held", result.held},
                             {"rise_m", result.rise},
                             {"shift_m", result.shift},
                             {"payload_kg", number(result.payload)},
                             {"payload_is_least", result.payload_is_least},
                             {"payload_by_rods_mass", number(result.payload_ratio)},
                             {"strikes", result.strikes},
                             {"release_s", number(result.release_time)}};
  out.Print("{}: {}", NameOf(result.test), result.Sentence());
  return judged;
}

// Curves, film, picture and trial, as far as they were asked for.
Status WriteAll(const SimulateCall& call, const std::string& scene_text, const Scene& scene,
                const SimulationPlan& plan, const Simulated& done, double wall, Output& out) {
  auto& fields = out.fields();
  if (!call.out.empty()) {
    if (Status s = WriteCurves(call.out, done.curves, ProgramVersion() + " simulate"); !s.ok()) return s;
    fields["out"] = call.out;
    out.Print("{}: {} frames of {} rods", call.out, done.curves[0].time.size(), done.curves.size());
  }
  Result<LinkSeries> links = TellLink(scene, done.curves, out);
  if (!links.ok()) return links.error();
  TellPassages(done, out);
  if (call.store) {
    Result<Lab> lab = OpenLab(call.lab);
    if (!lab.ok()) return lab.error();
    const Result<std::string> label = StoreSimulatedTrial(lab.value(), {.scene_file = call.scene,
                                                                        .scene_text = scene_text,
                                                                        .label = call.label,
                                                                        .scene = &scene,
                                                                        .plan = &plan,
                                                                        .run = &done,
                                                                        .links = &links.value(),
                                                                        .trial_number = call.trial,
                                                                        .wall_s = wall});
    if (!label.ok()) return label.error();
    fields["trial"] = label.value();
    out.Print("trial {} of kind simulated, in the lab", label.value());
  }
  if (call.video.empty() && call.picture.empty()) return Ok{};
  const SceneFilm film = FilmOf(scene, done, links.value());
  if (!call.picture.empty()) {
    if (Status s = WriteScenePicture(film, call.picture); !s.ok()) return s;
    fields["picture"] = call.picture;
    out.Print("{}: the last frame", call.picture);
  }
  if (!call.video.empty()) {
    if (Status s = WriteSceneVideo(film, call.video, out.ShowProgress(call.video)); !s.ok()) return s;
    fields["video"] = call.video;
    out.Print("{}: {} frames", call.video, done.curves[0].time.size());
  }
  return Ok{};
}

// What cannot be done is said before the run, not after it.
Status CheckCall(const SimulateCall& call, const Scene& scene) {
  for (const double time : call.at) {
    if (time >= 0 && time <= scene.duration) continue;
    return Error{ErrorKind::kBadInput,
                 fmt::format("--at {}: expected 0 to the scene's duration, {} s", time, scene.duration)};
  }
  const auto ends = [](const std::string& file, std::initializer_list<const char*> known) {
    return file.empty() || std::any_of(known.begin(), known.end(), [&](const char* extension) {
             return fs::path(file).extension() == extension;
           });
  };
  const struct {
    const char* option;
    const std::string& file;
    std::initializer_list<const char*> known;
    const char* expected;
  } files[] = {{"--out", call.out, {".csv", ".h5", ".hdf5"}, ".csv or .h5"},
               {"--video", call.video, {".mp4"}, ".mp4"},
               {"--picture", call.picture, {".png"}, ".png"}};
  for (const auto& [option, file, known, expected] : files) {
    if (!ends(file, known)) {
      return Error{ErrorKind::kBadInput,
                   fmt::format("{} {}: expected a file that ends in {}", option, file, expected)};
    }
  }
  for (const std::string& file : {call.out, call.video, call.picture, call.checkpoint}) {
    if (file.empty()) continue;
    const fs::path folder = fs::absolute(file).parent_path();
    if (!fs::is_directory(folder)) {
      return Error{ErrorKind::kNotFound, fmt::format("{}: there is no folder {}", file, folder.string())};
    }
    if (fs::is_directory(file)) return Error{ErrorKind::kBadInput, file + ": is a folder, expected a file"};
    if (access(folder.c_str(), W_OK) != 0) {
      return Error{ErrorKind::kBadInput, fmt::format("{}: the folder cannot be written to", file)};
    }
  }
  if (!call.checkpoint.empty() && scene.level == SimulationLevel::kStatic) {
    return Error{ErrorKind::kBadInput,
                 "--checkpoint: level static takes no time that would be worth keeping"};
  }
  constexpr double kMostFrames = 1e5;
  if (!(call.fps * scene.duration <= kMostFrames)) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("--fps {}: {:.3g} frames in the scene's {} s; expected at most {:.0f}", call.fps,
                             call.fps * scene.duration, scene.duration, kMostFrames)};
  }
  if (!call.store) return Ok{};
  if (Status s = CheckIsTrial(scene); !s.ok()) return s;
  Result<Lab> lab = OpenLab(call.lab);
  if (!lab.ok()) return lab.error();
  if (!call.label.empty() && FindTrial(lab.value(), call.label).ok()) {
    return Error{
        ErrorKind::kBadInput,
        fmt::format("--label {}: taken by another trial; choose another, or leave it out", call.label)};
  }
  return Ok{};
}

Status RunSimulate(const SimulateCall& call, Output& out) {
  Result<Scene> read = ReadScene(call.scene, call.settings);
  if (!read.ok()) return read.error();
  const Result<std::string> scene_text = ReadText(call.scene);
  if (!scene_text.ok()) return scene_text.error();
  Scene scene = std::move(read).value();
  if (!call.level.empty()) scene.level = LevelNamed(call.level);
  std::optional<Holding> holding;
  if (!call.then.empty()) {
    holding.emplace().test = TestNamed(call.then);
    const Result<HoldingTimes> times = AddHoldingTest(scene, holding->test, holding->options);
    if (!times.ok()) return Error(times.error()).Within(call.scene);
    holding->times = times.value();
  }
  if (Status good = CheckCall(call, scene); !good.ok()) return good;
  const Result<SimulationPlan> planned = PlanScene(scene, call.full);
  if (!planned.ok()) return Error(planned.error()).Within(call.scene);
  const SimulationPlan& plan = planned.value();
  out.fields()["scene"] = scene.name;
  TellPlan(scene, plan, out);
  if (call.plan) return Ok{};

  const std::vector<double> times = TimesOf(call, scene.duration);
  Checkpoint checkpoint(call.checkpoint, RunId(call, scene_text.value(), scene, times));
  const Result<std::optional<SimulationState>> state = checkpoint.Load();
  if (!state.ok()) return state.error();
  SimulateHooks hooks;
  hooks.threads = call.threads;
  double resumed_at = 0;  // the last frame that was kept, s
  const auto begin = Clock::now();
  hooks.progress = out.ShowProgress(scene.name, [&](double share) {
    return fmt::format("{:.3g} times real time", (share * scene.duration - resumed_at) / Since(begin));
  });
  hooks.keep = checkpoint.Keeper();
  if (state.value()) {
    hooks.resume_from = &*state.value();
    out.fields()["resumed_at_s"] =
        state.value()->curves.empty() ? 0.0 : state.value()->curves[0].time.tail<1>()[0];
    out.Print("going on from {}", call.checkpoint);
  }

  const Result<Simulated> run = Simulate(scene, plan, times, call.trial, hooks);
  if (!run.ok()) return Error(run.error()).Within(call.scene);
  const double wall = Since(begin);
  const Simulated& done = run.value();
  if (!checkpoint.trouble().empty()) out.Warn("no state could be kept: " + checkpoint.trouble());
  const double reached = done.curves[0].time.size() > 0 ? done.curves[0].time.tail<1>()[0] : 0;

  auto& fields = out.fields();
  fields["wall_s"] = wall;
  fields["steps"] = done.steps;
  fields["diverged"] = done.diverged.has_value();
  if (done.diverged) {
    fields["divergence"] = {{"time_s", done.diverged->time},
                            {"rod", done.diverged->rod},
                            {"element", done.diverged->element},
                            {"why", done.diverged->why},
                            {"suggested_step_s", done.diverged->suggested_step}};
  }
  out.Print("{:.4g} s of {:.4g} in {:.3g} s: {:.3g} times real time, {} {}", reached, scene.duration, wall,
            (reached - resumed_at) / wall, done.steps,
            scene.level == SimulationLevel::kStatic ? "equilibria" : "steps");
  const bool goes_on = done.stopped && checkpoint.holds();
  if (holding && !done.diverged && !done.stopped) {
    const Result<HoldingResult> result = TellHolding(scene, *holding, done, out);
    if (!result.ok()) return result.error();
  }
  for (const std::string& doubt : done.doubts) out.Warn("the run cannot be trusted: " + doubt);
  fields["doubts"] = done.doubts;
  if (done.curves[0].time.size() > 0 && !goes_on) {
    if (Status s = WriteAll(call, scene_text.value(), scene, plan, done, wall, out); !s.ok()) return s;
  }
  if (!goes_on) checkpoint.Remove();
  if (done.diverged && done.diverged->at_start) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("{}: {}, element {}: {}; move them apart", call.scene, done.diverged->rod,
                             done.diverged->element, done.diverged->why)};
  }
  if (done.diverged) {
    const bool published = scene.level == SimulationLevel::kPaper;
    return Error{ErrorKind::kDiverged,
                 fmt::format("{}: the run diverged {}; try time_step = {}{}{}", call.scene,
                             done.diverged->Sentence(), ShortNumber(done.diverged->suggested_step),
                             published ? ", more damping or level standard" : "",
                             call.out.empty() && !call.store ? "" : " (what it reached is kept)")};
  }
  if (goes_on) {
    return Error{ErrorKind::kStopped,
                 fmt::format("{}: stopped; the same call goes on from {}", call.scene, call.checkpoint)};
  }
  if (done.stopped) return Error{ErrorKind::kStopped, call.scene + ": stopped; what was simulated is kept"};
  return Ok{};
}

}  // namespace

Command MakeSimulateCommand() {
  auto call = std::make_shared<SimulateCall>();
  return {
      .path = "simulate",
      .help = "rods that bend, touch and entangle, as a scene file says",
      .example = "tendril simulate examples/scenes/paper.toml --level fast --out curves.h5 --video film.mp4",
      .declare =
          [call](CLI::App& app) {
            app.add_option("scene", call->scene, "scene file (TOML)")->required();
            app.add_option(
                   "--set", call->settings,
                   "a value of the scene file instead of its own, as gripper.tentacles=4 (may be repeated)")
                ->allow_extra_args(false);
            app.add_option("--then", call->then, "a test of holding on the finished grasp")
                ->check(CLI::IsMember({"lift", "load", "strike", "release"}));
            app.add_option("--level", call->level, "instead of the scene's")
                ->check(CLI::IsMember({"paper", "standard", "fast", "static"}));
            app.add_option("--out", call->out,
                           "write the rods' curves over time (.csv or .h5; metres, seconds)");
            app.add_option("--video", call->video, "write a film of the scene (.mp4)");
            app.add_option("--picture", call->picture, "write a picture of the end (.png)");
            auto* const lab = app.add_option_function<std::string>(
                "--lab",
                [call](const std::string& folder) {
                  call->lab = folder;
                  call->store = true;
                },
                "keep the run as a trial of kind simulated (folder of a lab)");
            app.add_option("--label", call->label, "the trial's short name, unique in the lab (text)")
                ->needs(lab);
            app.add_option(
                "--checkpoint", call->checkpoint,
                "keep the run's state here every 10 s and when stopped; if it is there, go on from "
                "it (file)");
            app.add_option("--at", call->at, "times to write besides the frames, s, separated by commas")
                ->delimiter(',');
            app.add_option("--fps", call->fps, "frames per simulated second")
                ->check(CLI::Range(1e-3, 1e6))
                ->capture_default_str();
            app.add_option("--trial", call->trial, "number of the trial, for the random draws")
                ->check(CLI::Range(0, 1000000000))
                ->capture_default_str();
            app.add_option("--threads", call->threads,
                           "threads that share the rods, eight to each; the result is the same to the byte")
                ->check(CLI::Range(1, 256))
                ->capture_default_str();
            app.add_flag("--plan", call->plan, "say what the scene requires, and do not run");
            app.add_flag("--full", call->full, "switch everything on, whatever the plan says");
          },
      .run = [call](Output& out) { return RunSimulate(*call, out); },
  };
}

}  // namespace tendril::cli
