#pragma once
// Where a gripper's tentacles hang: on a circle about the carrier's axis.
//
// Lab frame: origin at the carrier's centre, z up; tentacles hang along -z, their outer face away from the
// axis.

#include <Eigen/Geometry>
#include <numbers>
#include <string>
#include <vector>

#include "model/fold/design.h"

namespace tendril {

enum class Handedness {
  kMirror,   // odd tentacles have the mirrored design, as in the paper's experiment
  kNormals,  // the same design with its outer face in and out in turn, as in the paper's simulation
  kSame,
};

struct Gripper {
  int tentacles = 8;
  double carrier_radius = 0.12;                          // m
  double first_azimuth = 22.5 * std::numbers::pi / 180;  // of tentacle 0 about z, from x, rad
  // Between the bases of tentacles 2k and 2k + 1, m; 0: all stand evenly. Otherwise the two stand about the
  // middle of where they stand evenly, so that room is left between pairs.
  double pair_spacing = 0;
  double tilt = 5 * std::numbers::pi / 180;  // toward the axis, rad
  Handedness handedness = Handedness::kMirror;
};

// Design of tentacle i: the design itself, or its mirror for odd i under kMirror.
TentacleDesign DesignOfTentacle(const Gripper& gripper, const TentacleDesign& design, int i);

// The widest pair_spacing: there pairs meet. 0: not an even number.
double WidestPairSpacing(const Gripper& gripper);

// Of tentacle i about z, from x, rad.
double AzimuthOfTentacle(const Gripper& gripper, int i);

// Pose of tentacle i's frame (hole 0 at its origin, d3 = +z toward the tip) in the lab. Hole 0 lies on the
// carrier's circle at height 0.
Eigen::Isometry3d LabFromTentacle(const Gripper& gripper, int i);

}  // namespace tendril
