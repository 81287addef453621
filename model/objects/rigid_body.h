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

  Eigen::Vector3d Spin() const;                                           // lab, rad/s
  Eigen::Isometry3d Pose() const;                                         // lab_from_body
  Eigen::Vector3d VelocityAt(const Eigen::Vector3d& point_in_lab) const;  // m/s
};

// An inextensible string without mass from a point of the lab to one of the body: it pulls, and never pushes.
struct BodyString {
  Eigen::Vector3d from = Eigen::Vector3d::Zero();        // lab, m
  Eigen::Vector3d to_in_body = Eigen::Vector3d::Zero();  // m
  double length = 0;                                     // m
};

// Moves straight and turns freely for a time. Turning is split into turns about the principal axes (x/2, y/2,
// z, y/2, x/2: McLachlan 1993; Reich 1994): keeps the length of the angular momentum to rounding, reversible,
// second order in the energy.
void DriftBody(RigidBody& body, double time);

//   force   lab, N;  torque  about the centre of mass, lab, N m
void KickBody(RigidBody& body, double time, const Eigen::Vector3d& force, const Eigen::Vector3d& torque);

// The same, and what the string adds so that it is no longer than it is once the body has drifted for
// `time` (SHAKE: second order, no drift of energy).
//   returns  the string's mean tension over the step, N; 0: slack
double KickOnString(RigidBody& body, const BodyString& string, double time, const Eigen::Vector3d& force,
                    const Eigen::Vector3d& torque);

double KineticEnergyOf(const RigidBody& body);  // J

}  // namespace tendril
