// model/objects/rigid_body.h, strings: pendulums against the elliptic integral and small modes, energy, at
// rest, slack, coming taut, and at extremes.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include "model/geometry/rotation.h"
#include "model/objects/rigid_body.h"
#include "tests/support/allocation_count.h"
#include "tests/support/rigid_bodies.h"

namespace tendril {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using std::numbers::pi;
using testing_support::AngleBetween;
using testing_support::AngularMomentum;
using testing_support::KineticEnergyOf;
using testing_support::RandomVector;
using testing_support::Top;

constexpr double kGravity = 9.80665;

Vector3d Weight(const RigidBody& body) { return {0, 0, -body.mass * kGravity}; }

double LengthOf(const RigidBody& body, const BodyString& string) {
  return (body.Pose() * string.to_in_body - string.from).norm();
}

// A body hung from `string` and swung out about y by `swing` as one piece; from rest.
RigidBody Hung(double mass, const Vector3d& inertia, const BodyString& string, double swing) {
  RigidBody body;
  body.mass = mass;
  body.inertia = inertia;
  const Quaterniond turn = ExpSo3Quaternion(Vector3d(0, -swing, 0));
  const Vector3d down(0, 0, -string.length);
  body.lab_from_body = turn;
  body.position = string.from + turn * Vector3d(down - string.to_in_body);
  return body;
}

// Kinetic energy half way through the kick, where position and potential energy are.
double StepEnergy(RigidBody& body, const BodyString& string, double step) {
  const RigidBody before = body;
  KickOnString(body, string, step, Weight(body), Vector3d::Zero());
  RigidBody middle = before;
  middle.velocity = 0.5 * (before.velocity + body.velocity);
  middle.angular_momentum_in_body = 0.5 * (before.angular_momentum_in_body + body.angular_momentum_in_body);
  const double energy = KineticEnergyOf(middle) + body.mass * kGravity * body.position.z();
  DriftBody(body, step);
  return energy;
}

// Mean period from the times at which `value` crosses zero upward, over `swings`.
double PeriodOf(RigidBody body, const BodyString& string, double step, int swings,
                const std::function<double(const RigidBody&)>& value) {
  double first = -1, time = 0, last = value(body);
  for (int crossed = 0; time < 1e4; time += step) {
    KickOnString(body, string, step, Weight(body), Vector3d::Zero());
    DriftBody(body, step);
    const double now = value(body);
    if (last < 0 && now >= 0) {
      const double at = time + step * last / (last - now);
      if (first < 0) first = at;
      if (crossed++ == swings) return (at - first) / swings;
    }
    last = now;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

double Sideways(const RigidBody& body) { return body.position.x(); }

TEST(KickOnString, SwingsAsLongAsTheEllipticIntegralSays) {
  const BodyString string{{0.2, 0, 1}, Vector3d::Zero(), 0.7};
  const auto from_middle = [&](const RigidBody& b) { return Sideways(b) - string.from.x(); };
  for (const double swing : {1e-3, pi / 3, 80 * pi / 180}) {
    const double exact = 4 * std::sqrt(string.length / kGravity) * std::comp_ellint_1(std::sin(swing / 2));
    const double period = PeriodOf(Hung(0.3, {1, 2, 3}, string, swing), string, 1e-3, 5, from_middle);
    EXPECT_NEAR(period / exact, 1, 1e-5) << swing;
  }
}

TEST(KickOnString, ABallHungByItsTopHasTheDoublePendulumsModes) {
  // Angles a of the string and b of the ball (mass 1, radius r, inertia I): r^2 a'' ... as Lagrange has it,
  // [L L, L r; L r, r r + I] (a, b)'' + g [L 0; 0 r] (a, b) = 0.
  const double length = 0.3, radius = 0.1, inertia = 0.4 * radius * radius;
  const BodyString string{Vector3d::Zero(), {0, 0, radius}, length};
  Eigen::Matrix2d mass, stiffness;
  mass << length * length, length * radius, length * radius, radius * radius + inertia;
  stiffness << kGravity * length, 0, 0, kGravity * radius;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix2d> modes(stiffness, mass);
  for (const int mode : {0, 1}) {
    const Eigen::Vector2d angle =
        1e-4 * modes.eigenvectors().col(mode) / modes.eigenvectors().col(mode).norm();
    RigidBody body;
    body.inertia = Vector3d::Constant(inertia);
    body.lab_from_body = ExpSo3Quaternion(Vector3d(0, -angle[1], 0));
    body.position = string.from + ExpSo3(Vector3d(0, -angle[0], 0)) * Vector3d(0, 0, -length) -
                    body.lab_from_body * string.to_in_body;
    const double period = PeriodOf(body, string, 2e-4, 5, Sideways);
    EXPECT_NEAR(period * std::sqrt(modes.eigenvalues()[mode]) / (2 * pi), 1, 1e-5) << mode;
  }
}

TEST(KickOnString, WithoutLengthABodyIsACompoundPendulum) {
  const double arm = 0.2, mass = 0.7;
  const Vector3d inertia(0.01, 0.02, 0.03);
  const BodyString joint{{0, 0, 1}, {0, 0, arm}, 0};
  for (const double swing : {1e-3, pi / 3}) {
    const double exact = 4 * std::sqrt((inertia.y() + mass * arm * arm) / (mass * kGravity * arm)) *
                         std::comp_ellint_1(std::sin(swing / 2));
    EXPECT_NEAR(PeriodOf(Hung(mass, inertia, joint, swing), joint, 5e-4, 5, Sideways) / exact, 1, 1e-5)
        << swing;
  }
}

TEST(KickOnString, AJointHoldsAnySpinAndKeepsTheEnergy) {
  const BodyString joint{{0.5, 0, 1}, {0.05, -0.1, 0.2}, 0};
  RigidBody body = Hung(0.7, {0.01, 0.02, 0.03}, joint, 1.0);
  const Vector3d spin(1, 3, 10);
  body.angular_momentum_in_body = spin.cwiseProduct(body.inertia);
  body.velocity = -body.Spin().cross(body.lab_from_body * joint.to_in_body);
  double least = 1e9, most = -1e9;
  for (int i = 0; i < 200000; ++i) {
    const double energy = StepEnergy(body, joint, 1e-4);
    if (i > 0) least = std::min(least, energy), most = std::max(most, energy);
    if (i > 0) {
      ASSERT_LT(LengthOf(body, joint), 1e-14);
    }
  }
  EXPECT_LT(most - least, 2e-4 * KineticEnergyOf(body));
}

// A ball hung off its centre, swung out as a double pendulum that is not small: chaotic only later.
RigidBody OffCentre(const BodyString& string) {
  RigidBody body = Hung(0.5, {0.001, 0.002, 0.003}, string, 1.0);
  body.angular_momentum_in_body = {0.001, 0.002, 0.006};
  return body;
}

TEST(KickOnString, ConvergesToSecondOrder) {
  const BodyString string{{0, 0, 1}, {0.02, 0.03, 0.08}, 0.4};
  const auto at_end = [&](int steps) {
    const double step = 0.8 / steps;
    RigidBody body = Hung(0.5, {0.001, 0.002, 0.003}, string, 1.0);
    for (int i = 0; i < steps; ++i) {  // at rest: the half drift before the first kick is none
      KickOnString(body, string, step, Weight(body), Vector3d::Zero());
      DriftBody(body, i + 1 < steps ? step : step / 2);
    }
    return body;
  };
  const RigidBody exact = at_end(64000);
  double before = 0;
  for (const int steps : {500, 1000, 2000}) {
    const RigidBody end = at_end(steps);
    const double miss = (end.position - exact.position).norm();
    if (before > 0) {
      EXPECT_NEAR(before / miss, 4, 0.4);
    }
    before = miss;
  }
}

TEST(KickOnString, KeepsEnergyAndLengthOverAThousandSwings) {
  const BodyString string{{0, 0, 1}, {0, 0, 0.05}, 0.4};
  RigidBody body = Hung(0.3, Vector3d::Constant(3e-4), string, 1.0);
  const double step = 1e-3, scale = body.mass * kGravity * (string.length + 0.05);
  const int steps = static_cast<int>(1000 * 1.45 / step);
  double early_least = 1e9, early_most = -1e9, late_least = 1e9, late_most = -1e9;
  for (int i = 0; i < steps; ++i) {
    const double energy = StepEnergy(body, string, step);
    if (i < steps / 10)
      early_least = std::min(early_least, energy), early_most = std::max(early_most, energy);
    if (i >= steps - steps / 10)
      late_least = std::min(late_least, energy), late_most = std::max(late_most, energy);
    ASSERT_NEAR(LengthOf(body, string) / string.length, 1, 1e-14);
  }
  EXPECT_LT(early_most - early_least, 1e-5 * scale);
  EXPECT_NEAR(late_most, early_most, 1e-8 * scale);
  EXPECT_NEAR(late_least, early_least, 1e-8 * scale);
}

TEST(KickOnString, HangingAtRestItPullsWithTheWeight) {
  for (const double mass : {1e-6, 1.0, 1e6}) {
    for (const double step : {1e-6, 2e-5, 1e-2}) {
      for (const double length : {0.0, 0.4}) {
        const BodyString string{{0.1, 0.2, 0.7}, {0, 0, 0.05}, length};
        RigidBody body = Hung(mass, mass * Vector3d(1e-3, 2e-3, 3e-9), string, 0);
        const RigidBody start = body;
        for (int i = 0; i < 1000; ++i) {
          const double tension = KickOnString(body, string, step, Weight(body), Vector3d::Zero());
          ASSERT_NEAR(tension / (mass * kGravity), 1, 1e-12 + 1e-19 / (step * step))
              << mass << " " << step << " " << length << " " << i;
          DriftBody(body, step);
        }
        EXPECT_LT((body.position - start.position).norm(), 1e-15);
        EXPECT_LT(AngleBetween(body.lab_from_body, start.lab_from_body), 1e-13);
      }
    }
  }
}

TEST(KickOnString, ASlackOneDoesNothing) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 200; ++i) {
    BodyString string{RandomVector(random, 1), RandomVector(random, 0.2), 0};
    RigidBody body = Top({1, 2, 3});
    body.velocity = RandomVector(random, 1);
    const RigidBody start = body;
    RigidBody kicked = body;
    const Vector3d force = RandomVector(random, 5), torque = RandomVector(random, 5);
    KickBody(kicked, 1e-3, force, torque);
    RigidBody later = kicked;
    DriftBody(later, 1e-3);
    const double apart = LengthOf(later, string);
    string.length = apart * (1 + 1e-12);
    EXPECT_EQ(KickOnString(body, string, 1e-3, force, torque), 0);
    EXPECT_EQ(body.velocity, kicked.velocity);
    EXPECT_EQ(body.angular_momentum_in_body, kicked.angular_momentum_in_body);
    // A touch shorter, and it pulls.
    string.length = apart * (1 - 1e-9);
    body = start;
    EXPECT_GT(KickOnString(body, string, 1e-3, force, torque), 0);
  }
}

TEST(KickOnString, LeavesTheStringAtItsLengthAndPullsAlongIt) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 1000; ++i) {
    RigidBody body = Top({1e-2, 2e-2, 3e-2});
    body.position = RandomVector(random, 1);
    body.velocity = RandomVector(random, 2);
    body.angular_momentum_in_body = RandomVector(random, 0.1);
    BodyString string{RandomVector(random, 1), RandomVector(random, 0.2), 0};
    string.length = LengthOf(body, string);
    const Vector3d end = body.Pose() * string.to_in_body, direction = (string.from - end).normalized();
    const Vector3d force = RandomVector(random, 50), torque = RandomVector(random, 5);
    const double time = i % 2 ? 1e-4 : 5e-3;
    RigidBody without = body;
    KickBody(without, time, force, torque);
    const double tension = KickOnString(body, string, time, force, torque);
    const Vector3d impulse = time * tension * direction;
    EXPECT_GE(tension, 0);
    EXPECT_LT((body.mass * (body.velocity - without.velocity) - impulse).norm(), 1e-14);
    EXPECT_LT(
        (AngularMomentum(body) - AngularMomentum(without) - (end - body.position).cross(impulse)).norm(),
        1e-14);
    DriftBody(body, time);
    if (tension > 0) {
      EXPECT_NEAR(LengthOf(body, string) / string.length, 1, 1e-12);
    }
    EXPECT_LE(LengthOf(body, string), string.length * (1 + 1e-12));
  }
}

