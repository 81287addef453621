#pragma once
// From what a derived row was made: kept with every row that can be made again.

#include <string>
#include <utility>
#include <vector>

namespace tendril {

struct Provenance {
  std::string program_version{};                                    // "tendril 0.1.0"
  std::string parameters_json = "{}";                               // the options that the result depends on
  std::vector<std::pair<std::string, std::string>> input_sha256{};  // (file or role, SHA-256)
};

}  // namespace tendril
