#include "db/trial_id.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <random>

namespace tendril {

std::string NewTrialId(std::int64_t now_ns) {
  constexpr std::int64_t kNsPerMs = 1'000'000;
  const std::int64_t clock = std::max<std::int64_t>(now_ns, 0);
  const auto ms = static_cast<std::uint64_t>(clock / kNsPerMs) & 0xffff'ffff'ffffULL;
  const auto fraction = static_cast<std::uint64_t>(clock % kNsPerMs) * 4096 / kNsPerMs;
  std::random_device device;  // the kernel's, not a seed that two machines could share
  const std::uint64_t random = (static_cast<std::uint64_t>(device()) << 32) | device();
  const std::uint64_t variant = 0x8000 | ((random >> 48) & 0x3fff);
  return fmt::format("{:08x}-{:04x}-7{:03x}-{:04x}-{:012x}", ms >> 16, ms & 0xffff, fraction, variant,
                     random & 0xffff'ffff'ffffULL);
}

bool IsTrialId(const std::string& text) {
  if (text.size() != 36) return false;
  for (size_t i = 0; i < text.size(); ++i) {
    const bool dash = i == 8 || i == 13 || i == 18 || i == 23;
    const bool digit = (text[i] >= '0' && text[i] <= '9') || (text[i] >= 'a' && text[i] <= 'f');
    if (dash ? text[i] != '-' : !digit) return false;
  }
  return true;
}

std::int64_t NowNs() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace tendril
