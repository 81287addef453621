#pragma once
// A camera as it sends now: the newest pictures of a device, a network stream, a pipe, or a video file that
// plays at its own pace.

#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "model/result.h"

namespace tendril {

struct LiveSourceOptions {
  double open_wait = 10;  // how long opening waits for the first data, s
  double silence = 3;     // without data for so long the camera is gone, s
  // Asked several times a second, also while it waits; true ends the call at hand with kStopped.
  std::function<bool()> stopped = [] { return false; };
};

class LiveSource {
 public:
  virtual ~LiveSource() = default;

  // Waits for the next picture (CV_8UC1). None at the end of a video file; of anything else an end is an
  // error.
  //   errors  kIo: it ended, or nothing arrives any more; kStopped; kBadInput: pictures of an unknown format
  virtual Result<std::optional<cv::Mat>> Next() = 0;
};

//   source  "/dev/video0" (V4L2), "rtsp://...", "udp://...", "tcp://...", "http://..." and what else
//   libavformat
//           knows, a named pipe, or a video file
//   errors  kNotFound no such file or device; kBadInput no video, or a protocol that is not known; kIo
//   refused,
//           nothing arrives; kStopped. One line that names the source.
Result<std::unique_ptr<LiveSource>> OpenLiveSource(const std::string& source,
                                                   const LiveSourceOptions& options);

}  // namespace tendril
