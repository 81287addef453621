#include "capture/track/tags_in_video.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "capture/record/video_file.h"

namespace tendril {
namespace {

using Clock = std::chrono::steady_clock;
constexpr TagTrackLevel kLevels[] = {TagTrackLevel::kPreview, TagTrackLevel::kStandard, TagTrackLevel::kBest};

// A tracker, or a detector that counts like one.
class TagFinder {
 public:
  static Result<TagFinder> Create(const TagsInVideoOptions& options) {
    TagFinder finder;
    if (options.level) {
      TagTrackOptions track;
      track.level = *options.level;
      track.detect = options.detect;
      Result<TagTracker> tracker = TagTracker::Create(track);
      if (!tracker.ok()) return tracker.error();
      finder.tracker_.emplace(std::move(tracker).value());
      return finder;
    }
    Result<TagDetector> detector = TagDetector::Create(options.detect);
    if (!detector.ok()) return detector.error();
    finder.detector_.emplace(std::move(detector).value());
    return finder;
  }

  Status Add(const GrayImage& image, int camera, std::int64_t frame, std::vector<DetectionRow>& rows) {
    if (tracker_) {
      const Result<std::vector<TrackedTag>> tags = tracker_->Next(image);
      if (!tags.ok()) return tags.error();
      for (const TrackedTag& tag : tags.value()) {
        DetectionRow row{.camera = camera, .frame = frame, .tag = tag.id, .corners_px = tag.corners_px};
        row.sigma_px = SigmaOfCorners(tag);
        if (tag.decoded) {
          row.hamming = tag.hamming;
          row.margin = tag.margin;
        }
        rows.push_back(row);
      }
      return Ok{};
    }
    const Result<std::vector<TagDetection>> tags = detector_->Detect(image);
    if (!tags.ok()) return tags.error();
    ++counts_.frames;
    ++counts_.decodes;
    counts_.found += static_cast<long>(tags.value().size());
    for (const TagDetection& tag : tags.value()) {
      rows.push_back({.camera = camera,
                      .frame = frame,
                      .tag = tag.id,
                      .hamming = tag.hamming,
                      .margin = tag.margin,
                      .corners_px = tag.corners_px});
    }
    return Ok{};
  }

  const TagTrackCounts& counts() const { return tracker_ ? tracker_->counts() : counts_; }

 private:
  std::optional<TagTracker> tracker_;
  std::optional<TagDetector> detector_;
  TagTrackCounts counts_;
};

}  // namespace

const char* NameOfLevel(std::optional<TagTrackLevel> level) { return level ? NameOf(*level) : kDecodeOnly; }

std::vector<std::string> TagLevelNames() {
  std::vector<std::string> names = {kDecodeOnly};
  for (const TagTrackLevel level : kLevels) names.emplace_back(NameOf(level));
  return names;
}

Result<std::optional<TagTrackLevel>> TagLevelOf(const std::string& name) {
  if (name == kDecodeOnly) return std::optional<TagTrackLevel>();
  for (const TagTrackLevel level : kLevels) {
    if (name == NameOf(level)) return std::optional<TagTrackLevel>(level);
  }
  return Error{ErrorKind::kBadInput,
               fmt::format("level '{}'; expected {}", name, fmt::join(TagLevelNames(), ", "))};
}

std::vector<std::pair<std::string, long>> RejectedByCause(const TagTrackCounts& counts) {
  std::vector<std::pair<std::string, long>> causes;
  for (int f = 1; f < kTagFitFaults; ++f) {
    const long count = counts.faults[static_cast<std::size_t>(f)];
    if (count > 0) causes.emplace_back(NameOf(static_cast<TagFitFault>(f)), count);
  }
  if (counts.changed > 0) causes.emplace_back("decoded elsewhere", counts.changed);
  return causes;
}

std::string RejectedInWords(const TagTrackCounts& counts) {
  std::string text;
  for (const auto& [cause, count] : RejectedByCause(counts)) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, cause);
  }
  return text.empty() ? "none" : text;
}

Result<TagsInVideo> FindTagsInVideo(const std::filesystem::path& video, int camera, std::size_t frames,
                                    const TagsInVideoOptions& options, const std::function<bool()>& step) {
  Result<TagFinder> finder = TagFinder::Create(options);
  if (!finder.ok()) return finder.error();
  Result<VideoReader> reader = VideoReader::Open(video);
  if (!reader.ok()) return reader.error();
  TagsInVideo found;
  for (std::size_t frame = 0;; ++frame) {
    Result<std::optional<VideoFrame>> next = reader.value().Next();
    if (!next.ok()) return next.error();
    if (!next.value()) {
      if (frame != frames) {
        return Error{ErrorKind::kBadInput, fmt::format("{}: {} frames, but its frame log has {} rows",
                                                       video.string(), frame, frames)};
      }
      found.counts = finder.value().counts();
      return found;
    }
    const cv::Mat& image = next.value()->image;
    const Clock::time_point start = Clock::now();
    const Status added =
        finder.value().Add({image.data, image.cols, image.rows, static_cast<int>(image.step)}, camera,
                           static_cast<std::int64_t>(frame), found.rows);
    if (!added.ok()) return Error(added.error()).Within(fmt::format("{}: frame {}", video.string(), frame));
    found.seconds += std::chrono::duration<double>(Clock::now() - start).count();
    if (!step()) return Error{ErrorKind::kStopped, "tracking was stopped; nothing was written"};
  }
}

}  // namespace tendril
