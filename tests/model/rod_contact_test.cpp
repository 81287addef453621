// model/rods/contact.h, model/geometry/segment_distance.h, and rods as a whole in model/rods/contact_plain.h.
#include "model/rods/contact.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <span>
#include <vector>

#include "model/geometry/segment_distance.h"
#include "model/rods/contact_plain.h"
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

// Loads of what the law of energy finds, of rods alone.
std::vector<RodLoads> Pressed(PlainContact& contact, std::span<const Rod> rods) {
  std::vector<RodLoads> loads;
  for (const Rod& rod : rods) {
    loads.push_back({Matrix3Xd::Zero(3, rod.elements() + 1), Matrix3Xd::Zero(3, rod.elements())});
  }
  contact.Add(rods, {}, 1e-5, loads, {});
  return loads;
}

TEST(AddRodContact, MakesNoMomentum) {
  const std::vector<Rod> rods = Crossing(-0.001);
  for (const ContactLaw law : {ContactLaw::kHertzEqual, ContactLaw::kHertzCenters}) {
    Matrix3Xd a = Matrix3Xd::Zero(3, 21), b = a;
    AddRodContact({.law = law}, rods[0], rods[1], a, b);
    EXPECT_GT(a.norm(), 0);
    EXPECT_LT((a.rowwise().sum() + b.rowwise().sum()).norm(), 1e-12);
  }
}

// The energy does not change as rods move or turn together: no momentum is made of either kind.
TEST(PlainContact, MakesNoMomentumOfEitherKind) {
  std::vector<Rod> rods = Crossing(-0.001);
  rods[1].velocity.row(2).setConstant(-0.5);
  for (const double damping : {0.0, 0.1}) {
    Contact law{.damping = damping};
    law.points = 4;
    PlainContact contact(law, {});
    const std::vector<RodLoads> loads = Pressed(contact, rods);
    const double size = loads[0].force.norm();
    EXPECT_GT(size, 0);
    Vector3d force = Vector3d::Zero(), torque = Vector3d::Zero();
    for (std::size_t r = 0; r < 2; ++r) {
      force += loads[r].force.rowwise().sum();
      torque += loads[r].couple.rowwise().sum();
      for (Eigen::Index i = 0; i < 21; ++i) {
        torque += Vector3d(rods[r].position.col(i)).cross(Vector3d(loads[r].force.col(i)));
      }
    }
    EXPECT_LT(force.norm(), 1e-12 * size);
    EXPECT_LT(torque.norm(), 1e-12 * size);
  }
}

TEST(PlainContact, DampingNeverPulls) {
  std::vector<Rod> rods = Crossing(-0.001);
  rods[1].velocity.row(2).setConstant(50);  // parting fast
  Contact law{.damping = 1};
  law.points = 4;
  PlainContact contact(law, {});
  // It takes all that the rods press across their axes with, and no more.
  std::vector<RodLoads> loads = Pressed(contact, rods);
  const double left = loads[1].force.row(2).sum();
  law.damping = 0;
  PlainContact undamped(law, {});
  loads = Pressed(undamped, rods);
  EXPECT_GT(loads[1].force.row(2).sum(), 0.1);
  EXPECT_NEAR(left, 0, 1e-12);
}

// Without damping a collision gives back the energy that it took.
TEST(PlainContact, AnUndampedCollisionKeepsEnergyAndMomentum) {
  std::vector<Rod> rods = Crossing(0.001);
  rods[1].velocity.row(2).setConstant(-0.5);
  const auto energy = [&] { return EnergyOf(rods[0]).total() + EnergyOf(rods[1]).total(); };
  const auto momentum = [&] {
    return Vector3d(rods[0].velocity * rods[0].mass + rods[1].velocity * rods[1].mass);
  };
  const double before = energy();
  const Vector3d momentum_before = momentum();
  Contact law;
  law.points = 3;
  PlainContact contact(law, {});
  double largest = 0;
  double touching = 0;
  for (int step = 0; step < 20000 && (largest == 0 || touching > 0); ++step) {
    StepPlain(rods, step * 1e-5, {.time_step = 1e-5}, [&](double, auto r, auto forces) {
      const std::vector<RodLoads> loads = Pressed(contact, r);
      for (std::size_t k = 0; k < 2; ++k) forces[k] += loads[k].force;
      touching = loads[0].force.norm();
    });
    largest = std::max(largest, touching);
  }
  EXPECT_EQ(touching, 0) << "they have parted";
  EXPECT_GT(largest, 0.5);
  EXPECT_NEAR(energy(), before, 1e-4 * before);
  EXPECT_LT((momentum() - momentum_before).norm(), 1e-12);
}

TEST(SelfContact, LeavesNeighboursAloneAndPartsWhatTouches) {
  RodDesign design;
  design.elements = 60;
  const Rod straight =
      MakeRod(design).value();  // 20 mm thick, elements of 12.5 mm: neighbours always overlap
  for (const ContactLaw law :
       {ContactLaw::kHertzSegments, ContactLaw::kHertzEqual, ContactLaw::kHertzCenters}) {
    Rod rod = straight;
    const auto found = [&] {
      PlainContact contact({}, {});
      if (law == ContactLaw::kHertzSegments) return Pressed(contact, {&rod, 1})[0].force;
      Matrix3Xd force = Matrix3Xd::Zero(3, 61);
      AddSelfContact({.law = law}, rod, force);
      return force;
    };
    EXPECT_EQ(found().norm(), 0);
    // Folded into two parallel halves 30 mm apart: the upper half is pushed up.
    for (Eigen::Index i = 0; i <= 60; ++i) {
      rod.position.col(i) = i <= 30 ? Vector3d(0.0125 * static_cast<double>(i), 0, 0)
                                    : Vector3d(0.0125 * static_cast<double>(61 - i), 0, 0.03);
    }
    const Matrix3Xd force = found();
    EXPECT_GT(force.middleCols(41, 18).row(2).minCoeff(), 0);
    EXPECT_LT(force.middleCols(2, 18).row(2).maxCoeff(), 0);
    EXPECT_LT(force.rowwise().sum().norm(), 1e-12 * force.norm());
  }
}

TEST(SelfContact, OfATurnOnlyPressesWhereItIsTighterThanTheRodIsThick) {
  RodDesign design;
  design.elements = 200;
  design.length = 0.4;
  design.base_radius = 0.02;
  Rod rod = MakeRod(design).value();
  for (const double radius : {0.0205, 0.012}) {
    for (Eigen::Index i = 0; i <= 200; ++i) {
      const double along = 0.002 * (static_cast<double>(i) - 100), half = 0.5 * std::numbers::pi * radius;
      const double way = std::max(0.0, std::abs(along) - half),
                   angle = std::clamp(along, -half, half) / radius;
      rod.position.col(i) = Vector3d(radius * std::cos(angle) - way, radius * std::sin(angle), 0);
    }
    PlainContact contact({}, {});
    const double pressed = Pressed(contact, {&rod, 1})[0].force.norm();
    EXPECT_EQ(pressed > 1, radius < 0.02) << pressed;
    EXPECT_EQ(pressed == 0, radius > 0.02) << pressed;
  }
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
