#include "calibrate/cameras/frame_stamps.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "capture/track/same_moments.h"
#include "db/files/recording_logs.h"

namespace tendril {

Result<FrameStamps> StampsByClock(const std::vector<std::filesystem::path>& logs) {
  // Of camera 0's frame interval: half would leave it open which of two frames belongs.
  constexpr double kSameMoment = 0.4;
  constexpr std::int64_t kBeyond = 1'000'000'000;  // more frames than a recording has
  std::vector<FrameLog> cameras;
  for (const auto& file : logs) {
    auto log = ReadFrameLog(file);
    if (!log.ok()) return log.error();
    cameras.push_back(std::move(log).value());
  }
  FrameStamps found;
  std::int64_t alone = 0;
  for (const FrameLog& log : cameras) {
    alone += kBeyond;
    found.stamps.emplace_back(log.size());
    std::iota(found.stamps.back().begin(), found.stamps.back().end(), alone);
  }
  if (cameras.empty()) return found;
  const auto moments = SameMoments(cameras, kSameMoment);
  for (std::size_t f = 0; f < moments.size(); ++f) {
    bool shared = false;
    for (std::size_t c = 0; c < cameras.size(); ++c) {
      if (moments[f][c] < 0) continue;
      const auto own = static_cast<std::size_t>(moments[f][c]);
      found.stamps[c][own] = static_cast<std::int64_t>(f);
      if (c == 0) continue;
      shared = true;
      const auto apart = static_cast<double>(cameras[c][own].host_ns - cameras[0][f].host_ns);
      found.farthest_apart = std::max(found.farthest_apart, 1e-9 * std::abs(apart));
    }
    found.together += shared ? 1 : 0;
  }
  return found;
}

}  // namespace tendril
