#pragma once
// Which frames of several cameras were taken at once, from the frame logs that a recording keeps.

#include <cstdint>
#include <filesystem>
#include <vector>

#include "model/result.h"

namespace tendril {

struct FrameStamps {
  // Frames of one moment have camera 0's frame number; one that no frame of camera 0 goes with has a number
  // of its own, beyond those.                                                         (cameras) x (frames)
  std::vector<std::vector<std::int64_t>> stamps;
  int together = 0;           // frames of camera 0 that another camera has too
  double farthest_apart = 0;  // of these, between the hosts' times, s
};

// Of camera 0's frame interval, how far apart two pictures may be taken and still belong together. Triggered
// together: half would leave it open which of two frames belongs. Free running: their phase may be any, and
// the nearest frame is within one interval even where one was lost.
inline constexpr double kTriggered = 0.4;
inline constexpr double kFreeRunning = 1;

//   logs    cam<i>.csv, one per camera (docs/formats.md)
//   share   one of these
//   errors  what ReadFrameLog says
Result<FrameStamps> StampsByClock(const std::vector<std::filesystem::path>& logs, double share = kTriggered);

}  // namespace tendril
