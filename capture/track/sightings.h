#pragma once
// The tags that several cameras saw, sorted by moment and tentacle: which pictures belong together, and whose
// tag is whose.

#include <cstdint>
#include <filesystem>
#include <vector>

#include "capture/rig/tag_layout.h"
#include "capture/track/chain_solve.h"
#include "capture/track/same_moments.h"
#include "db/files/recording_logs.h"
#include "db/files/trial_toml.h"
#include "model/result.h"

namespace tendril {

// Everything about a recording that the solver needs.
struct Sightings {
  std::vector<double> time;                              // s since the trial began               (frames)
  std::vector<std::vector<std::vector<TagView>>> views;  // (frames) x (tentacles) x views
  int unknown_tags = 0;                                  // whose id is on no facet
};

//   cameras      one log per camera, at least one; frames are those of camera 0
//   tags         outlives what comes back
//   same_moment  pictures belong together if their host times differ by less than this share of camera 0's
//                frame interval
Sightings SortSightings(const std::vector<DetectionRow>& rows, const std::vector<FrameLog>& cameras,
                        const TagLayout& tags, const TrialSpec& trial, double same_moment);

// Of rows that somebody else may have made.
//   errors  kBadInput: a camera or a frame that there is not
Status CheckDetections(const std::vector<DetectionRow>& rows, const std::vector<FrameLog>& cameras,
                       const std::filesystem::path& file);

}  // namespace tendril
