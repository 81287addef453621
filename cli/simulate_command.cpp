// tendril simulate: a scene's rods over time, with their links, and what became of its objects.
#include "cli/simulate_command.h"

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "cli/lab_option.h"
#include "cli/simulate_call.h"
#include "cli/simulate_checkpoint.h"
#include "cli/simulate_lab.h"
#include "cli/simulate_outputs.h"
#include "cli/simulate_report.h"
#include "cli/simulate_verdict.h"
#include "db/files/safe_file.h"
#include "db/files/scene_toml.h"
#include "db/files/toml_edit.h"
#include "model/scene/holding.h"
#include "model/scene/simulate.h"

namespace tendril::cli {
namespace {

using Clock = std::chrono::steady_clock;

double Since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

// The scene as it is to be run, and the test of holding that it ends with.
struct Prepared {
  Scene scene;
  std::string text;  // the file's, with --set in it
  std::optional<HoldingPlan> holding;
};

Result<Prepared> Prepare(const SimulateCall& call) {
  Prepared ready;
  const auto level = call.level.empty() ? std::nullopt : std::optional(LevelNamed(call.level));
  Result<Scene> read = ReadScene(call.scene, call.settings, level);
  if (!read.ok()) return read.error();
  ready.scene = std::move(read).value();
  Result<std::string> text = ReadText(call.scene);
  if (!text.ok()) return text.error();
  // What is kept is what is run.
  Result<std::string> edited = EditedToml(text.value(), call.scene, call.settings);
  if (!edited.ok()) return edited.error();
  ready.text = std::move(edited).value();
  if (call.then.empty()) return ready;
  HoldingPlan& holding = ready.holding.emplace();
  holding.test = HoldingTestNamed(call.then);
  const std::optional<std::size_t> grasped = GraspedObject(ready.scene);
  if (!grasped || ready.scene.objects[*grasped].motion == ObjectMotion::kFixed) {
    return Error{ErrorKind::kBadInput, call.scene + ": --then " + call.then +
                                           ": expected an [[object]] with motion = \"free\" or \"hanging\""};
  }
  holding.options.object = *grasped;
  const Result<HoldingTimes> times = AddHoldingTest(ready.scene, holding.test, holding.options);
  if (!times.ok()) return Error(times.error()).Within(call.scene);
  holding.times = times.value();
  return ready;
}

// Why the command fails although there is something to show; ok: it does not.
Status EndOf(const SimulateCall& call, const Scene& scene, const Simulated& done, bool goes_on) {
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

// Said before a run that takes minutes: the lab keeps it once.
//   returns  its key
Result<std::string> TellIfThere(const SimulateCall& call, const Scene& scene, const std::string& text,
                                Output& out) {
  Result<std::string> key = RunKey(call, scene, text);
  if (!key.ok()) return key;
  Result<Lab> lab = OpenLab(call.lab);
  if (!lab.ok()) return lab.error();
  const Result<std::optional<std::string>> there = TrialOfRun(lab.value(), key.value());
  if (!there.ok()) return there.error();
  if (there.value()) {
    out.Warn(
        fmt::format("this run is in the lab already, as trial {}, and will not be stored again (other draws: "
                    "--trial N)",
                    *there.value()));
  }
  return key;
}

Status RunSimulate(const SimulateCall& call, Output& out) {
  const Result<Prepared> ready = Prepare(call);
  if (!ready.ok()) return ready.error();
  const Scene& scene = ready.value().scene;
  if (Status good = CheckCall(call, scene); !good.ok()) return good;
  const Result<SimulationPlan> planned = PlanScene(scene, call.full);
  if (!planned.ok()) return Error(planned.error()).Within(call.scene);
  const SimulationPlan& plan = planned.value();
  out.fields()["scene"] = scene.name;
  TellPlan(scene, plan, call.plan, out);
  if (call.plan) return Ok{};
  std::string run_key;
  if (call.store) {
    Result<std::string> key = TellIfThere(call, scene, ready.value().text, out);
    if (!key.ok()) return key.error();
    run_key = std::move(key).value();
  }

  const std::vector<double> times = TimesOf(call, scene.duration);
  Checkpoint checkpoint(call.checkpoint, RunId(call, ready.value().text, scene, times));
  const Result<std::optional<SimulationState>> state = checkpoint.Load();
  if (!state.ok()) return state.error();
  SimulateHooks hooks;
  hooks.threads = call.threads;
  const auto begin = Clock::now();
  // Of a run that goes on, what was simulated before it was stopped does not count.
  std::optional<double> share_at_begin = state.value() ? std::nullopt : std::optional(0.0);
  hooks.progress = [&, show = out.ShowProgress(scene.name, [&](double share) {
    const double simulated = (share - *share_at_begin) * scene.duration;
    return simulated > 0 ? fmt::format("{:.3g} times real time", simulated / Since(begin)) : std::string();
  })](double share) {
    if (!share_at_begin) share_at_begin = share;
    return show(share);
  };
  hooks.warn = [&](const std::string& sentence) { out.Warn(call.scene + ": " + sentence); };
  hooks.keep = checkpoint.Keeper();
  if (state.value()) {
    hooks.resume_from = &*state.value();
    out.Print("going on from {}", call.checkpoint);
  }

  const Result<Simulated> run = Simulate(scene, plan, times, call.trial, hooks);
  if (!run.ok()) return Error(run.error()).Within(call.scene);
  const Simulated& done = run.value();
  FinishedRun finished{.scene = &scene,
                       .scene_text = ready.value().text,
                       .plan = &plan,
                       .run = &done,
                       .wall_s = Since(begin),
                       .run_key = run_key};
  if (!checkpoint.trouble().empty()) out.Warn("no state could be kept: " + checkpoint.trouble());
  if (state.value()) out.fields()["resumed_at_s"] = done.resumed_at;
  const bool goes_on = done.stopped && checkpoint.holds();
  const bool nothing = done.diverged && done.diverged->at_start;  // the scene cannot be: there is no run
  const bool shown = done.curves[0].time.size() > 0 && !goes_on && !nothing;
  if (shown && !done.diverged && !done.stopped) {
    if (ready.value().holding) {
      Result<HoldingVerdict> verdict = TellHolding(scene, *ready.value().holding, done, out);
      if (!verdict.ok()) return verdict.error();
      finished.holding = std::move(verdict).value();
    } else {
      TellWithoutTest(scene, done, out);
    }
  }
  if (!nothing) TellRun(scene, done, finished.wall_s, out);
  if (shown) {
    TellObjects(scene, done, out);
    TellPassages(done, out);
    if (Status s = WriteOutputs(call, finished, out); !s.ok()) return s;
  }
  if (!nothing) TellDoubts(done, out);
  if (!goes_on) checkpoint.Remove();
  return EndOf(call, scene, done, goes_on);
}

}  // namespace

Command MakeSimulateCommand() {
  auto call = std::make_shared<SimulateCall>();
  return {
      .path = "simulate",
      .help = "rods that bend, touch, entangle and hold objects, as a scene file says",
      .example =
          "tendril simulate examples/scenes/paper.toml --level fast --out curves.h5 --video film.mp4\n"
          "  tendril simulate examples/scenes/paper.toml --set gripper.tentacles=4 --set "
          "object.0.radius=0.03\n"
          "  tendril simulate grasp.toml --then lift --lab mylab   (grasp.toml: an object that is free or "
          "hangs)",
      .declare = [call](CLI::App& app) { DeclareSimulate(app, call); },
      .run = [call](Output& out) { return RunSimulate(*call, out); },
  };
}

}  // namespace tendril::cli
