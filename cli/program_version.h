#pragma once
// What derived rows say they were made by.

#include <string>

namespace tendril::cli {

inline std::string ProgramVersion() { return "tendril " TENDRIL_VERSION; }

}  // namespace tendril::cli
