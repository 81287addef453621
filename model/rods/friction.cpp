#include "model/rods/friction.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace tendril {

using Eigen::Vector3d;

Vector3d FrictionForce(Stick& stick, const FrictionOf& friction, const Vector3d& normal, double normal_force,
                       const Vector3d& velocity, const Vector3d& turning, double time) {
  // Turned along no farther than its own length, so that turning stores nothing; then laid on the surface.
  const Vector3d turn = time * turning;
  Vector3d stretch =
      std::max(0.0, 1 - 0.5 * turn.squaredNorm()) * (stick.stretch + turn.cross(stick.stretch));
  const Vector3d slip = velocity - normal.dot(velocity) * normal;
  stretch += time * slip;
  stretch -= normal.dot(stretch) * normal;
  Vector3d force = -friction.stiffness * stretch - friction.damping * slip;
  const double limit = (stick.slides ? friction.kinetic : friction.at_rest) * normal_force;
  if (force.norm() > limit) {
    stick.slides = true;
    const double kept = friction.kinetic * normal_force;
    // First the spring alone, then with what damps it: a spring that took up the damping's force would store
    // more than the slip gave it.
    const double pull = friction.stiffness * stretch.norm();
    if (pull > kept) stretch *= kept / pull;
    force = -friction.stiffness * stretch - friction.damping * slip;
    const double size = force.norm();
    if (size > kept) force *= kept / size;
  } else if (slip.dot(stretch) <= 0) {
    stick.slides = false;
  }
  stick.stretch = stretch;
  return force;
}

}  // namespace tendril
