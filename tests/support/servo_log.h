#pragma once
// A servo log with a known command.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "db/files/recording_logs.h"

namespace tendril::test {

inline constexpr std::int64_t kLogStart = 1'700'000'000'000'000'000;  // ns

// A command that rests 1 s (and `late` s more), rises at 0.1 per s for 2 s, then holds until 5 s; ten rows a
// second.
inline std::vector<ServoRow> RampLog(int servo, double late = 0) {
  std::vector<ServoRow> rows;
  for (int i = 0; i <= 50; ++i) {
    ServoRow row;
    row.host_ns = kLogStart + std::int64_t{100'000'000} * i;
    row.servo = servo;
    row.command = std::clamp(0.1 * (0.1 * i - 1 - late), 0.0, 0.2);
    rows.push_back(row);
  }
  return rows;
}

}  // namespace tendril::test
