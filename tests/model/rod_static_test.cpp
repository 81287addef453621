// model/rods/rod_static.h: closed forms of rods at rest, their order of convergence, and the stepper's
// answer.
#include "model/rods/rod_static.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <boost/math/special_functions/ellint_1.hpp>
#include <boost/math/special_functions/ellint_2.hpp>
#include <cmath>
#include <numbers>

#include "model/rods/rod_plain.h"

namespace tendril {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;

// Thin, so that shear and stretch do not count: the elastica.
Rod Cantilever(int elements, double stiffness = 1) {
  RodDesign design;
  design.length = 1;
  design.base_radius = 1e-4;
  const double second_moment = std::numbers::pi / 4 * std::pow(design.base_radius, 4);
  design.youngs_modulus = stiffness / second_moment;  // E I = stiffness
  design.shear_modulus = design.youngs_modulus / 3;
  design.direction = Vector3d::UnitX();
  design.normal = Vector3d::UnitZ();
  design.elements = elements;
  design.base = EndHold::kFrame;
  return MakeRod(design).value();
}

// The tip-loaded elastica in elliptic integrals (Bisshopp and Drucker 1945): drop and shortening by P L^2/EI.
struct Elastica {
  double drop, in;
};
Elastica BisshoppDrucker(double load) {
  // k^2 in (1/2, 1): K(k) - F(theta1, k) = sqrt(load), sin theta1 = 1 / (k sqrt 2).
  double low = std::sqrt(0.5), high = 1;
  for (int i = 0; i < 200; ++i) {
    const double k = 0.5 * (low + high), theta = std::asin(1 / (k * std::numbers::sqrt2));
    const double value = boost::math::ellint_1(k) - boost::math::ellint_1(k, theta);
    (value < std::sqrt(load) ? low : high) = k;
  }
  const double k = 0.5 * (low + high), theta = std::asin(1 / (k * std::numbers::sqrt2));
  const double root = std::sqrt(load);
  const double drop = 1 - 2 / root * (boost::math::ellint_2(k) - boost::math::ellint_2(k, theta));
  const double reach = std::sqrt(2.0) / root * std::sqrt(2 * k * k - 1);
  return {drop, 1 - reach};
}

Vector3d Tip(const Rod& rod) { return rod.position.rightCols<1>(); }

Matrix3Xd TipForce(const Rod& rod, const Vector3d& force) {
  Matrix3Xd forces = Matrix3Xd::Zero(3, rod.elements() + 1);
  forces.rightCols<1>() = force;
  return forces;
}

TEST(SettleRod, MeetsTheElasticaAndConvergesAtSecondOrder) {
  const struct {
    double load, drop, in;
  } published[] = {
      {1, 0.30172, 0.05643}, {2, 0.49346, 0.16064}, {5, 0.71379, 0.38763}, {10, 0.81061, 0.55500}};
  for (const auto& [load, drop, in] : published) {
    const Elastica exact = BisshoppDrucker(load);
    EXPECT_NEAR(exact.drop, drop, 6e-6) << load;
    EXPECT_NEAR(exact.in, in, 6e-6) << load;
    double before = 0;
    for (const int elements : {25, 50, 100, 200}) {
      Rod rod = Cantilever(elements);
      const auto account = SettleRod(rod, TipForce(rod, {0, 0, -load}));
      ASSERT_TRUE(account.ok()) << account.error().message;
      const double off = std::hypot(Tip(rod).z() + exact.drop, 1 - Tip(rod).x() - exact.in);
      EXPECT_LT(off, 2.0 * load / (elements * elements)) << load << ", " << elements;
      if (before > 0) {
        EXPECT_NEAR(std::log2(before / off), 2, 0.15) << load << ", " << elements;
      }
      before = off;
    }
  }
}

TEST(SettleRod, MeetsTheHeavyElastica) {
  const struct { double weight, drop; } published[] = {{1, 0.12456}, {10, 1.06680 / 1.0}, {100, 5.88810}};
  // H/W as published: the tip's drop by its distance from the wall.
  for (const auto& [weight, ratio] : published) {
    Rod rod = Cantilever(400);
    Matrix3Xd force = Matrix3Xd::Zero(3, 401);
    force.row(2) = -weight * rod.mass.transpose() / rod.mass.sum();
    const auto account = SettleRod(rod, force);
    ASSERT_TRUE(account.ok()) << account.error().message;
    EXPECT_NEAR(-Tip(rod).z() / Tip(rod).x() / ratio, 1, 5e-4) << weight;
  }
}

TEST(SettleRod, ACoupleOfTwoPiClosesACircle) {
  Rod rod = Cantilever(100);
  rod.tip_couple = {0, 2 * std::numbers::pi, 0};
  // The last element carries all of it; the circle's remaining half element is straight.
  const auto account = SettleRod(rod, TipForce(rod, Vector3d::Zero()));
  ASSERT_TRUE(account.ok()) << account.error().message;
  EXPECT_LT((Tip(rod) - Vector3d::Zero()).norm(), 5e-4);
  double farthest = 0;
  for (Eigen::Index i = 0; i <= 100; ++i) farthest = std::max(farthest, rod.position.col(i).norm());
  EXPECT_NEAR(farthest, 1 / std::numbers::pi, 1e-3 / std::numbers::pi);
}

TEST(SettleRod, AnEquilibriumIsWhereTheStepperRests) {
  RodDesign design;
  design.elements = 40;
  design.taper = 0.5;
  design.base = EndHold::kFrame;
  design.direction = -Vector3d::UnitZ();
  Rod rod = MakeRod(design).value();
  rod.rest_curvature.colwise() = Vector3d(1, -6, 3);
  rod.base.rest_curvature = {1, -6, 3};
  rod.rest_strain.row(2).setConstant(-0.1);
  const Vector3d gravity(0, 0, -9.80665);
  Matrix3Xd force = gravity * rod.mass.transpose();
  force.rightCols<1>() += Vector3d(0.01, 0.02, 0);
  Rod stepped = rod;
  ASSERT_TRUE(SettleRod(rod, force).ok());
  for (int step = 0; step < 60000; ++step) {
    StepPlain({&stepped, 1}, step * 2e-4, {.time_step = 2e-4, .damping = 6, .gravity = gravity},
              [](double, auto, std::span<Matrix3Xd> outside) {
                outside[0].rightCols<1>() += Vector3d(0.01, 0.02, 0);
              });
  }
  EXPECT_LT((rod.position - stepped.position).cwiseAbs().maxCoeff(), 1e-8);
}

// The published hold: half an element that does not bend.
TEST(SettleRod, HoldingTheFirstElementIsFirstOrder) {
  const Elastica exact = BisshoppDrucker(2);
  double before = 0;
  for (const int elements : {50, 100, 200}) {
    Rod rod = Cantilever(elements);
    rod.base.hold = EndHold::kElement;
    ASSERT_TRUE(SettleRod(rod, TipForce(rod, {0, 0, -2})).ok());
    const double off = std::hypot(Tip(rod).z() + exact.drop, 1 - Tip(rod).x() - exact.in);
    if (before > 0) {
      EXPECT_NEAR(std::log2(before / off), 1, 0.05) << elements;
    }
    before = off;
  }
}

// Euler: a column under its tip's load stays straight up to pi^2 EI / (4 L^2) and gives way beyond, also
// where nothing pushes it to a side. Then sqrt(P / P_E) = 2 K(k) / pi and the tip is 4 k / (pi sqrt(P / P_E))
// aside.
TEST(SettleRod, DoesNotTakeAColumnBeyondEulersLoadForOneAtRest) {
  const double euler = std::numbers::pi * std::numbers::pi / 4;
  for (const int elements : {25, 200}) {
    for (const double push : {0.0, 1e-9}) {
      for (const double share : {0.99, 1.1, 1.5}) {
        double low = 0, high = 1 - 1e-15;
        for (int i = 0; i < 100; ++i) {
          const double k = 0.5 * (low + high);
          (2 * boost::math::ellint_1(k) / std::numbers::pi < std::sqrt(share) ? low : high) = k;
        }
        const double aside = share < 1 ? 0 : 4 * low / (std::numbers::pi * std::sqrt(share));
        Rod rod = Cantilever(elements);
        ASSERT_TRUE(SettleRod(rod, TipForce(rod, euler * share * Vector3d(-1, push, 0))).ok());
        EXPECT_NEAR(Tip(rod).tail<2>().norm(), aside, elements == 25 ? 3e-3 : 1e-4)
            << elements << ", " << push << ", " << share;
      }
    }
  }
}

TEST(SettleRod, RefusesWhatIsHeldOtherwise) {
  RodDesign design;
  design.base = EndHold::kFree;
  Rod rod = MakeRod(design).value();
  EXPECT_FALSE(SettleRod(rod, TipForce(rod, Vector3d::Zero())).ok());
  design.base = design.tip = EndHold::kFrame;
  rod = MakeRod(design).value();
  EXPECT_FALSE(SettleRod(rod, TipForce(rod, Vector3d::Zero())).ok());
  design.tip = EndHold::kFree;
  rod = MakeRod(design).value();
  EXPECT_FALSE(SettleRod(rod, TipForce(rod, Vector3d(NAN, 0, 0))).ok());
}

}  // namespace
}  // namespace tendril
