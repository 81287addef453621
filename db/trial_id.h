#pragma once
// Ids of trials: UUIDv7 (RFC 9562), which sort by time and are unique across machines.

#include <cstdint>
#include <string>

namespace tendril {

// 48 bits of milliseconds, 12 bits of the fraction of one (so that ids of the same millisecond sort too), the
// rest random.
std::string NewTrialId(std::int64_t now_ns);

// Whether text has the form of a UUID: 8-4-4-4-12 lower-case hexadecimal digits.
bool IsTrialId(const std::string& text);

// The host's clock, ns since 1970, UTC.
std::int64_t NowNs();

}  // namespace tendril
