#pragma once
// Which tags a recorded video shows, picture by picture: followed from one to the next, or decoded in each.

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "capture/track/tag_tracker.h"
#include "db/files/recording_logs.h"
#include "model/result.h"

namespace tendril {

struct TagsInVideoOptions {
  std::optional<TagTrackLevel> level = TagTrackLevel::kStandard;  // none: every picture is decoded by itself
  TagDetectOptions detect;
};

// "decode", "preview", "standard", "best".
inline constexpr const char* kDecodeOnly = "decode";
std::vector<std::string> TagLevelNames();
const char* NameOfLevel(std::optional<TagTrackLevel> level);
//   errors  kBadInput: another name
Result<std::optional<TagTrackLevel>> TagLevelOf(const std::string& name);

// Sightings that were expected and not believed, by cause in words; causes that never came up are left out.
std::vector<std::pair<std::string, long>> RejectedByCause(const TagTrackCounts& counts);
std::string RejectedInWords(
    const TagTrackCounts& counts);  // "12 does not look like it, 3 moved too far"; "none"

struct TagsInVideo {
  std::vector<DetectionRow> rows;  // frame by frame; sigma_px NaN where each picture was decoded
  TagTrackCounts counts;           // of decoding alone: frames, decodes and found
  double seconds = 0;              // for finding tags, reading not counted
};

// Pictures are read one at a time; memory holds one of them.
//   frames  how many pictures it must have
//   step    called after each picture; false stops
//   errors  the detector's and the video reader's; kBadInput: another number of pictures; kStopped
Result<TagsInVideo> FindTagsInVideo(const std::filesystem::path& video, int camera, std::size_t frames,
                                    const TagsInVideoOptions& options, const std::function<bool()>& step);

}  // namespace tendril
