#pragma once
// A design's three tables, as they stand in a design file and, under [design], in trial.toml.

#include <string>

#include "db/files/toml_read.h"
#include "db/files/toml_write.h"
#include "model/fold/design.h"

namespace tendril {

// Reads [tentacle], [crease] and [tendon] of `from`; errors wait in the document's Finish().
void ReadDesignTables(TomlTable& from, TentacleDesign& design);

// The three tables, their headers with the prefix: "" or "design.".
std::string DesignTablesToml(const TentacleDesign& design, const std::string& prefix);

}  // namespace tendril
