#include "capture/track/same_moments.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace tendril {

std::vector<std::vector<std::int64_t>> SameMoments(const std::vector<FrameLog>& cameras, double share) {
  const std::vector<FrameRow>& first = cameras.front();
  double interval = std::numeric_limits<double>::infinity();
  if (first.size() > 1) {
    interval = static_cast<double>(first.back().host_ns - first.front().host_ns) /
               static_cast<double>(first.size() - 1);
  }
  std::vector<std::vector<std::int64_t>> moments(first.size());
  for (std::size_t f = 0; f < first.size(); ++f) {
    moments[f].assign(cameras.size(), -1);
    moments[f][0] = static_cast<std::int64_t>(f);
    for (std::size_t c = 1; c < cameras.size(); ++c) {
      const std::vector<FrameRow>& rows = cameras[c];
      const auto after =
          std::lower_bound(rows.begin(), rows.end(), first[f].host_ns,
                           [](const FrameRow& row, std::int64_t ns) { return row.host_ns < ns; });
      double nearest = share * interval;
      for (auto candidate = after == rows.begin() ? after : after - 1;
           candidate != rows.end() && candidate <= after; ++candidate) {
        const double apart = std::abs(static_cast<double>(candidate->host_ns - first[f].host_ns));
        if (apart > nearest) continue;
        nearest = apart;
        moments[f][c] = candidate - rows.begin();
      }
    }
  }
  return moments;
}

}  // namespace tendril
