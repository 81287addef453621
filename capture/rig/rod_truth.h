#pragma once
// Shapes that touch and tangle for the virtual rig: what the rod simulator says of a gripper's rods, put on
// the tentacles of a virtual truth. How, and what it leaves out: docs/virtual_rig.md, "Shapes from rods".
//
// SI units, radians, lab frame.

#include <Eigen/Geometry>
#include <span>

#include "capture/rig/strip_chain.h"
#include "capture/rig/virtual_truth.h"
#include "model/fold/design.h"
#include "model/fold/gripper.h"
#include "model/geometry/framed_curve.h"
#include "model/result.h"

namespace tendril {

// A simulated tentacle at a moment. Of scenes with `shortening = "true"` and curvature map "turning"; the
// carrier stands still.
struct RodShape {
  double command = 0;  // pull that the tentacle's servo stands for
  double pull = 0;     // that the rod's rest shape was made of
  FramedCurve curve;   // nodes spread evenly over the cut length, base to tip
};

// The rod that only its tendon bends: from where the gripper holds it along its rest curvature.
//   angle     phi_i by the law at that pull, rad                                               (creases)
//   elements  of the rod; the curve has one node more
FramedCurve RodAtRest(const TentacleLayout& layout, const Eigen::VectorXd& angle, double pull, int elements,
                      const Eigen::Isometry3d& lab_from_tentacle);

// By how much the rod turns from hole to hole more than at rest, as it turns the facets. `rest` and `now`
// have equally many nodes; nothing but their directions counts. Facet 0 is held.
BeyondFold TurningBeyondFold(const TentacleLayout& layout, const Eigen::VectorXd& angle,
                             const Eigen::Isometry3d& lab_from_tentacle, const FramedCurve& rest,
                             const FramedCurve& now);

// The truth's tentacles bent as the rods are. Its drawn holes, creases, facet bends and bases stay; drawn
// stiffness tilts single facets and does not lead the tentacle away from its rod; there is no sag, for rods
// have weight.
//   rods    of the truth's design on this gripper, one for each tentacle
//   errors  kBadInput: another number of rods, one with under 3 nodes, without normals or not finite
//           kUnreachable: a pull beyond the design's reach
Result<TrueShape> TrueShapeOnRods(const VirtualTruth& truth, const Gripper& gripper,
                                  std::span<const RodShape> rods, double time);

}  // namespace tendril
