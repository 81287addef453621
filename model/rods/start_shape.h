#pragma once
// A rod that starts along a curve through given points: tied, wound, coiled.

#include <Eigen/Core>

#include "model/result.h"
#include "model/rods/rod.h"

namespace tendril {

// Lays the rod along a smooth curve through the points, from the first to the last: sets its start,
// direction, length and start_curvatures, untwisted (each frame is the one before, turned the shortest way).
// The rod's nodes lie on it to second order in the elements' length. The normal stays, made perpendicular.
//   points  m, some evenly spaced along the curve, four or more                                (3, n)
//   errors  kBadInput  fewer points, some that are not finite or equal to the one before
Status LayThrough(const Eigen::Ref<const Eigen::Matrix3Xd>& points, RodDesign& design);

// The largest that each component has anywhere along the rod as it starts, 1/m.
Eigen::Vector3d StrongestStartCurvature(const RodDesign& design);

}  // namespace tendril
