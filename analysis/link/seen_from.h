#pragma once
// Curves as something that moves sees them: how do tentacles wind around an object that does not stay?

#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "model/geometry/framed_curve.h"

namespace tendril {

// The curves moved, frame by frame, so that the object stays where it was in the first frame: its axis at the
// start then is its axis in every frame. Links do not change by moving everything at once.
//   lab_from_object  its poses, as many as each curve has frames (checked)
//   returns          points and normals only
std::vector<CurveSeries> SeenFrom(std::span<const Eigen::Isometry3d> lab_from_object,
                                  std::span<const CurveSeries> curves);

}  // namespace tendril
