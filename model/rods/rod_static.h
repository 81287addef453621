#pragma once
// The shape at which a rod rests, without stepping there: base held, tip free, loads that keep their
// direction.
//
// Such a rod carries in each element the sum of the forces beyond it, whatever its shape. That leaves the
// elements' directions, of which each meets only its neighbours: Newton's method on a block tridiagonal
// system, on the energy that remains when every element has the strain of its force.

#include <Eigen/Core>

#include "model/result.h"
#include "model/rods/rod.h"

namespace tendril {

struct StaticAccount {
  int iterations = 0;
  double residual = 0;  // couples left on elements, summed, as a share of what bends the rod by a radian
};

// Moves directors and nodes to the stable equilibrium that descent leads to from the directors at hand; where
// they balance but would not stay, as a straight column beyond Euler's load, to what lies beside them.
// Velocities and spins become 0. With a tip couple, which has no energy, to the equilibrium that Newton's
// method leads to. Counts the rod's rest curvature and strain, base frame and tip couple.
//   force    on nodes, N                                                                    (3, N+1)
//   returns  couples balanced to kStaticResidual, and 1e-15 N^2 that rounding leaves of N elements
//   errors   kBadInput    a base that is free, a tip that is held, forces not finite
//            kUnreachable no equilibrium within 200 iterations
Result<StaticAccount> SettleRod(Rod& rod, const Eigen::Ref<const Eigen::Matrix3Xd>& force);

inline constexpr double kStaticResidual = 1e-10;

}  // namespace tendril