TEST(KickOnString, ADropOntoItStopsAndLosesItsEnergy) {
  const BodyString string{{0, 0, 1}, {0, 0, 0.05}, 0.5};
  RigidBody body = Hung(0.3, {1e-3, 2e-3, 3e-3}, string, 0);
  body.position.z() += 0.4;
  const double step = 1e-3;
  double largest = 0, last = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 1000; ++i) {
    const double fall = body.velocity.z();
    const double tension = KickOnString(body, string, step, Weight(body), Vector3d::Zero());
    largest = std::max(largest, tension);
    const double energy = KineticEnergyOf(body) +
                          0.5 * body.mass * kGravity * (2 * body.position.z() + step * body.velocity.z());
    EXPECT_LE(energy, last + body.mass * kGravity * step * step * kGravity) << fall;
    last = energy;
    DriftBody(body, step);
    ASSERT_LE(LengthOf(body, string), string.length * (1 + 1e-14));
  }
  EXPECT_NEAR(LengthOf(body, string), string.length, 1e-14);
  EXPECT_LT(body.velocity.norm(), 1e-12);
  // All of sqrt(2 g 0.4 m), in one or two steps.
  EXPECT_GT(largest, 0.5 * body.mass * std::sqrt(2 * kGravity * 0.4) / step);
}

