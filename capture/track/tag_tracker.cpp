#include "capture/track/tag_tracker.h"

#include <algorithm>
#include <utility>

#include "capture/track/tag_search.h"

namespace tendril {
namespace {

using Corners = Eigen::Matrix<double, 2, 4>;
constexpr int kSearchReach = 6;   // px
constexpr double kJumped = 0.1;   // share of the tags
constexpr double kSamePlace = 3;  // px, between where a tag is decoded and where it was expected

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
  const Corners there = Predicted(track);
  // Where a tag was seen once, how it moves is not known: it is searched at once.
  TagFit found = track.moving || decoded ? FitTag(image, *look, there, fit, track.follow)
                                         : TagFit{.fault = TagFitFault::kMoved};
  if (found.fault != TagFitFault::kNone) {
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

Corners TagTracker::Predicted(const Track& track) {
  return track.moving ? Corners(track.corners_px + (1 + track.unseen) * track.way_px) : track.corners_px;
}

Status TagTracker::Decode(const GrayImage& image, std::vector<TrackedTag>& tags) {
  const Result<std::vector<TagDetection>> detections = detector_.Detect(image);
  if (!detections.ok()) return detections.error();
  ++counts_.decodes;
  since_decode_ = 0;
  searches_ = std::max(0, searches_ - 1);
  int near = 0, far = 0;  // from where they were expected
  for (const TagDetection& detection : detections.value()) {
    const auto tag =
        std::find_if(tags.begin(), tags.end(), [&](const TrackedTag& t) { return t.id == detection.id; });
    if (tag != tags.end() && Farthest(tag->corners_px, detection.corners_px) < kSamePlace) {
      tag->decoded = true;
      tag->hamming = detection.hamming;
      tag->margin = detection.margin;
      ++near;
      continue;
    }
    Track track;
    track.corners_px = detection.corners_px;
    track.blur_px = options_.fit.blur_px;
    const auto known = tracks_.find(detection.id);
    if (tag != tags.end()) {
      ++counts_.changed;
      tags.erase(tag);
    } else if (known != tracks_.end()) {
      ++(Farthest(Predicted(known->second), detection.corners_px) < kSamePlace ? near : far);
      track.blur_px = known->second.blur_px;
    }
    TrackedTag found;
    if (!Follow(image, detection.id, track, true, found)) continue;
    track.moving = known != tracks_.end();  // one frame tells no way
    if (track.moving) {
      track.way_px = (track.corners_px - known->second.corners_px) / (1 + known->second.unseen);
    }
    ++counts_.found;
    found.decoded = true;
    found.hamming = detection.hamming;
    found.margin = detection.margin;
    tracks_.insert_or_assign(detection.id, std::move(track));
    tags.push_back(found);
  }
  unforeseen_ = far > kJumped * (near + far);
  return Ok{};
}

Result<std::vector<TrackedTag>> TagTracker::Next(const GrayImage& image) {
  ++counts_.frames;
  ++since_decode_;
  std::vector<TrackedTag> tags;
  std::vector<int> untried;
  // Many that are lost at once were not hidden: frames are missing, or all moves too fast to be predicted.
  // Then decoding is cheaper than fits that go nowhere.
  const double most = kJumped * static_cast<double>(tracks_.size());
  int lost = 0;
  for (auto& [id, track] : tracks_) {
    TrackedTag tag;
    if (unforeseen_ || lost > most) {
      untried.push_back(id);
    } else if (Follow(image, id, track, false, tag)) {
      ++counts_.fitted;
      tags.push_back(tag);
    } else {
      lost += track.unseen++ == 0 ? 1 : 0;
    }
  }
  const bool jumped = unforeseen_ || lost > most || counts_.decodes == 0;
  // What is lost is looked for sooner, but not in every frame: it may be gone.
  const int wait = searches_ > 0 ? std::max(1, options_.decode_every / 4) : options_.decode_every;
  if (jumped || since_decode_ >= wait) {
    if (const Status decoded = Decode(image, tags); !decoded.ok()) return decoded.error();
  }
  for (const int id : untried) {
    if (std::any_of(tags.begin(), tags.end(), [&](const TrackedTag& t) { return t.id == id; })) continue;
    TrackedTag tag;
    if (!unforeseen_ && Follow(image, id, tracks_.at(id), false, tag)) {
      ++counts_.fitted;
      tags.push_back(tag);
    } else {
      ++tracks_.at(id).unseen;
    }
  }
  const auto gone =
      std::erase_if(tracks_, [&](const auto& track) { return track.second.unseen > options_.keep_unseen; });
  if (gone > 0) searches_ = 4;
  std::sort(tags.begin(), tags.end(), [](const TrackedTag& a, const TrackedTag& b) { return a.id < b.id; });
  return tags;
}

}  // namespace tendril
