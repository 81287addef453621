#pragma once
// Scene files (docs/formats.md, "Scenes"): what `tendril simulate` runs.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "model/result.h"
#include "model/scene/scene.h"

namespace tendril {

// A design named in [gripper] is looked for beside the scene, then in the folder above it.
//   settings  values that stand in for the file's, as "object.0.position.2=-0.15" (db/files/toml_edit.h)
//   level     instead of the file's, as --level has it
//   errors    kNotFound no such file; kBadInput  file:line: field = value: what was expected
Result<Scene> ReadScene(const std::filesystem::path& file, const std::vector<std::string>& settings = {},
                        std::optional<SimulationLevel> level = std::nullopt);

// As scene files and --level name them; any other name is the standard level.
SimulationLevel LevelNamed(const std::string& name);
std::string NameOf(SimulationLevel level);

}  // namespace tendril
