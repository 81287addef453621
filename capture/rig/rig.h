#pragma once
// The cameras that look at a gripper: intrinsics and poses, as a rig file states them.

#include <filesystem>
#include <string>
#include <vector>

#include "capture/rig/camera_model.h"
#include "model/result.h"

namespace tendril {

struct Rig {
  std::string name;
  std::vector<Camera> cameras;  // cameras[i] recorded cam<i>.mkv
};

// A rig file (TOML; docs/formats.md). Unknown keys are errors that suggest the nearest known one.
Result<Rig> ReadRig(const std::filesystem::path& file);
Result<Rig> ParseRig(const std::string& toml, const std::string& name_in_messages);
std::string RigToml(const Rig& rig);

}  // namespace tendril
