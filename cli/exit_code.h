#pragma once
// What the program's exit code says: 0 done, 1 failed while running or no solution exists, 2 the input or the
// call is wrong.

#include "model/result.h"

namespace tendril::cli {

inline int ExitCode(ErrorKind kind) {
  return kind == ErrorKind::kBadInput || kind == ErrorKind::kNotFound ? 2 : 1;
}

}  // namespace tendril::cli
