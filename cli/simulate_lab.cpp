#include "cli/simulate_lab.h"

#include <fmt/ranges.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "cli/program_version.h"
#include "cli/simulate_report.h"
#include "db/files/curve_files.h"
#include "db/files/design_toml.h"
#include "db/files/safe_file.h"
#include "db/files/scene_toml.h"
#include "db/files/toml_edit.h"
#include "db/simulation_store.h"
#include "db/trial_store.h"
#include "model/scene/schedule.h"

namespace tendril::cli {
namespace {

namespace fs = std::filesystem;

ObjectSpec ObjectOf(const Scene& scene) {
  const std::optional<std::size_t> grasped = GraspedObject(scene);
  if (!grasped) {
    return {.kind = "none", .radius = 0, .length = 0, .position = {0, 0, 0}, .axis = {1, 0, 0}, .mass = 0};
  }
  const SceneObject& object = scene.objects[*grasped];
  const FixedBody& body = object.body;
  ObjectSpec spec;
  spec.kind = object.kind;
  spec.radius = body.radius;
  spec.length = (body.end - body.start).norm() + 2 * body.radius;
  spec.position = object.pose.translation();
  // A trial has to have one; of a kind without an axis nobody reads it.
  const std::optional<Axis> axis = AxisOf(object);
  spec.axis = axis ? axis->direction : Eigen::Vector3d(Eigen::Vector3d::UnitX());
  if (object.kind == "cylinder") spec.length = 2 * object.shape[0].half.z();
  spec.mass = object.mass;  // 0: fixed
  if (body.radius > 0) return spec;
  // Of what is not round, how far it reaches.
  spec.radius = ReachOf(object.shape);
  spec.length = 2 * spec.radius;
  return spec;
}

// As trials name it; another fluid than air and water by its density.
std::string MediumOf(const Scene& scene) {
  const double density = scene.medium.density;
  return density == 0                 ? "vacuum"
         : density == Air().density   ? "air"
         : density == Water().density ? "water"
                                      : fmt::format("fluid of {:.6g} kg/m^3", density);
}

TrialSpec SpecOf(const SimulatedTrial& trial) {
  const SimulateCall& call = *trial.call;
  const Scene& scene = *trial.finished->scene;
  const SceneGripper& gripper = *scene.gripper;
  TrialSpec spec;
  spec.label = call.label;
  spec.kind = TrialKind::kSimulated;
  spec.design = gripper.design;
  spec.design_name = gripper.design_name;
  spec.gripper = gripper.gripper;
  spec.medium = MediumOf(scene);
  spec.pull = StrongestPull(gripper, scene.phases);
  spec.pull_rate = gripper.pull_rate;
  spec.object = ObjectOf(scene);
  spec.object_distance = 0.0 - spec.object.position.z();
  spec.notes = "simulated from " + fs::path(call.scene).filename().string();
  if (!call.settings.empty()) spec.notes += fmt::format(" with {}", fmt::join(call.settings, ", "));
  if (!call.then.empty()) spec.notes += ", then " + call.then;
  return spec;
}

HoldingRow RowOf(const HoldingVerdict& verdict) {
  const HoldingResult& result = verdict.result;
  HoldingRow row;
  row.test = NameOf(result.test);
  row.lifted = result.lifted;
  row.held = result.held;
  if (std::isfinite(result.rise)) row.rise_m = result.rise;
  row.shift_m = result.shift;
  row.payload_kg = result.payload;
  row.payload_is_least = result.payload_is_least;
  row.payload_by_rods_mass = result.payload_ratio;
  if (result.test == HoldingTest::kStrike) row.strikes = result.strikes;
  row.release_s = result.release_time;
  row.rule = verdict.rule;
  row.begins_s = verdict.begins;
  return row;
}

// What the test of holding says, as a program's outcome.
Outcome OutcomeOf(const Scene& scene, const HoldingVerdict& verdict) {
  const HoldingResult& result = verdict.result;
  Outcome outcome;
  outcome.grasped = result.Grasped();
  outcome.judged_by = ProgramVersion();
  outcome.by_person = false;
  outcome.method = "simulated " + NameOf(result.test);
  outcome.notes = result.Sentence();
  const double gravity = scene.gravity.norm() > 0 ? scene.gravity.norm() : 9.80665;
  if (!result.payload_is_least) outcome.load_N = result.payload * gravity;  // NaN: not measured
  return outcome;
}

Status Fill(Lab& lab, const std::string& id, const SimulatedTrial& trial) {
  const fs::path folder = lab.TrialFolder(id);
  const FinishedRun& finished = *trial.finished;
  const Scene& scene = *finished.scene;
  const Simulated& run = *finished.run;
  const auto add = [&](const std::string& role, const std::string& name,
                       std::optional<std::int64_t> frames = std::nullopt) -> Status {
    const Result<std::string> hash = Sha256OfFile(folder / name);
    if (!hash.ok()) return hash.error();
    return AddRecordingFile(lab, id, role, name, hash.value(), frames);
  };
  if (Status s = WriteText(folder / "scene.toml", finished.scene_text); !s.ok()) return s;
  if (Status s = add("scene", "scene.toml"); !s.ok()) return s;
  const auto frames = static_cast<std::int64_t>(run.curves[0].time.size());
  if (Status s = WriteCurves(folder / "curves.h5", run.curves, ProgramVersion() + " simulate", run.objects);
      !s.ok()) {
    return s;
  }
  if (Status s = add("curves", "curves.h5", frames); !s.ok()) return s;

  Provenance made{.program_version = ProgramVersion()};
  made.parameters_json = nlohmann::json{{"level", NameOf(scene.level)}, {"trial_number", trial.call->trial},
                                        {"time_step_s", run.time_step}, {"set", trial.call->settings},
                                        {"then", trial.call->then},     {"full", trial.call->full},
                                        {"fps", trial.call->fps}}
                             .dump();
  made.input_sha256 = {{"scene.toml", Sha256(finished.scene_text)},
                       {"design", Sha256(DesignToml(scene.gripper->design))}};
  const auto or_unknown = [](double value) { return std::isfinite(value) ? value : kNotKnown; };
  SimulationRow row;
  row.scene_name = scene.name;
  row.scene_toml = finished.scene_text;
  row.level = NameOf(scene.level);
  row.seed = static_cast<std::int64_t>(scene.seed);
  row.trial_number = static_cast<std::int64_t>(trial.call->trial);
  row.time_step_s = run.time_step;
  row.steps = run.steps;
  row.simulated_s = run.curves[0].time.tail<1>()[0];
  row.wall_s = finished.wall_s;
  row.terms_json = TermsOf(*finished.plan).dump();
  row.least_axis_distance_m = or_unknown(run.least_axis_distance);
  row.least_axis_share = or_unknown(run.least_axis_share);
  if (run.nothing_passed) row.longest_move_m = run.longest_move;
  row.nothing_passed = run.nothing_passed;
  if (run.diverged) row.divergence = run.diverged->Sentence();
  row.doubts = run.doubts;
  if (run.nothing_passed) row.longest_stick_share = run.longest_stick;
  row.friction = scene.contact.friction;
  row.medium = MediumOf(scene);
  row.run_key = trial.run_key;
  if (finished.holding) row.holding = RowOf(*finished.holding);
  if (Status s = StoreSimulation(lab, id, row, made); !s.ok()) return s;
  return StoreLink(lab, id, RowsOf(*trial.links), made);
}

}  // namespace

Status CheckIsTrial(const Scene& scene) {
  if (scene.gripper) return Ok{};
  return Error{ErrorKind::kBadInput, "--lab: a trial has a gripper, and the scene has no [gripper]"};
}

Result<std::string> RunKey(const SimulateCall& call, const Scene& scene, const std::string& scene_text) {
  // The level that counts is the run's.
  const Result<std::string> bare = BareToml(scene_text, call.scene, {"name", "level"});
  if (!bare.ok()) return bare;
  return Sha256(fmt::format("{}\n{}\nlevel {}\ntrial {}\nthen {}\nfull {}\n", bare.value(),
                            scene.gripper ? DesignToml(scene.gripper->design) : "", NameOf(scene.level),
                            call.trial, call.then, call.full));
}

Result<std::optional<std::string>> TrialOfRun(Lab& lab, const std::string& run_key) {
  return FindRun(lab, run_key, ProgramVersion());
}

Result<std::string> StoreSimulatedTrial(Lab& lab, const SimulatedTrial& trial) {
  if (Status s = CheckIsTrial(*trial.finished->scene); !s.ok()) return s.error();
  const Result<TrialSpec> begun = BeginTrial(lab, SpecOf(trial));
  if (!begun.ok()) return begun.error();
  const std::string& id = begun.value().id;
  if (Status filled = Fill(lab, id, trial); !filled.ok()) {
    (void)SetTrialState(lab, id, TrialState::kFailed, filled.error().message);
    return std::move(filled).error().Within("trial " + begun.value().label);
  }
  const Simulated& run = *trial.finished->run;
  const Status set = run.diverged  ? SetTrialState(lab, id, TrialState::kFailed, run.diverged->Sentence())
                     : run.stopped ? SetTrialState(lab, id, TrialState::kAborted, "stopped")
                                   : SetTrialState(lab, id, TrialState::kRecorded);
  if (!set.ok()) return set.error();
  if (trial.finished->holding) {
    const Outcome outcome = OutcomeOf(*trial.finished->scene, *trial.finished->holding);
    if (Status s = AddOutcome(lab, id, outcome); !s.ok()) return s.error();
  }
  return begun.value().label;
}

}  // namespace tendril::cli
