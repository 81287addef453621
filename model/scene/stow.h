#pragma once
// How a tentacle starts that is rolled up: a plane spiral whose layers do not touch, its tip inside.

#include <Eigen/Core>

#include "model/result.h"
#include "model/rods/rod.h"
#include "model/scene/scene.h"

namespace tendril {

// Curvature of a rolled-up rod, as RodDesign::start_curvatures has it: of the half element at the base, then
// at the inner nodes, about d2, 1/m                                                          (3, elements)
// In the spiral neighbouring layers of the axis are farther apart than the rod is thick there, by the gap:
// also across the spiral's slope and where elements cut the corner.
//   side    1: rolls toward d1; -1: away from it
//   errors  kBadInput  a roll tighter than the rod's own radius allows or its elements can follow (1.5 rad
//           each); more turns than that leaves room for
Result<Eigen::Matrix3Xd> RolledCurvature(const RodDesign& design, const Stow& stow, double side);

// How much of the roll's rest curvature there is at a time: 1 until the release, 0 once it is unrolled.
double RolledShare(const Stow& stow, double time);

}  // namespace tendril
