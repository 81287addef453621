#pragma once
// Where a tag is, from its four corners in one picture. Two poses explain a small or distant square almost
// equally well (its near and far edge change places): both are given.
//
// Tag frame: origin at its centre; seen from the front x right, y down, z into the tag.

#include <Eigen/Geometry>
#include <vector>

#include "capture/rig/camera_model.h"

namespace tendril {

struct TagPose {
  Eigen::Isometry3d camera_from_tag = Eigen::Isometry3d::Identity();
  double rms_px = 0;  // reprojection error over the four corners
};

// Corners of a tag in its own frame, in the detector's order; z = 0, m.
Eigen::Matrix<double, 3, 4> TagCorners3d(double border);

//   border    side of the black border, m
//   returns   up to two poses, the better one first; none where a corner has no ray or no pose has the tag in
//             front of the camera
//   source    Collins and Bartoli, "Infinitesimal plane-based pose estimation", 2014 (OpenCV's IPPE_SQUARE),
//   then
//             least squares on the reprojection from each
std::vector<TagPose> TagPoses(const Camera& camera, const Eigen::Matrix<double, 2, 4>& corners_px,
                              double border);

}  // namespace tendril
