#pragma once
// Which pictures of several cameras show the same moment, by the host's clock.

#include <cstdint>
#include <vector>

#include "db/files/recording_logs.h"

namespace tendril {

using FrameLog = std::vector<FrameRow>;

// For each frame of camera 0 the frame of every camera that shows the same moment, or -1  (frames x cameras)
//   cameras  one log per camera, at least one, each in the order of its clock
//   share    pictures belong together if their times differ by less than this share of camera 0's interval
std::vector<std::vector<std::int64_t>> SameMoments(const std::vector<FrameLog>& cameras, double share);

}  // namespace tendril
