#pragma once
// Scene files (docs/formats.md, "Scenes"): what `tendril simulate` runs.

#include <filesystem>
#include <string>

#include "model/result.h"
#include "model/scene/scene.h"

namespace tendril {

// A design named in [gripper] is looked for beside the scene, then in the folder above it.
//   errors  kNotFound no such file; kBadInput  file:line: field = value: what was expected
Result<Scene> ReadScene(const std::filesystem::path& file);

// As scene files and --level name them; any other name is the standard level.
SimulationLevel LevelNamed(const std::string& name);
std::string NameOf(SimulationLevel level);

}  // namespace tendril
