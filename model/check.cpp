#include "model/check.h"

#include <cstdio>
#include <cstdlib>

namespace tendril {

void CheckFailed(const char* condition, const char* file, int line) {
  std::fprintf(stderr, "%s:%d: broken assumption: %s\n", file, line, condition);
  std::abort();
}

}  // namespace tendril
