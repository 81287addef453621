#include "capture/track/tag_tracker.h"

#include <algorithm>
#include <utility>

#include "capture/track/tag_search.h"

namespace tendril {
namespace {

using Corners = Eigen::Matrix<double, 2, 4>;
constexpr int kSearchReach = 6;  // px

double Farthest(const Corners& a, const Corners& b) { return (a - b).colwise().norm().maxCoeff(); }

}  // namespace

const char* NameOf(TagTrackLevel level) {
  switch (level) {
    case TagTrackLevel::kPreview:
      return "preview";
    case TagTrackLevel::kStandard:
      return "standard";
    case TagTrackLevel::kBest:
      return "best";
  }
  return "standard";
}

TagTracker::TagTracker(TagTrackOptions options, TagDetector detector)
    : options_(std::move(options)), detector_(std::move(detector)) {}

Result<TagTracker> TagTracker::Create(const TagTrackOptions& options) {
  TagTrackOptions chosen = options;
  // The fit takes over where the detector ends.
  chosen.detect.corners = TagCorners::kLibrary;
  if (chosen.decode_every <= 0) {
    chosen.decode_every = options.level == TagTrackLevel::kPreview    ? 50
                          : options.level == TagTrackLevel::kStandard ? 20
                                                                      : 1;
  }
  if (options.level == TagTrackLevel::kPreview) {
    chosen.fit.most_iterations = 10;
    chosen.fit.settled_gain = 10;
  }
  Result<TagDetector> detector = TagDetector::Create(chosen.detect);
  if (!detector.ok()) return detector.error();
  return TagTracker(std::move(chosen), std::move(detector).value());
}

const TagLook* TagTracker::Look(int id) {
  const auto known = looks_.find(id);
  if (known != looks_.end()) return &known->second;
  Result<TagLook> look = LookOf(options_.detect.family, id);
  if (!look.ok()) return nullptr;
  return &looks_.emplace(id, std::move(look).value()).first->second;
}

bool TagTracker::Follow(const GrayImage& image, int id, Track& track, bool decoded, TrackedTag& tag) {
  const TagLook* const look = Look(id);
  if (look == nullptr) return false;
  TagFitOptions fit = options_.fit;
  fit.blur_px = track.blur_px;
  const Corners there =
      track.moving ? Corners(track.corners_px + (1 + track.unseen) * track.way_px) : track.corners_px;
  // Of a tag seen once no way is known; of another the way may have changed.
  TagFit found;
  if (track.moving || decoded) found = FitTag(image, *look, there, fit, track.follow);
  if ((!track.moving && !decoded) || found.fault != TagFitFault::kNone) {
    if (const auto shift = SearchTag(image, *look, there, kSearchReach)) {
      const TagFit again = FitTag(image, *look, there.colwise() + *shift, fit, track.follow);
      if (again.fault == TagFitFault::kNone || !track.moving) found = again;
    }
  }
  if (found.fault != TagFitFault::kNone) {
    ++counts_.faults[static_cast<std::size_t>(found.fault)];
    return false;
  }
  track.way_px = (found.corners_px - track.corners_px) / (1 + track.unseen);
  track.corners_px = found.corners_px;
  // Slowly: one frame tells blur only roughly.
  track.blur_px += 0.3 * (found.blur_px - track.blur_px);
  track.unseen = 0;
  track.moving = true;
  tag = {.id = id,
         .corners_px = found.corners_px,
         .covariance = found.covariance,
         .blur_px = found.blur_px,
         .residual = found.residual};
  return true;
}

Status TagTracker::Decode(const GrayImage& image, std::vector<TrackedTag>& tags) {
  const Result<std::vector<TagDetection>> detections = detector_.Detect(image);
  if (!detections.ok()) return detections.error();
  ++counts_.decodes;
  since_decode_ = 0;
  searches_ = std::max(0, searches_ - 1);
  for (const TagDetection& detection : detections.value()) {
    const auto tag =
        std::find_if(tags.begin(), tags.end(), [&](const TrackedTag& t) { return t.id == detection.id; });
    if (tag != tags.end() && Farthest(tag->corners_px, detection.corners_px) < 3) {
      tag->decoded = true;
      continue;
    }
    if (tag != tags.end()) {
      ++counts_.changed;
      tags.erase(tag);
    }
    Track track;
    track.corners_px = detection.corners_px;
    track.blur_px = options_.fit.blur_px;
    TrackedTag found;
    if (!Follow(image, detection.id, track, true, found)) continue;
    track.moving = false;  // one frame tells no way
    ++counts_.found;
    found.decoded = true;
    tracks_.insert_or_assign(detection.id, std::move(track));
    tags.push_back(found);
  }
  return Ok{};
}

Result<std::vector<TrackedTag>> TagTracker::Next(const GrayImage& image) {
  ++counts_.frames;
  ++since_decode_;
  std::vector<TrackedTag> tags;
  for (auto it = tracks_.begin(); it != tracks_.end();) {
    TrackedTag tag;
    if (Follow(image, it->first, it->second, false, tag)) {
      ++counts_.fitted;
      tags.push_back(tag);
    } else if (++it->second.unseen > options_.keep_unseen) {
      searches_ = 4;
      it = tracks_.erase(it);
      continue;
    }
    ++it;
  }
  const bool first = counts_.decodes == 0;
  // What is lost is looked for sooner, but not in every frame: it may be gone.
  const int wait = searches_ > 0 ? std::max(1, options_.decode_every / 4) : options_.decode_every;
  if (first || since_decode_ >= wait) {
    if (const Status decoded = Decode(image, tags); !decoded.ok()) return decoded.error();
  }
  std::sort(tags.begin(), tags.end(), [](const TrackedTag& a, const TrackedTag& b) { return a.id < b.id; });
  return tags;
}

}  // namespace tendril
