// model/rods/contact.h and model/geometry/segment_distance.h.
#include "model/rods/contact.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "model/geometry/segment_distance.h"
#include "model/rods/rod_plain.h"

namespace tendril {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;

// The least distance over a grid of both segments, refined about the best.
double LeastByGrid(const Vector3d& a0, const Vector3d& a1, const Vector3d& b0, const Vector3d& b1) {
  double s = 0.5, t = 0.5, width = 0.5, least = INFINITY;
  for (int round = 0; round < 30; ++round) {
    const double s_middle = s, t_middle = t;
    for (int i = -10; i <= 10; ++i) {
      for (int j = -10; j <= 10; ++j) {
        const double si = std::clamp(s_middle + 0.1 * i * width, 0.0, 1.0);
        const double tj = std::clamp(t_middle + 0.1 * j * width, 0.0, 1.0);
        const double d = (a0 + si * (a1 - a0) - b0 - tj * (b1 - b0)).norm();
        if (d < least) {
          least = d;
          s = si;
          t = tj;
        }
      }
    }
    width *= 0.5;
  }
  return least;
}

TEST(ClosestOfSegments, IsTheLeastDistance) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  const auto draw = [&](double size) -> Vector3d {
    return size * Vector3d(normal(random), normal(random), normal(random));
  };
  for (int trial = 0; trial < 400; ++trial) {
    const double scale = std::pow(10.0, trial % 7 - 3);
    const Vector3d a0 = draw(scale), a1 = a0 + draw(scale), b0 = a0 + draw(scale);
    // Nearly parallel, points, or any.
    const Vector3d b1 = trial % 4 == 0   ? Vector3d(b0 + 0.7 * (a1 - a0) + draw(1e-6 * scale))
                        : trial % 4 == 1 ? b0
                                         : Vector3d(b0 + draw(scale));
    const ClosestPoints closest = ClosestOfSegments(a0, a1, b0, b1);
    EXPECT_GE(closest.s, 0);
    EXPECT_LE(closest.s, 1);
    EXPECT_GE(closest.t, 0);
    EXPECT_LE(closest.t, 1);
    const double least =
        LeastByGrid(a0, a1, b0, b1);  // from above: the grid is slow where lines are parallel
    // (Within 1e-7 rad of parallel they count as parallel.)
    EXPECT_LE(closest.apart.norm(), least * (1 + 1e-12) + 2e-7 * scale) << trial;
    EXPECT_GE(closest.apart.norm(), least - 1e-4 * scale) << trial;
    EXPECT_NEAR((b0 + closest.t * (b1 - b0) - a0 - closest.s * (a1 - a0) - closest.apart).norm(), 0,
                1e-14 * scale);
  }
}

TEST(ClosestOfSegments, OfParallelOnesIsTheMiddleOfWhereTheyLieSideBySide) {
  const ClosestPoints closest = ClosestOfSegments({0, 0, 0}, {1, 0, 0}, {0.5, 0.2, 0}, {2.5, 0.2, 0});
  EXPECT_NEAR(closest.s, 0.75, 1e-15);
  EXPECT_NEAR(closest.t, 0.125, 1e-15);
  EXPECT_NEAR(closest.apart.norm(), 0.2, 1e-15);
  const ClosestPoints points = ClosestOfSegments({1, 2, 3}, {1, 2, 3}, {1, 2, 5}, {1, 2, 5});
  EXPECT_EQ(points.apart.norm(), 2);
}

std::vector<Rod> Crossing(double gap) {
  RodDesign design;
  design.elements = 20;
  design.length = 0.4;
  design.base_radius = 0.01;
  design.density = 500;
  design.youngs_modulus = 1e6;
  design.shear_modulus = 1e6 / 3;
  design.base = EndHold::kFree;
  design.start = {-0.2, 0, 0};
  design.direction = Vector3d::UnitX();
  design.normal = Vector3d::UnitZ();
  RodDesign other = design;
  other.direction = {0.3, 1, 0};
  other.start = Vector3d(0.013, 0.007, 0.02 + gap) - 0.2 * other.direction.normalized();
  return {MakeRod(design).value(), MakeRod(other).value()};
}

