#pragma once
// How a rig's cameras stand to each other, from tags that two of them or more saw at once: a bundle
// adjustment in which every tag at every moment has a pose of its own, so that neither the rig nor the tags
// need to rest.
//
// The intrinsics are given and stay; scale comes from the tags' stated size.

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "capture/rig/camera_model.h"
#include "model/result.h"

namespace tendril {

// One tag in one picture.
struct TagView {
  std::int64_t stamp = 0;  // pictures of equal stamp were taken at once; any unit
  int tag = 0;
  int camera = 0;
  Eigen::Matrix<double, 2, 4> corners_px;  // in the detector's order
};

struct RigFromTagsOptions {
  double border = 0;        // side of the tags' black border, m
  int most_tags = 3000;     // (stamp, tag) pairs that are used, spread evenly over what was seen
  double outlier_px = 1.0;  // residuals beyond this count less and less (Huber)
  int most_iterations = 200;
};

struct RigFromTags {
  std::vector<Camera> cameras;  // with camera_from_lab filled in; camera 0 keeps its given pose
  int tags = 0;                 // (stamp, tag) pairs used
  int views = 0;
  double rms_px = 0;  // reprojection error of a corner, length
  int iterations = 0;
  bool converged = false;
  std::string stopped_because;
};

//   errors  kBadInput    border <= 0, a camera number out of range, fewer than two cameras
//           kUnreachable a camera that shares no tags with the others, by way of any (names it); no
//           convergence
Result<RigFromTags> FitRigFromTags(std::vector<Camera> cameras, std::span<const TagView> views,
                                   const RigFromTagsOptions& options);

}  // namespace tendril
