// tendril record: one trial, from cameras' files or the virtual rig, into the lab.
#include "cli/record_command.h"

#include <filesystem>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "capture/record/file_sources.h"
#include "capture/record/record.h"
#include "capture/record/virtual_trial.h"
#include "capture/rig/rig.h"
#include "capture/rig/tag_layout.h"
#include "capture/rig/virtual_rig.h"
#include "db/files/design_toml.h"
#include "db/files/safe_file.h"
#include "db/files/toml_write.h"

namespace tendril::cli {
namespace {

namespace fs = std::filesystem;

constexpr double kDegree = std::numbers::pi / 180;

struct RecordCall {
  std::string lab;
  std::string design;
  std::string rig;
  std::string source = "virtual";
  std::string servo;
  std::string tags;
  std::string handedness = "mirror";
  TrialSpec trial;
  VirtualTrialOptions virtual_trial;
  double interval = 0.1;
  double first_azimuth_deg = 22.5;
  double tilt_deg = 5;
  double distance = 0.15;
};

// A file that is named by its path, or by its name in one of the lab's folders.
Result<fs::path> FindFile(const Lab& lab, const std::string& folder, const std::string& name) {
  std::error_code ignored;
  for (const fs::path& candidate :
       {fs::path(name), lab.folder() / folder / name, lab.folder() / folder / (name + ".toml")}) {
    if (fs::is_regular_file(candidate, ignored)) return candidate;
  }
  return Error{ErrorKind::kNotFound, fmt::format("{}: no such file, and no such name in {}", name,
                                                 (lab.folder() / folder).string())};
}

std::vector<std::string> SplitAtCommas(const std::string& text) {
  std::vector<std::string> parts;
  std::size_t from = 0;
  while (from <= text.size()) {
    const std::size_t to = std::min(text.find(',', from), text.size());
    if (to > from) parts.push_back(text.substr(from, to - from));
    from = to + 1;
  }
  return parts;
}

// The cameras named after "video:" or "images:".
Result<std::vector<std::unique_ptr<FrameSource>>> FileCameras(const RecordCall& call) {
  const bool video = call.source.starts_with("video:");
  if (!video && !call.source.starts_with("images:")) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("--source {}: expected virtual, video:FILE,FILE,... or images:FOLDER,FOLDER,...",
                             call.source)};
  }
  std::vector<std::unique_ptr<FrameSource>> cameras;
  for (const std::string& name : SplitAtCommas(call.source.substr(call.source.find(':') + 1))) {
    Result<std::unique_ptr<FrameSource>> camera =
        video ? MakeVideoSource(name) : MakeImageSource(name, call.interval);
    if (!camera.ok()) return camera.error();
    cameras.push_back(std::move(camera).value());
  }
  if (cameras.empty()) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("--source {}: names no file; expected one per camera", call.source)};
  }
  return cameras;
}

Result<RecordPlan> PlanOf(const RecordCall& call, TrialSpec trial) {
  if (call.source == "virtual") {
    if (!call.servo.empty()) {
      return Error{ErrorKind::kBadInput,
                   "--servo: the virtual rig logs its own servos; expected no --servo with it"};
    }
    return PlanVirtualTrial(std::move(trial), call.virtual_trial);
  }
  Result<std::vector<std::unique_ptr<FrameSource>>> cameras = FileCameras(call);
  if (!cameras.ok()) return cameras.error();
  RecordPlan plan;
  plan.cameras = std::move(cameras).value();
  if (!trial.rig_toml.empty()) {
    const Result<Rig> rig = ParseRig(trial.rig_toml, trial.rig_name);
    if (!rig.ok()) return rig.error();
    if (rig.value().cameras.size() != plan.cameras.size()) {
      return Error{ErrorKind::kBadInput,
                   fmt::format("rig {} has {} cameras, --source names {}; expected as many", trial.rig_name,
                               rig.value().cameras.size(), plan.cameras.size())};
    }
  }
  if (!call.servo.empty()) {
    Result<std::unique_ptr<ServoSource>> servo = MakeServoFileSource(call.servo);
    if (!servo.ok()) return servo.error();
    plan.servo = std::move(servo).value();
  }
  plan.trial = std::move(trial);
  return plan;
}

