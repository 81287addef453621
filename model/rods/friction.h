#pragma once
// Coulomb's friction of one contact, with memory: it sticks by a spring along the surface until the spring
// pulls with mu N, and then slides with its end dragged along (Cundall and Strack 1979). The spring's
// stiffness does not depend on N, so that no change of N makes energy.

#include <Eigen/Core>

namespace tendril {

struct Stick {
  Eigen::Vector3d stretch = Eigen::Vector3d::Zero();  // of the spring, along the surface, m
  bool slides = false;
};

struct FrictionOf {
  double kinetic = 0, at_rest = 0;  // mu; at_rest >= kinetic
  double stiffness = 0;             // N/m
  double damping = 0;               // N s/m, while it sticks
};

// Moves the spring on by a step and returns the force on the body whose velocity against the other is given.
//   normal    unit; N = normal_force >= 0
//   velocity  of the surfaces against each other, m/s: what it moved by in the step / time
//   turning   mean spin of the two bodies, rad/s: the spring turns with them (by up to 1.7 rad a step:
//             beyond, energy could come of it)
Eigen::Vector3d FrictionForce(Stick& stick, const FrictionOf& friction, const Eigen::Vector3d& normal,
                              double normal_force, const Eigen::Vector3d& velocity,
                              const Eigen::Vector3d& turning, double time);

}  // namespace tendril