TEST(KickOnString, NoThrowOntoItGainsEnergy) {
  std::mt19937_64 random(4);
  for (int i = 0; i < 50; ++i) {
    const BodyString string{{0, 0, 1}, RandomVector(random, 0.05), 0.5};
    RigidBody body = Hung(0.3, {1e-4, 2e-4, 3e-4}, string, 0);
    body.position += Vector3d(0, 0, 0.3) + RandomVector(random, 0.1);
    body.velocity = RandomVector(random, 2);
    body.angular_momentum_in_body = RandomVector(random, 2e-3);
    const double step = 1e-4;
    double start = 0, most = -1e9, last = 0;
    for (int k = 0; k < 20000; ++k) {
      last = StepEnergy(body, string, step);
      if (k == 0) start = last;
      most = std::max(most, last);
      ASSERT_LE(LengthOf(body, string), string.length * (1 + 1e-12));
    }
    const double moved = 0.3 * kGravity;  // J, its size
    EXPECT_LT(most, start + 1e-4 * moved) << i;
    EXPECT_LT(last, start - 1e-2 * moved) << i;
  }
}

TEST(KickOnString, AStringTooLongIsPulledInWithinTheStep) {
  const BodyString string{{0, 0, 1}, {0.01, 0, 0.05}, 0.5};
  RigidBody body = Hung(0.3, {1e-3, 2e-3, 3e-3}, string, 0.4);
  body.position += 0.008 * (body.position - string.from);  // by less than 1 % of the string
  EXPECT_GT(KickOnString(body, string, 1e-3, Weight(body), Vector3d::Zero()), 0);
  DriftBody(body, 1e-3);
  EXPECT_NEAR(LengthOf(body, string), string.length, 1e-13);
}

