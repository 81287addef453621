#pragma once
// Rigid bodies for tests, and how far apart two of their turns are.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <random>

#include "model/geometry/rotation.h"
#include "model/objects/rigid_body.h"

namespace tendril::testing_support {

inline Eigen::Vector3d RandomVector(std::mt19937_64& random, double half) {
  std::uniform_real_distribution<double> uniform(-half, half);
  return {uniform(random), uniform(random), uniform(random)};
}

inline Eigen::Vector3d AngularMomentum(const RigidBody& body) {
  return body.lab_from_body * body.angular_momentum_in_body;
}

// Turned, and turning about no axis of its own.
inline RigidBody Top(const Eigen::Vector3d& inertia) {
  RigidBody body;
  body.inertia = inertia;
  body.lab_from_body = ExpSo3Quaternion(Eigen::Vector3d(0.3, -0.5, 0.2));
  body.angular_momentum_in_body = Eigen::Vector3d(1.0, 0.2, -0.7);
  return body;
}

inline double KineticEnergyOf(const RigidBody& body) {  // J
  return 0.5 * body.mass * body.velocity.squaredNorm() +
         0.5 * body.angular_momentum_in_body.dot(body.angular_momentum_in_body.cwiseQuotient(body.inertia));
}

inline double AngleBetween(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return LogSo3(Eigen::Quaterniond(a.conjugate() * b)).norm();
}

}  // namespace tendril::testing_support