// Forces at the contact's own point are equal, opposite and on one line: no momentum is made of either kind.
TEST(AddRodContact, MakesNoMomentum) {
  const std::vector<Rod> rods = Crossing(-0.001);
  for (const ContactLaw law :
       {ContactLaw::kHertzSegments, ContactLaw::kHertzEqual, ContactLaw::kHertzCenters}) {
    Matrix3Xd a = Matrix3Xd::Zero(3, 21), b = a;
    AddRodContact({.law = law}, rods[0], rods[1], a, b);
    const double size = a.norm();
    EXPECT_GT(size, 0);
    EXPECT_LT((a.rowwise().sum() + b.rowwise().sum()).norm(), 1e-12);
    if (law != ContactLaw::kHertzSegments) continue;
    Vector3d torque = Vector3d::Zero();
    for (Eigen::Index i = 0; i < 21; ++i) {
      torque += Vector3d(rods[0].position.col(i)).cross(Vector3d(a.col(i))) +
                Vector3d(rods[1].position.col(i)).cross(Vector3d(b.col(i)));
    }
    EXPECT_LT(torque.norm(), 1e-12 * size);
  }
}

TEST(AddRodContact, DampingNeverPulls) {
  std::vector<Rod> rods = Crossing(-0.0001);
  rods[1].velocity.row(2).setConstant(5);  // parting fast
  Matrix3Xd a = Matrix3Xd::Zero(3, 21), b = a;
  AddRodContact({.damping = 1}, rods[0], rods[1], a, b);
  EXPECT_EQ(a.norm(), 0);
}

// Without damping a collision gives back the energy that it took.
TEST(AddRodContact, AnUndampedCollisionKeepsEnergyAndMomentum) {
  std::vector<Rod> rods = Crossing(0.001);
  rods[1].velocity.row(2).setConstant(-0.5);
  const auto energy = [&] { return EnergyOf(rods[0]).total() + EnergyOf(rods[1]).total(); };
  const auto momentum = [&] {
    return Vector3d(rods[0].velocity * rods[0].mass + rods[1].velocity * rods[1].mass);
  };
  const double before = energy();
  const Vector3d momentum_before = momentum();
  const Contact contact;
  double largest = 0;
  double touching = 0;
  for (int step = 0; step < 20000 && (largest == 0 || touching > 0); ++step) {
    StepPlain(rods, step * 1e-5, {.time_step = 1e-5}, [&](double, auto r, auto forces) {
      AddRodContact(contact, r[0], r[1], forces[0], forces[1]);
      touching = forces[0].norm();
    });
    largest = std::max(largest, touching);
  }
  EXPECT_EQ(touching, 0) << "they have parted";
  EXPECT_GT(largest, 0.5);
  EXPECT_NEAR(energy(), before, 1e-4 * before);
  EXPECT_LT((momentum() - momentum_before).norm(), 1e-12);
}

TEST(AddSelfContact, LeavesNeighboursAloneAndPartsWhatTouches) {
  RodDesign design;
  design.elements = 60;
  Rod rod = MakeRod(design).value();  // 20 mm thick, elements of 12.5 mm: neighbours always overlap
  Matrix3Xd force = Matrix3Xd::Zero(3, 61);
  AddSelfContact({}, rod, force);
  EXPECT_EQ(force.norm(), 0);
  // Folded into two parallel halves 30 mm apart: the upper half is pushed up.
  for (Eigen::Index i = 0; i <= 60; ++i) {
    rod.position.col(i) = i <= 30 ? Vector3d(0.0125 * static_cast<double>(i), 0, 0)
                                  : Vector3d(0.0125 * static_cast<double>(61 - i), 0, 0.03);
  }
  AddSelfContact({}, rod, force);
  EXPECT_GT(force.middleCols(41, 18).row(2).minCoeff(), 0);
  EXPECT_LT(force.middleCols(2, 18).row(2).maxCoeff(), 0);
  EXPECT_LT(force.rowwise().sum().norm(), 1e-12 * force.norm());
}

// A rod on a fixed sphere at rest: the contact's force is the overlap's, whatever the law.
TEST(AddBodyContact, IsHertzsForceOfTheOverlap) {
  RodDesign design;
  design.elements = 21;
  design.direction = Vector3d::UnitX();
  design.normal = Vector3d::UnitZ();
  design.start = {-0.375, 0, 0};
  const Rod rod = MakeRod(design).value();
  const FixedBody sphere{.start = {0, 0, -0.069}, .end = {0, 0, -0.069}, .radius = 0.05};
  Matrix3Xd force = Matrix3Xd::Zero(3, 22);
  AddBodyContact({.law = ContactLaw::kHertzCenters}, rod, sphere, force);
  EXPECT_NEAR(force.row(2).sum(), 1e4 * std::pow(0.001, 1.5), 1e-9);  // the middle element's centre
  EXPECT_NEAR(force.row(0).sum(), 0, 1e-12);
}

}  // namespace
}  // namespace tendril
