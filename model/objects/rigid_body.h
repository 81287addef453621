#pragma once
// A rigid body between kicks and under them, free or on a string, in the scheme of the rods: state in the
// middle of steps, kick, drift.
//
// SI units. Body axes are the principal axes of inertia, origin at the centre of mass.

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace tendril {

struct RigidBody {
  double mass = 1;                                    // kg
  Eigen::Vector3d inertia = Eigen::Vector3d::Ones();  // principal, kg m^2
  // The state.
  Eigen::Vector3d position = Eigen::Vector3d::Zero();                  // of the centre of mass, lab, m
  Eigen::Quaterniond lab_from_body = Eigen::Quaterniond::Identity();   // unit
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();                  // lab, m/s
  Eigen::Vector3d angular_momentum_in_body = Eigen::Vector3d::Zero();  // kg m^2/s

  Eigen::Vector3d Spin() const;    // lab, rad/s
  Eigen::Isometry3d Pose() const;  // lab_from_body
};

// An inextensible string without mass from a point of the lab to one of the body: it pulls, and never pushes.
struct BodyString {
  Eigen::Vector3d from = Eigen::Vector3d::Zero();        // lab, m
  Eigen::Vector3d to_in_body = Eigen::Vector3d::Zero();  // m
  double length = 0;                                     // m; 0: a ball joint
};

// Moves straight and turns freely for a time. Turning is split into exact turns: one about the angular
// momentum, as of a ball of the middle inertia, and what the other two principal axes turn more or less than
// it (half, whole, half: McLachlan 1993; Touma and Wisdom 1994). Keeps the length of the angular momentum to
// rounding, reversible, second order in the energy; exact where two of the inertias are equal.
// Otherwise a step must be short against a turn.
void DriftBody(RigidBody& body, double time);

//   force   lab, N;  torque  about the centre of mass, lab, N m
void KickBody(RigidBody& body, double time, const Eigen::Vector3d& force, const Eigen::Vector3d& torque);

// The same, and what the string adds along its present direction so that its ends are no farther apart than
// its length once the body has drifted for `time` (SHAKE, Ryckaert, Ciccotti and Berendsen 1977: second
// order, no drift of energy). A string that comes taut takes the motion along it: an inelastic jerk. One that
// is too long at the start is pulled in, by at most 1 % of its length in a step, whatever that costs; of
// length 0 it is a ball joint, whose ends must meet at the start.
//   returns  the string's mean tension over the step, N; 0: slack. Its ends are then `length` apart to 1e-12
//   of
//            it, unless it was longer. Where the step is too long for that (it moves the end by 0.3 of the
//            length or turns its path by 0.3 rad), an impulse that would add energy only takes the motion
//            along the string, which then may be too long
double KickOnString(RigidBody& body, const BodyString& string, double time, const Eigen::Vector3d& force,
                    const Eigen::Vector3d& torque);

}  // namespace tendril
