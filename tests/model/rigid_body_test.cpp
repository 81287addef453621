// model/objects/rigid_body.h: free tops against RK4 and the symmetric top's closed form; kicks. Strings:
// body_string_test.cpp.
#include "model/objects/rigid_body.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "model/geometry/rotation.h"
#include "tests/support/rigid_bodies.h"

namespace tendril {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using testing_support::AngleBetween;
using testing_support::AngularMomentum;
using testing_support::KineticEnergyOf;
using testing_support::RandomVector;
using testing_support::Top;

// Euler's equations and the quaternion's, by RK4.
RigidBody TurnedByRk4(RigidBody body, double time, int steps) {
  using State = Eigen::Matrix<double, 7, 1>;  // quaternion x y z w, momentum in the body
  const auto rate = [&](const State& s) {
    const Vector3d momentum = s.tail<3>(), spin = momentum.cwiseQuotient(body.inertia);
    const Quaterniond q(s[3], s[0], s[1], s[2]);
    State d;
    d.head<4>() = 0.5 * (q * Quaterniond(0, spin.x(), spin.y(), spin.z())).coeffs();
    d.tail<3>() = momentum.cross(spin);
    return d;
  };
  State s;
  s << body.lab_from_body.coeffs(), body.angular_momentum_in_body;
  const double h = time / steps;
  for (int i = 0; i < steps; ++i) {
    const State k1 = rate(s), k2 = rate(s + h / 2 * k1), k3 = rate(s + h / 2 * k2), k4 = rate(s + h * k3);
    s += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  body.lab_from_body = Quaterniond(s[3], s[0], s[1], s[2]).normalized();
  body.angular_momentum_in_body = s.tail<3>();
  return body;
}

RigidBody Drifted(RigidBody body, double time, int steps) {
  for (int i = 0; i < steps; ++i) DriftBody(body, time / steps);
  return body;
}

TEST(DriftBody, FollowsRk4ToSecondOrder) {
  for (const Vector3d& inertia :
       {Vector3d(1, 2, 3), Vector3d(2, 3, 1), Vector3d(3, 2, 1), Vector3d(1, 3, 2.5)}) {
    const RigidBody start = Top(inertia);
    const RigidBody exact = TurnedByRk4(start, 3, 20000);
    double before = 0;
    for (const int steps : {50, 100, 200}) {
      const RigidBody end = Drifted(start, 3, steps);
      const double miss = AngleBetween(end.lab_from_body, exact.lab_from_body);
      EXPECT_LT(miss, 1e-2 * 2500 / steps / steps);
      EXPECT_LT((end.angular_momentum_in_body - exact.angular_momentum_in_body).norm(), 4 * miss + 1e-6);
      if (before > 0) {
        EXPECT_NEAR(before / miss, 4, 0.1) << inertia.transpose();
      }
      before = miss;
    }
  }
}

TEST(DriftBody, SymmetricTopsAndBallsTurnExactlyInOneStep) {
  // A symmetric top turns about its angular momentum at L / I_across, and about its own axis on top of that.
  for (const int axis : {0, 1, 2}) {
    for (const double along : {2.0, 0.5, 1e-6, 1.0}) {
      Vector3d inertia = Vector3d::Ones();
      inertia[axis] = along;
      const RigidBody start = Top(inertia);
      const double time = along == 1e-6 ? 1e-5 : 7;
      const RigidBody end = Drifted(start, time, 1);
      const double own = start.angular_momentum_in_body[axis] * (1 / along - 1);
      const Quaterniond expected = ExpSo3Quaternion(Vector3d(time * AngularMomentum(start))) *
                                   start.lab_from_body *
                                   ExpSo3Quaternion(Vector3d(time * own * Vector3d::Unit(axis)));
      EXPECT_LT(AngleBetween(end.lab_from_body, expected), 1e-14) << axis << " " << along;
    }
  }
}

TEST(DriftBody, KeepsAngularMomentumToRoundingAndItsEnergyErrorFallsByFour) {
  const RigidBody start = Top({1, 2, 3});
  const auto swing = [&](double step) {
    RigidBody body = start;
    double most = 0;
    for (double time = 0; time < 400; time += step) {
      DriftBody(body, step);
      most = std::max(most, std::abs(KineticEnergyOf(body) / KineticEnergyOf(start) - 1));
    }
    EXPECT_LT((AngularMomentum(body) - AngularMomentum(start)).norm(), 1e-12);
    EXPECT_NEAR(body.lab_from_body.norm(), 1, 1e-15);
    return most;
  };
  const double coarse = swing(0.1), fine = swing(0.05);
  EXPECT_LT(coarse, 1e-3);
  EXPECT_NEAR(coarse / fine, 4, 0.1);
}

TEST(DriftBody, BackIsWhereItCameFrom) {
  RigidBody body = Top({1, 2, 3});
  body.velocity = {1, 2, 3};
  const RigidBody start = body;
  for (int i = 0; i < 1000; ++i) DriftBody(body, 0.05);
  for (int i = 0; i < 1000; ++i) DriftBody(body, -0.05);
  EXPECT_LT(AngleBetween(body.lab_from_body, start.lab_from_body), 1e-12);
  EXPECT_LT((body.position - start.position).norm(), 1e-11);
}

TEST(DriftBody, TurnsALongThinRodAsALineTurns) {
  // Inertia ratio 1e6 with three different values, turning end over end, at steps of 1 ms for 10 s.
  RigidBody body;
  body.inertia = {1, 1.0001, 1e-6};
  body.angular_momentum_in_body = {3, 0, 1e-9};
  const Vector3d momentum = AngularMomentum(body);
  const double energy = KineticEnergyOf(body);
  for (int i = 0; i < 10000; ++i) DriftBody(body, 1e-3);
  EXPECT_NEAR(KineticEnergyOf(body) / energy, 1, 1e-6);
  EXPECT_LT((AngularMomentum(body) - momentum).norm(), 1e-11);
  EXPECT_LT((body.lab_from_body * Vector3d::UnitZ() - Vector3d(0, -std::sin(30), std::cos(30))).norm(), 1e-3);
}

TEST(KickBody, GivesTheForceAndTorqueTimesTime) {
  std::mt19937_64 random(1);
  RigidBody body = Top({1, 2, 3});
  body.mass = 2.5;
  const RigidBody start = body;
  const Vector3d force = RandomVector(random, 1), torque = RandomVector(random, 1);
  KickBody(body, 0.2, force, torque);
  EXPECT_LT((body.mass * (body.velocity - start.velocity) - 0.2 * force).norm(), 1e-15);
  EXPECT_LT((AngularMomentum(body) - AngularMomentum(start) - 0.2 * torque).norm(), 1e-15);
  EXPECT_LT(
      (body.Spin() - body.lab_from_body * Vector3d(body.angular_momentum_in_body.cwiseQuotient(body.inertia)))
          .norm(),
      1e-15);
  KickBody(body, 0.2, -force, -torque);
  EXPECT_LT((body.velocity - start.velocity).norm(), 1e-15);
  EXPECT_LT((body.angular_momentum_in_body - start.angular_momentum_in_body).norm(), 1e-15);
}

TEST(RigidBody, VelocityOfItsPointsIsTheirPlacesRate) {
  RigidBody body = Top({1, 2, 3});
  body.position = {1, 2, 3};
  body.velocity = {0.1, 0.2, 0.3};
  const Vector3d in_body(0.3, -0.4, 0.5);
  RigidBody later = body, earlier = body;
  DriftBody(later, 1e-5);
  DriftBody(earlier, -1e-5);
  const Vector3d rate = (later.Pose() * in_body - earlier.Pose() * in_body) / 2e-5;
  EXPECT_LT((body.velocity + body.Spin().cross(body.Pose() * in_body - body.position) - rate).norm(), 1e-9);
}

}  // namespace
}  // namespace tendril
