#include "cli/simulate_lab.h"

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "cli/program_version.h"
#include "cli/simulate_report.h"
#include "db/files/curve_files.h"
#include "db/files/design_toml.h"
#include "db/files/safe_file.h"
#include "db/files/scene_toml.h"
#include "db/simulation_store.h"
#include "db/trial_store.h"

namespace tendril::cli {
namespace {

namespace fs = std::filesystem;

TrialSpec SpecOf(const SimulatedTrial& trial) {
  const Scene& scene = *trial.scene;
  const SceneGripper& gripper = *scene.gripper;
  TrialSpec spec;
  spec.label = trial.label;
  spec.kind = TrialKind::kSimulated;
  spec.design = gripper.design;
  spec.design_name = gripper.design_name;
  spec.gripper = gripper.gripper;
  spec.medium = "vacuum";
  spec.pull = gripper.pull;
  spec.pull_rate = gripper.pull_rate;
  spec.notes = "simulated from " + fs::path(trial.scene_file).filename().string();
  if (scene.objects.empty()) {
    spec.object = {
        .kind = "none", .radius = 0, .length = 0, .position = {0, 0, 0}, .axis = {1, 0, 0}, .mass = 0};
    spec.object_distance = 0;
    return spec;
  }
  const SceneObject& object = scene.objects[0];
  const Eigen::Vector3d along = object.body.end - object.body.start;
  spec.object.kind = object.kind;
  spec.object.radius = object.body.radius;
  spec.object.length = along.norm() + 2 * object.body.radius;
  spec.object.position = 0.5 * (object.body.start + object.body.end);
  spec.object.axis = along.norm() > 0 ? Eigen::Vector3d(along.normalized()) : Eigen::Vector3d::UnitX();
  spec.object.mass = 0;  // fixed
  spec.object_distance = -spec.object.position.z();
  return spec;
}

Status Fill(Lab& lab, const std::string& id, const SimulatedTrial& trial) {
  const fs::path folder = lab.TrialFolder(id);
  const Simulated& run = *trial.run;
  const auto add = [&](const std::string& role, const std::string& name,
                       std::optional<std::int64_t> frames = std::nullopt) -> Status {
    const Result<std::string> hash = Sha256OfFile(folder / name);
    if (!hash.ok()) return hash.error();
    return AddRecordingFile(lab, id, role, name, hash.value(), frames);
  };
  if (Status s = WriteText(folder / "scene.toml", trial.scene_text); !s.ok()) return s;
  if (Status s = add("scene", "scene.toml"); !s.ok()) return s;
  const auto frames = static_cast<std::int64_t>(run.curves[0].time.size());
  if (Status s = WriteCurves(folder / "curves.h5", run.curves, ProgramVersion() + " simulate"); !s.ok()) {
    return s;
  }
  if (Status s = add("curves", "curves.h5", frames); !s.ok()) return s;

  Provenance made{.program_version = ProgramVersion()};
  made.parameters_json = nlohmann::json{
      {"level", NameOf(trial.scene->level)},
      {"trial_number", trial.trial_number},
      {"time_step_s",
       run.time_step}}.dump();
  made.input_sha256 = {{"scene.toml", Sha256(trial.scene_text)},
                       {"design", Sha256(DesignToml(trial.scene->gripper->design))}};
  const auto or_unknown = [](double value) { return std::isfinite(value) ? value : kNotKnown; };
  SimulationRow row;
  row.scene_name = trial.scene->name;
  row.scene_toml = trial.scene_text;
  row.level = NameOf(trial.scene->level);
  row.seed = static_cast<std::int64_t>(trial.scene->seed);
  row.trial_number = static_cast<std::int64_t>(trial.trial_number);
  row.time_step_s = run.time_step;
  row.steps = run.steps;
  row.simulated_s = run.curves[0].time.tail<1>()[0];
  row.wall_s = trial.wall_s;
  row.terms_json = TermsOf(*trial.plan).dump();
  row.least_axis_distance_m = or_unknown(run.least_axis_distance);
  row.least_axis_share = or_unknown(run.least_axis_share);
  if (run.nothing_passed) row.longest_move_m = run.longest_move;
  row.nothing_passed = run.nothing_passed;
  if (run.diverged) row.divergence = run.diverged->Sentence();
  if (Status s = StoreSimulation(lab, id, row, made); !s.ok()) return s;
  return StoreLink(lab, id, RowsOf(*trial.links), made);
}

}  // namespace

Status CheckIsTrial(const Scene& scene) {
  if (scene.gripper) return Ok{};
  return Error{ErrorKind::kBadInput, "--lab: a trial has a gripper, and the scene has no [gripper]"};
}

Result<std::string> StoreSimulatedTrial(Lab& lab, const SimulatedTrial& trial) {
  if (Status s = CheckIsTrial(*trial.scene); !s.ok()) return s.error();
  const Result<TrialSpec> begun = BeginTrial(lab, SpecOf(trial));
  if (!begun.ok()) return begun.error();
  const std::string& id = begun.value().id;
  if (Status filled = Fill(lab, id, trial); !filled.ok()) {
    (void)SetTrialState(lab, id, TrialState::kFailed, filled.error().message);
    return std::move(filled).error().Within("trial " + begun.value().label);
  }
  const Simulated& run = *trial.run;
  const Status set = run.diverged  ? SetTrialState(lab, id, TrialState::kFailed, run.diverged->Sentence())
                     : run.stopped ? SetTrialState(lab, id, TrialState::kAborted, "stopped")
                                   : SetTrialState(lab, id, TrialState::kRecorded);
  if (!set.ok()) return set.error();
  return begun.value().label;
}

}  // namespace tendril::cli