// What the call and the lab's files say about the trial.
Result<TrialSpec> TrialOf(const RecordCall& call, const Lab& lab) {
  TrialSpec trial = call.trial;
  const Result<fs::path> design_file = FindFile(lab, "designs", call.design);
  if (!design_file.ok()) return design_file.error();
  const Result<TentacleDesign> design = ReadDesign(design_file.value());
  if (!design.ok()) return design.error();
  trial.design = design.value();
  trial.design_name = design_file.value().stem().string();
  if (!call.tags.empty()) {
    const Result<TagSpec> tags = ReadTags(call.tags);
    if (!tags.ok()) return tags.error();
    trial.tags = tags.value();
  }
  trial.gripper.first_azimuth = call.first_azimuth_deg * kDegree;
  trial.gripper.tilt = call.tilt_deg * kDegree;
  trial.gripper.handedness = HandednessOf(call.handedness).value_or(Handedness::kMirror);
  if (!call.tags.empty()) {  // said now, not by `track` when the trial is over
    const auto layout = LayOutTags(trial.design, trial.gripper, LayoutOptionsOf(trial.tags));
    if (!layout.ok()) return Error(layout.error()).Within(call.tags);
  }
  trial.object_distance = call.distance;
  trial.object.position = {0, 0, -call.distance};

  if (!call.rig.empty()) {
    const Result<fs::path> rig_file = FindFile(lab, "rigs", call.rig);
    if (!rig_file.ok()) return rig_file.error();
    const Result<std::string> text = ReadText(rig_file.value());
    if (!text.ok()) return text.error();
    if (const Result<Rig> rig = ParseRig(text.value(), rig_file.value().string()); !rig.ok())
      return rig.error();
    trial.rig_toml = text.value();
    trial.rig_name = rig_file.value().stem().string();
  } else if (call.source == "virtual") {
    const Result<Rig> rig =
        VirtualRig(trial.design, trial.gripper, {.views = {}, .largest_pull = trial.pull});
    if (!rig.ok()) return rig.error();
    trial.rig_toml = RigToml(rig.value());
    trial.rig_name = rig.value().name;
  }
  return trial;
}

Status RunRecord(const RecordCall& call, Output& out) {
  Result<fs::path> folder =
      call.lab.empty() ? Lab::Find(fs::current_path()) : Result<fs::path>(fs::path(call.lab));
  if (!folder.ok()) return folder.error();
  Result<Lab> lab = Lab::Open(folder.value());
  if (!lab.ok()) return lab.error();
  Result<TrialSpec> trial = TrialOf(call, lab.value());
  if (!trial.ok()) return trial.error();
  Result<RecordPlan> plan = PlanOf(call, std::move(trial).value());
  if (!plan.ok()) return plan.error();
  const Result<RecordedTrial> recorded =
      Record(lab.value(), std::move(plan).value(), out.ShowProgress("recording"));
  if (!recorded.ok()) return recorded.error();

  const RecordedTrial& r = recorded.value();
  auto& fields = out.fields();
  fields["id"] = r.trial.id;
  fields["label"] = r.trial.label;
  fields["kind"] = NameOf(r.trial.kind);
  fields["state"] = NameOf(r.state);
  fields["reason"] = r.reason;
  fields["folder"] = lab.value().TrialFolder(r.trial.id).string();
  fields["cameras"] = nlohmann::ordered_json::array();
  out.Print("trial {} ({}): {}{}", r.trial.label, NameOf(r.trial.kind), NameOf(r.state),
            r.reason.empty() ? "" : ", " + r.reason);
  for (std::size_t i = 0; i < r.cameras.size(); ++i) {
    fields["cameras"].push_back({{"frames", r.cameras[i].frames}, {"dropped", r.cameras[i].dropped}});
    out.Print("  cam{}   {} frames, {} lost", i, r.cameras[i].frames, r.cameras[i].dropped);
  }
  fields["servo_rows"] = r.servo_rows;
  out.Print("  servo  {} rows", r.servo_rows);
  out.Print("  {}", lab.value().TrialFolder(r.trial.id).string());
  if (r.state == TrialState::kAborted) {
    return Error{ErrorKind::kStopped,
                 fmt::format("trial {}: stopped; what was recorded is kept", r.trial.label)};
  }
  if (r.state == TrialState::kDegraded) out.Warn(r.reason);
  return Ok{};
}

