#pragma once
// A tentacle of the virtual rig as strips of paper joined one to the next: three flat strips per facet. Its
// own route from fold angles to a shape, which shares nothing with the tracker's.
//
// SI units, radians; sheet frame as model/fold/design.h.

#include <Eigen/Core>

#include "capture/rig/virtual_truth.h"

namespace tendril {

// Along the crease, in the sheet.
Eigen::Vector3d DirectionOfCrease(double angle);

// What loads make of a folded tentacle: facet i+1 lies turned against facet i beyond its fold. Empty:
// nothing.
struct BeyondFold {
  Eigen::VectorXd fold;  // added to phi_i, rad                                                  (creases)
  // The turning that no fold can give, before the crease's, as a rotation vector in facet i's sheet axes,
  // rad. Half of it bends and twists facet i between hole and crease, half facet i+1 between crease and hole.
  Eigen::Matrix3Xd bend;  //                                                                 (3, creases)
};

// Facet 0 is held as it lies at the rest angles; sag by the weight is added where the truth has some.
//   rest_angle  phi_i by the law, rad                                                           (creases)
TrueTentacle ShapeOfStrips(const TentacleTruth& truth, const TentacleDesign& design,
                           const Eigen::VectorXd& rest_angle, const BeyondFold& beyond = {});

}  // namespace tendril
