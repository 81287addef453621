#include "calibrate/cameras/frame_stamps.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "capture/track/same_moments.h"
#include "db/files/recording_logs.h"

namespace tendril {

Result<FrameStamps> StampsByClock(const std::vector<std::filesystem::path>& logs, double share) {
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
  const auto moments = SameMoments(cameras, share);
  std::iota(found.stamps[0].begin(), found.stamps[0].end(), std::int64_t{0});
  std::vector<bool> shared(moments.size(), false);
  for (std::size_t c = 1; c < cameras.size(); ++c) {
    const auto apart = [&](std::size_t frame, std::size_t own) {
      return std::abs(static_cast<double>(cameras[c][own].host_ns - cameras[0][frame].host_ns));
    };
    for (std::size_t f = 0; f < moments.size(); ++f) {
      if (moments[f][c] < 0) continue;
      const auto own = static_cast<std::size_t>(moments[f][c]);
      std::int64_t& stamp = found.stamps[c][own];
      // Beyond half an interval one frame can be the nearest to two of camera 0: it goes with the nearer.
      if (stamp < kBeyond && apart(static_cast<std::size_t>(stamp), own) <= apart(f, own)) continue;
      stamp = static_cast<std::int64_t>(f);
    }
    for (std::size_t own = 0; own < cameras[c].size(); ++own) {
      if (found.stamps[c][own] >= kBeyond) continue;
      const auto f = static_cast<std::size_t>(found.stamps[c][own]);
      shared[f] = true;
      found.farthest_apart = std::max(found.farthest_apart, 1e-9 * apart(f, own));
    }
  }
  found.together = static_cast<int>(std::count(shared.begin(), shared.end(), true));
  return found;
}

}  // namespace tendril
