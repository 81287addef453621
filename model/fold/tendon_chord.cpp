#include "model/fold/tendon_chord.h"

#include <Eigen/Geometry>
#include <cmath>

namespace tendril {

Chord ChordOf(double crease_angle, double turn) {
  const double sa = std::sin(crease_angle);
  const double ca = std::abs(std::cos(crease_angle)) < 1e-15 ? 0 : std::cos(crease_angle);
  const double s = std::sin(turn), c = std::cos(turn);
  if (ca == 0) return {{s, 0, c}, {c, 0, -s}, {0, -s * s / c, 0}};
  const Eigen::Vector3d chord(sa * s * c, sa * ca * s * s, 1 - sa * sa * s * s);
  const double length = chord.norm();
  const Eigen::Vector3d along = chord / length;
  const auto across = [&](const Eigen::Vector3d& v) -> Eigen::Vector3d {
    return (v - along.dot(v) * along) / length;
  };
  return {along, across({sa * (c * c - s * s), 2 * sa * ca * s * c, -2 * sa * sa * s * c}),
          across({ca * s * c, (ca * ca - sa * sa) * s * s, -2 * sa * ca * s * s})};
}

DeflectionSlope SlopeOfDeflection(const TentacleLayout& layout, const Eigen::VectorXd& angle,
                                  Eigen::Index i) {
  const double sign = i % 2 == 0 ? -1 : 1;  // mountain, valley, ...
  const Chord u = ChordOf(layout.crease_angle[i - 1], sign * angle[i - 1]);
  const Chord v = ChordOf(layout.crease_angle[i], sign * angle[i]);
  const double sine = u.along.cross(v.along).norm();
  if (sine < 1e-12) return {};
  return {-sign * u.by_turn.dot(v.along) / sine, -sign * v.by_turn.dot(u.along) / sine,
          -u.by_crease.dot(v.along) / sine, -v.by_crease.dot(u.along) / sine};
}

}  // namespace tendril
