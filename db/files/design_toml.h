#pragma once
// Design files (TOML, docs/formats.md): [tentacle], [crease], [tendon]; every key has the paper's value as
// its default; angles in degrees in the keys that end in _deg.

#include <filesystem>
#include <string>

#include "model/fold/design.h"
#include "model/result.h"

namespace tendril {

//   errors  kNotFound no such file; kBadInput names file:line, field, value and what was expected; an unknown
//           key is an error that suggests the nearest known one
Result<TentacleDesign> ReadDesign(const std::filesystem::path& file);
Result<TentacleDesign> ParseDesign(const std::string& toml, const std::string& name_in_messages);

// The file's text, every key written out (law and pull_scale of a calibration only where there is one).
// Reading it back gives the same numbers to the last bit; an angle that no double in degrees stands for comes
// back within 2 units in its last place.
std::string DesignToml(const TentacleDesign& design);

}  // namespace tendril
