#pragma once
// Recordings that exist already as sources: video files, folders of pictures, servo logs.

#include <filesystem>
#include <memory>

#include "capture/record/frame_source.h"
#include "model/result.h"

namespace tendril {

// Plays a video. Beside it, a frame log of the same name (cam0.mkv, cam0.csv) gives stamps and losses;
// without one, times are the video's.
//   errors  as VideoReader::Open and ReadFrameLog; while playing: fewer pictures than the log has rows, or
//   more
Result<std::unique_ptr<FrameSource>> MakeVideoSource(const std::filesystem::path& file);

// The pictures of a folder (png, jpg, jpeg, bmp, pgm, tif, tiff) by name, one per interval.
//   interval  s
//   errors    kNotFound no such folder; kBadInput no picture in it; while playing: one that cannot be read,
//   or
//             is not of the first one's size
Result<std::unique_ptr<FrameSource>> MakeImageSource(const std::filesystem::path& folder, double interval);

//   errors  as ReadServoLog
Result<std::unique_ptr<ServoSource>> MakeServoFileSource(const std::filesystem::path& file);

}  // namespace tendril
