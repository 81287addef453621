#pragma once
// From a trial's recording to its centerlines: detections.csv (which tags were seen where), curves.h5 (one
// framed curve per tentacle and frame, with sigma) and residuals.csv (what each tag says against them). All
// can be deleted and made again.
//
// Lab frame, SI; time in seconds since the trial began.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/track/chain_solve.h"
#include "capture/track/tags_in_video.h"
#include "db/files/recording_logs.h"
#include "db/lab.h"
#include "model/geometry/framed_curve.h"
#include "model/progress.h"
#include "model/result.h"

namespace tendril {

struct TrackOptions {
  // How tags are found from picture to picture; none: each is decoded by itself.
  std::optional<TagTrackLevel> tag_level = TagTrackLevel::kStandard;
  TagDetectOptions detect;  // the family is the trial's
  // Whether tentacles touch things (LoadedTentacles) or hang free; none: all but virtual trials', whose pass
  // through what they meet, may touch.
  std::optional<bool> touching;
  bool fold_law = true;  // false: curves owe nothing to the fold law (ChainOptions::fold_law)
  int smooth_lag = 0;    // moments before and after that a crease out of sight is recalled from (recall.h)
  bool from_detections = false;  // start from the folder's detections.csv; the videos are not read
  int threads = 2;               // pictures, then tentacles, that are worked on at once
  // Pictures of two cameras belong together if their host times differ by less than this share of camera 0's
  // frame interval.
  double same_moment = 0.4;
};

struct TrackedTentacle {
  double seen_fraction = 0;  // nodes whose facet was seen, over all frames
  double told_fraction = 0;  // creases whose fold angle the pictures tell at least as much of as the model
  double rms_reprojection_px = 0;  // NaN: no view was used
  double median_sigma = 0;         // of the seen nodes, m; NaN: none
  int views_used = 0;
  int views_rejected = 0;
};

// How one camera's tags were found.
struct CameraTags {
  TagTrackCounts counts;
  long tags = 0;               // over all pictures
  double seconds = 0;          // for finding them, reading the video not counted
  double median_sigma_px = 0;  // stated for their corners; NaN: each picture was decoded
};

struct TrackedTrial {
  bool touching = false;  // what tentacles were taken to do
  ChainOptions chain;     // what their chains were solved with
  std::string family;     // of its tags
  std::vector<CurveSeries>
      curves;  // "tentacle0", ...: nodes are the holes; sigma NaN where a node was not seen
  std::vector<TrackedTentacle> tentacles;
  std::vector<DetectionRow> detections;
  std::vector<ResidualRow> residuals;  // of every detection that is on a facet; by frame, camera and tag
  std::vector<CameraTags> cameras;     // empty where detections.csv was read
  int frames = 0;
  int unknown_tags = 0;       // detections whose id is on no facet of this gripper
  double detect_seconds = 0;  // summed over threads
  double solve_seconds = 0;
  std::vector<std::string> warnings;
};

// Reads trial.toml, cam<i>.mkv and cam<i>.csv, servo.csv of a trial's folder; writes the three files.
//   errors  what the files' readers say; kBadInput: the rig has no camera, a log does not fit its video;
//           kStopped: progress said so (nothing is written)
Result<TrackedTrial> TrackTrial(const std::filesystem::path& folder, const TrackOptions& options = {},
                                const Progress& progress = {});

// TrackTrial, then the lab's row with what it was made from.
//   program  "tendril 0.1.0"
Result<TrackedTrial> TrackAndStore(Lab& lab, const std::string& trial_id, const TrackOptions& options,
                                   const std::string& program, const Progress& progress = {});

}  // namespace tendril