void DeclareTrial(CLI::App& app, RecordCall& call) {
  app.add_option("--lab", call.lab, "the lab's folder; else the lab that the current folder is in");
  app.add_option("--design", call.design, "design file (TOML), or its name in the lab's designs/")
      ->required();
  app.add_option("--rig", call.rig,
                 "rig file (TOML), or its name in the lab's rigs/; the virtual rig makes its own");
  app.add_option("--source", call.source, "virtual, video:FILE,FILE,... or images:FOLDER,FOLDER,...")
      ->capture_default_str();
  app.add_option("--interval", call.interval, "time between the pictures of a folder, seconds")
      ->capture_default_str();
  app.add_option("--servo", call.servo, "servo log (CSV) to record beside the pictures");
  app.add_option("--label", call.trial.label, "short name, unique in the lab; else trial-<n>");
  app.add_option("--notes", call.trial.notes, "what else is worth keeping");
  app.add_option("--medium", call.trial.medium, "what the gripper hangs in")->capture_default_str();
  app.add_option("--pull", call.trial.pull,
                 "commanded at the end, fraction of the flat tendon length (0 to 1)")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  app.add_option("--pull-rate", call.trial.pull_rate, "commanded, fraction per second")
      ->capture_default_str();
  app.add_option("--distance", call.distance, "carrier to object, metres")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--object-radius", call.trial.object.radius, "of the cylinder, metres")
      ->capture_default_str();
  app.add_option("--object-length", call.trial.object.length, "of the cylinder, metres")
      ->capture_default_str();
  app.add_option("--tentacles", call.trial.gripper.tentacles, "on the carrier, number")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_option("--carrier-radius", call.trial.gripper.carrier_radius, "of the circle of holes 0, metres")
      ->capture_default_str();
  app.add_option("--first-azimuth-deg", call.first_azimuth_deg, "of tentacle 0 about z, degrees from x")
      ->capture_default_str();
  app.add_option("--tilt-deg", call.tilt_deg, "of the tentacles toward the axis, degrees")
      ->capture_default_str();
  app.add_option("--handedness", call.handedness, "of neighbouring tentacles")
      ->check(CLI::IsMember({"mirror", "normals", "same"}))
      ->capture_default_str();
  CLI::Option* family =
      app.add_option("--tag-family", call.trial.tags.family, "AprilTag family on the facets")
          ->capture_default_str();
  app.add_option("--tags", call.tags, "how the tags are laid out (TOML), as `design tags --out` wrote it")
      ->excludes(family);
}

void DeclareVirtual(CLI::App& app, VirtualTrialOptions& options) {
  app.add_option("--frames", options.frames, "virtual: pictures per camera, from flat to the end, number")
      ->capture_default_str();
  app.add_option("--seed", options.seed, "virtual: of everything that is drawn, number")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--true-pull-scale", options.fold.pull_scale, "virtual: effective / commanded pull, ratio")
      ->capture_default_str();
  app.add_option("--true-stiffness-ratio", options.fold.stiffness_ratio,
                 "virtual: beta / alpha creases' stiffness, ratio")
      ->capture_default_str();
  app.add_option("--true-stiffness-exponent", options.fold.stiffness_exponent,
                 "virtual: power of the width that stiffness grows with, number")
      ->capture_default_str();
  app.add_option_function<std::string>(
         "--true-law", [&options](const std::string& name) { options.fold.law = *FoldLawOf(name); },
         "virtual: law by which the tentacles fold")
      ->check(CLI::IsMember({"paper", "exact"}))
      ->default_str("paper");
  app.add_option_function<double>(
         "--true-rest-angle-deg",
         [&options](const double& degrees) { options.fold.rest_angle = RadiansOfDegrees(degrees); },
         "virtual: the creases' rest angle, degrees")
      ->check(CLI::Range(0.0, 90.0));
  app.add_option("--true-friction", options.fold.friction,
                 "virtual: the tendon's friction coefficient at the holes, number")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
}

}  // namespace

Command MakeRecordCommand() {
  auto call = std::make_shared<RecordCall>();
  call->trial.gripper.tentacles = 2;
  return {
      .path = "record",
      .help = "record a trial, from files or from the virtual rig",
      .example = "tendril record --lab mylab --design paper --source virtual --pull 0.3 --seed 7",
      .declare =
          [call](CLI::App& app) {
            DeclareTrial(app, *call);
            DeclareVirtual(app, call->virtual_trial);
          },
      .run = [call](Output& out) { return RunRecord(*call, out); },
  };
}

}  // namespace tendril::cli
