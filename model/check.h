#pragma once
// TENDRIL_CHECK: what only a programmer can get wrong. Stays on in release builds; a failure names the
// condition and the place, then aborts. What the world can get wrong is a Result (model/result.h).

namespace tendril {

[[noreturn]] void CheckFailed(const char* condition, const char* file, int line);

}  // namespace tendril

#define TENDRIL_CHECK(condition) \
  ((condition) ? static_cast<void>(0) : ::tendril::CheckFailed(#condition, __FILE__, __LINE__))