TEST(KickOnString, FromEndsOnEachOtherItComesTautTheWayTheyPart) {
  const BodyString string{Vector3d::Zero(), Vector3d::Zero(), 1e-3};
  RigidBody body;
  body.velocity = {3, 0, 0};
  EXPECT_NEAR(KickOnString(body, string, 1e-3, Vector3d::Zero(), Vector3d::Zero()), 2 / 1e-3, 1e-9);
  EXPECT_NEAR(body.velocity.x(), 1, 1e-12);
  body.velocity = Vector3d::Zero();
  EXPECT_EQ(KickOnString(body, string, 1e-3, Vector3d::Zero(), Vector3d::Zero()), 0);
  EXPECT_EQ(body.velocity, Vector3d::Zero());
}

TEST(KickOnString, StepsThatAreTooLongLoseEnergyAndNeverBlowUp) {
  // Half a turn of the string and more in a step; energy is counted at the end of kicks.
  std::mt19937_64 random(6);
  for (int i = 0; i < 50; ++i) {
    const BodyString string{{0, 0, 1}, RandomVector(random, 0.05), 0.1};
    RigidBody body = Hung(1, Vector3d::Constant(4e-3), string, 0.5);
    body.velocity = RandomVector(random, 20);
    const double start = KineticEnergyOf(body);
    for (int k = 0; k < 2000; ++k) {
      KickOnString(body, string, 1e-2, Vector3d::Zero(), Vector3d::Zero());
      DriftBody(body, 1e-2);
      ASSERT_LT(KineticEnergyOf(body), 1.1 * start) << i << " " << k;
    }
  }
}

TEST(KickOnString, HoldsAtExtremesOfMassShapeAndStep) {
  std::mt19937_64 random(5);
  for (const double mass : {1e-6, 1e6}) {
    for (const double step : {1e-6, 1e-3}) {
      for (const double thin : {1.0, 1e-6}) {
        const BodyString string{{0, 0, 1}, {0, 1e-3 * std::sqrt(thin), 0.1}, 0.5};
        RigidBody body = Hung(mass, mass * 1e-2 * Vector3d(1, 1, thin), string, 0.5);
        body.velocity = RandomVector(random, 0.5);
        for (int k = 0; k < 2000; ++k) {
          const double tension = KickOnString(body, string, step, Weight(body), Vector3d::Zero());
          ASSERT_TRUE(tension >= 0 && std::isfinite(tension));
          DriftBody(body, step);
          ASSERT_LE(LengthOf(body, string), string.length * (1 + 1e-12));
        }
        ASSERT_TRUE(body.position.allFinite() && body.lab_from_body.coeffs().allFinite());
        EXPECT_LT(KineticEnergyOf(body), 10 * mass);
      }
    }
  }
}

TEST(KickOnString, AllocatesNothing) {
  const BodyString string{{0, 0, 1}, {0.02, 0.03, 0.08}, 0.4};
  BodyString joint = string;
  joint.length = 0;
  RigidBody body = OffCentre(string), pinned = Hung(1, {1, 2, 3}, joint, 1.0);
  const long before = testing_support::allocations;
  for (int i = 0; i < 1000; ++i) {
    KickOnString(body, string, 1e-4, Weight(body), Vector3d::Zero());
    DriftBody(body, 1e-4);
    KickOnString(pinned, joint, 1e-4, Weight(pinned), Vector3d::Zero());
    DriftBody(pinned, 1e-4);
  }
  EXPECT_EQ(testing_support::allocations, before);
}

}  // namespace
}  // namespace tendril
