#pragma once
// The state of an interrupted simulation on disk (HDF5): what it goes on from, the curves up to there, and of
// which run it is.

#include <filesystem>
#include <string>

#include "model/result.h"
#include "model/scene/simulate.h"

namespace tendril {

//   run  what tells this run from others: a hash of scene, options and program
//   errors  kIo disk full, not writable
Status WriteState(const std::filesystem::path& file, const SimulationState& state, const std::string& run);

//   errors  kNotFound no such file; kBadInput  damaged, or of another run
Result<SimulationState> ReadState(const std::filesystem::path& file, const std::string& run);

}  // namespace tendril
