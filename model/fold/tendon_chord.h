#pragma once
// Directions of the tendon between two holes, seen from a facet, and the angle by which it turns at a hole.
// Internal to the laws with tendon friction. Angles in radians.

#include <Eigen/Core>

#include "model/fold/design.h"

namespace tendril {

// A facet's tendon segment runs across the crease at angle a, from or to the facet folded by 2 turn: its
// direction in the facet's frame, and how that changes with the turn and with a.
struct Chord {
  Eigen::Vector3d along, by_turn, by_crease;
};
Chord ChordOf(double crease_angle, double turn);

// The deflection between two segments that meet at a hole, by either's turn and crease angle.
struct DeflectionSlope {
  double before = 0, after = 0;                // per rad of phi
  double before_crease = 0, after_crease = 0;  // per rad of the crease's angle
};

// At the hole before crease i >= 1. Zero where the tendon runs straight: the deflection has a kink there.
DeflectionSlope SlopeOfDeflection(const TentacleLayout& layout, const Eigen::VectorXd& angle, Eigen::Index i);

}  // namespace tendril
