#pragma once
// Is a lab whole? Its database, its schema, and the files that its rows speak of.

#include <string>
#include <vector>

#include "db/lab.h"
#include "model/progress.h"
#include "model/result.h"

namespace tendril {

struct LabCheck {
  int schema_version = 0;
  std::vector<std::string> schema_steps;  // titles, in order
  std::int64_t trials = 0;
  std::int64_t files = 0;             // looked at
  std::vector<std::string> problems;  // one line each; none: all is well
};

// SQLite's own integrity check, foreign keys, and the hash of every recorded file.
//   errors  kStopped the progress asked to stop
Result<LabCheck> CheckLab(Lab& lab, const Progress& progress = {});

}  // namespace tendril
