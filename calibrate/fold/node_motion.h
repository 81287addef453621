#pragma once
// The fold model as the fit sees it: where the holes are at given parameters, and how they move when a
// parameter changes. Derivatives are exact: the fold's scale k is differentiated through its equation (the
// implicit function theorem), the chain as rigid bodies that turn about their creases.

#include <Eigen/Core>
#include <array>

#include "model/fold/design.h"
#include "model/fold/rising_fold.h"
#include "model/result.h"

namespace tendril {

// The columns of every derivative here.
enum FoldDirection {
  kEffectivePull = 0,
  kLogRatio = 1,
  kExponent = 2,
  kRestAngle = 3,
  kFriction = 4,
  kFoldDirections = 5
};

struct FoldTangent {
  Eigen::VectorXd angle;  // phi_i, rad                           (creases)
  Eigen::Matrix<double, Eigen::Dynamic, kFoldDirections> slope;  // by each direction (creases, 5)
  int closed = 0;                                                // creases at phi_max
};

// Where a tentacle is in the space of what can be fitted.
struct FoldPoint {
  double effective_pull = 0;
  double log_ratio = 0;  // of the stiffness ratio
  double exponent = 1;
  double rest_angle = 0;  // rad
  double friction = 0;
  FoldLaw law = FoldLaw::kPaper;
  // The slopes by these are wanted; else they are 0 here.
  bool by_rest_angle = false;
  bool by_friction = false;
};

// A law's fold (model/fold/rising_fold.h) at a point, whose stiffness, rest angle and friction replace the
// design's own. A closed crease does not move. At pull 0 every slope but that by the rest angle is 0 by
// convention (that by pull is infinite there; the holes' own slope is finite, but no parameter moves a pull
// of 0).
//   errors  as SolveRisingFold; kBadInput if log_ratio or exponent is not finite
Result<FoldTangent> FoldAt(const TentacleDesign& design, const TentacleLayout& layout,
                           const FoldPoint& point);

struct NodeMotion {
  Eigen::Matrix3Xd nodes;  // holes in the tentacle's frame, m  (3, H)
  // sin^2(a) sin^2(phi) of each crease, and its derivatives: how far the fold carries its neighbours out of
  // their chord.                                                                  (creases), (creases, 5)
  Eigen::VectorXd folded;
  Eigen::Matrix<double, Eigen::Dynamic, kFoldDirections> folded_slope;
  std::array<Eigen::Matrix3Xd, kFoldDirections> velocity;  // their derivatives up to a rigid motion (3, H)
};

// Holes of the folded chain and their derivatives with facet 0 held still.
NodeMotion MoveNodes(const TentacleLayout& layout, const FoldTangent& fold);

}  // namespace tendril
