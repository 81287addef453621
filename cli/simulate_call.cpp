#include "cli/simulate_call.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <initializer_list>

#include "cli/lab_option.h"
#include "cli/program_version.h"
#include "cli/simulate_lab.h"
#include "db/files/design_toml.h"
#include "db/files/safe_file.h"
#include "db/files/scene_toml.h"
#include "db/trial_query.h"
#include "model/rods/rod_lanes.h"

namespace tendril::cli {

namespace fs = std::filesystem;

void DeclareSimulate(CLI::App& app, const std::shared_ptr<SimulateCall>& call) {
  app.add_option("scene", call->scene, "scene file (TOML)")->required();
  app.add_option(
         "--set", call->settings,
         "PATH=VALUE: a value of the scene file instead of its own, keys and places in lists (from 0) as "
         "steps; may be repeated, as --set gripper.tentacles=4 --set object.0.position.2=-0.15")
      ->type_name("PATH=VALUE")
      ->allow_extra_args(false);
  app.add_option(
         "--then", call->then,
         "a test of holding behind all that the scene does, of its first object; each begins with lifting "
         "it: lift (does it come along?), load (which weight slips it?), strike (does it withstand blows "
         "from all sides?), release (does it come free when the tendons unwind?), as --then load")
      ->check(CLI::IsMember({"lift", "load", "strike", "release"}));
  app.add_option("--level", call->level, "instead of the scene's")
      ->check(CLI::IsMember({"paper", "standard", "fast", "static"}));
  app.add_option(
         "--out", call->out,
         "write the rods' curves over time (.csv or .h5; metres, seconds); a .h5 also has where the objects "
         "were and the rods' force on them")
      ->type_name("FILE");
  app.add_option("--video", call->video, "write a film of the scene (.mp4)");
  app.add_option("--picture", call->picture, "write a picture of the end (.png)");
  auto* const lab = app.add_option_function<std::string>(
      "--lab",
      [call](const std::string& folder) {
        call->lab = folder;
        call->store = true;
      },
      "keep the run as a trial of kind simulated (folder of a lab)");
  app.add_option("--label", call->label, "the trial's short name, unique in the lab (text)")->needs(lab);
  app.add_option("--checkpoint", call->checkpoint,
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
}

std::vector<double> TimesOf(const SimulateCall& call, double duration) {
  std::vector<double> times = call.at;
  for (int i = 0; i / call.fps < duration * (1 - 1e-12); ++i) times.push_back(i / call.fps);
  times.push_back(duration);
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

std::string RunId(const SimulateCall& call, const std::string& scene_text, const Scene& scene,
                  const std::vector<double>& times) {
  // Kernels of other widths round otherwise.
  std::string all =
      fmt::format("{} {} {} ", ProgramVersion(), RodKernelWidth(), NameOf(scene.level)) + scene_text;
  if (scene.gripper) all += DesignToml(scene.gripper->design);
  all += fmt::format("{} {}", call.trial, call.full);
  all += " " + call.then;
  for (const double time : times) all += fmt::format(" {:.17g}", time);
  return Sha256(all);
}

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
  constexpr double kFewestFrames = 10;  // that JudgeHolding asks for, 1/s
  if (!call.then.empty() && call.fps < kFewestFrames) {
    return Error{
        ErrorKind::kBadInput,
        fmt::format("--fps {}: --then judges by the frames; expected {} or more", call.fps, kFewestFrames)};
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

}  // namespace tendril::cli
