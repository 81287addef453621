#pragma once
// The tags of one camera, from frame to frame: decoded rarely, tracked always. A tag that was decoded once is
// predicted, fitted where it should be (tag_photometric.h) and confirmed by decoding from time to time.

#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <vector>

#include "capture/track/tag_detect.h"
#include "capture/track/tag_photometric.h"

namespace tendril {

enum class TagTrackLevel {
  kPreview,   // few steps of the fit, decoding rarely
  kStandard,  // settled fits
  kBest,      // settled fits, decoding in every frame
};
const char* NameOf(TagTrackLevel level);

struct TagTrackOptions {
  TagTrackLevel level = TagTrackLevel::kStandard;
  TagDetectOptions detect;
  TagFitOptions fit;
  int decode_every = 0;  // frames; 0: the level's
  int keep_unseen = 3;   // frames that a tag may be missed in before it must be decoded anew
};

struct TrackedTag {
  int id = 0;
  Eigen::Matrix<double, 2, 4> corners_px;
  Eigen::Matrix<double, 8, 8> covariance;  // as TagFit
  double blur_px = 0;
  double residual = 0;
  bool decoded = false;  // in this frame, too; then:
  int hamming = 0;       // code bits that were wrong
  double margin = 0;     // decision margin, gray levels
};

// Stated error of a corner's coordinate, root mean square of the eight, px.
inline double SigmaOfCorners(const TrackedTag& tag) { return std::sqrt(tag.covariance.trace() / 8); }

struct TagTrackCounts {
  long frames = 0, decodes = 0;
  long fitted = 0, found = 0;                // tags fitted where they should be; found by decoding
  std::array<long, kTagFitFaults> faults{};  // by TagFitFault: what was expected and not believed
  long changed = 0;                          // decoding found another place for it than tracking had
};

class TagTracker {
 public:
  //   errors  kBadInput: as TagDetector::Create
  static Result<TagTracker> Create(const TagTrackOptions& options);

  // The next frame's tags in ascending id.
  //   errors  kBadInput: as TagDetector::Detect
  Result<std::vector<TrackedTag>> Next(const GrayImage& image);

  const TagTrackCounts& counts() const { return counts_; }

 private:
  struct Track {
    Eigen::Matrix<double, 2, 4> corners_px;  // in the last frame it was seen in
    Eigen::Matrix<double, 2, 4> way_px = Eigen::Matrix<double, 2, 4>::Zero();  // from frame to frame
    double blur_px = 0;
    TagFollow follow;
    int unseen = 0;  // frames
    bool moving = false;
  };
  TagTracker(TagTrackOptions options, TagDetector detector);
  const TagLook* Look(int id);
  static Eigen::Matrix<double, 2, 4> Predicted(const Track& track);
  // decoded: it was, in this very frame.
  bool Follow(const GrayImage& image, int id, Track& track, bool decoded, TrackedTag& tag);
  Status Decode(const GrayImage& image, std::vector<TrackedTag>& tags);

  TagTrackOptions options_;
  TagDetector detector_;
  std::map<int, TagLook> looks_;
  std::map<int, Track> tracks_;
  int since_decode_ = 0;
  bool unforeseen_ = false;  // tags were decoded far from where they were expected
  int searches_ = 0;         // decodes that are to be made soon, for what was lost
  TagTrackCounts counts_;
};

}  // namespace tendril
