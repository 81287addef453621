#pragma once
// Which tags several cameras see now. Each camera is read and tracked by itself: where tracking is slower
// than the camera, the newest picture wins and the others are counted. A camera that goes away is tried
// again.

#include <functional>
#include <map>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "capture/record/live_source.h"
#include "capture/track/tag_tracker.h"
#include "model/result.h"

namespace tendril {

struct LiveTagsOptions {
  TagTrackOptions track;
  double retry = 1;                    // between attempts to reach a camera that went away, s
  double now = 0.5;                    // a tag that was in a picture of the last so many s is seen now
  double open_wait = 10, silence = 3;  // as LiveSourceOptions, s
};

enum class LiveState {
  kOpening,  // for the first time
  kRunning,
  kLost,    // it ran and went away; tried again
  kEnded,   // a video file, at its end
  kFailed,  // the first opening failed, or its pictures cannot be used; not tried again
};
const char* NameOf(LiveState state);

// One camera as it is at this moment.
struct LiveCamera {
  std::string source;
  LiveState state = LiveState::kOpening;
  Error problem{ErrorKind::kIo, {}};  // of kLost and kFailed: the last one

  long arrived = 0;  // pictures since the beginning
  long tracked = 0;  // of them; the rest came while tracking was busy
  int times_lost = 0;
  int width_px = 0, height_px = 0;
  double fps = 0;           // tracked, over the last second
  double arriving_fps = 0;  // likewise
  double ms_per_frame = 0;  // for tracking, over the last second
  std::vector<int> seen;    // ids now, ascending
  std::vector<int> lost;    // ids that were seen before and are not now
  double blur_px = 0;       // median over the tags of the newest picture; 0: none
  TagTrackCounts counts;    // since the beginning
  // Of the newest picture that was tracked, where asked for; not to be written to.
  cv::Mat picture;
  std::vector<TrackedTag> tags;
};

class LiveTags {
 public:
  //   errors  kBadInput: as TagTracker::Create; no sources
  static Result<LiveTags> Start(const std::vector<std::string>& sources, const LiveTagsOptions& options);

  // In the order of the sources.
  std::vector<LiveCamera> Look(bool with_pictures = false) const;

  // Ends its threads.
  ~LiveTags();
  LiveTags(LiveTags&&) noexcept;
  LiveTags& operator=(LiveTags&&) noexcept;

 private:
  class Camera;
  explicit LiveTags(std::vector<std::unique_ptr<Camera>> cameras);
  std::vector<std::unique_ptr<Camera>> cameras_;
};

}  // namespace tendril
