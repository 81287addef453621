// model/scene/stow.h: rolled up, a rod keeps its length and its layers their distance; the release lets it
// straighten and throws it outward.
#include "model/scene/stow.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <tuple>

#include "model/geometry/segment_distance.h"
#include "model/scene/driven.h"

namespace tendril {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using std::numbers::pi;

RodDesign Ribbon(double radius, double taper, int elements) {
  RodDesign design;
  design.length = 0.75;
  design.base_radius = radius;
  design.taper = taper;
  design.elements = elements;
  return design;
}

TEST(RolledCurvature, LayersKeepTheirDistance) {
  for (const auto& [radius, taper, elements, gap] : {std::tuple{0.004, 0.5, 100, 0.001},
                                                     {0.004, 1.0, 100, 0.0},
                                                     {0.008, 0.3, 60, 0.002},
                                                     {0.001, 0.5, 400, 0.0005},
                                                     {0.003, 0.05, 200, 0.004}}) {
    RodDesign design = Ribbon(radius, taper, elements);
    const Stow stow{.inner_radius = 0.02, .gap = gap};
    const auto rolled = RolledCurvature(design, stow, 1);
    ASSERT_TRUE(rolled.ok()) << rolled.error().message;
    design.start_curvatures = rolled.value();
    const Rod rod = MakeRod(design).value();
    double closest = HUGE_VAL;  // beyond what is due
    for (Index i = 0; i < rod.elements(); ++i) {
      double turned = 0;
      for (Index j = i + 1; j < rod.elements(); ++j) {
        turned += rolled.value().col(j).norm() * rod.rest_length[j];
        if (turned < pi) continue;
        const double distance = ClosestOfSegments(rod.position.col(i), rod.position.col(i + 1),
                                                  rod.position.col(j), rod.position.col(j + 1))
                                    .apart.norm();
        closest = std::min(closest, distance - rod.radius[i] - rod.radius[j] - gap);
      }
    }
    EXPECT_GT(closest, 0) << radius << " " << taper;
    EXPECT_LT(closest, 0.25 * radius + 0.5 * gap) << "rolled no looser than need be";
    for (Index i = 0; i < rod.elements(); ++i) EXPECT_LT(StrainOf(rod, i).norm(), 1e-13);
    EXPECT_NEAR(rod.rest_length.sum(), 0.75, 1e-14);
  }
}

TEST(RolledCurvature, LiesInAPlaneOnTheAskedForSide) {
  for (const double side : {1.0, -1.0}) {
    RodDesign design = Ribbon(0.004, 0.5, 100);
    design.start_curvatures = RolledCurvature(design, {.inner_radius = 0.02}, side).value();
    const Rod rod = MakeRod(design).value();
    EXPECT_LT(rod.position.row(1).cwiseAbs().maxCoeff(), 1e-15);
    EXPECT_GT(side * rod.position.row(0).mean(), 0.02);
    EXPECT_GT(side * rod.position.row(0).minCoeff() * side, side > 0 ? -1e-3 : -1);
    // What it was made of is what it has.
    for (Index i = 0; i + 1 < rod.elements(); ++i) {
      EXPECT_LT((CurvatureOf(rod, i) - design.start_curvatures.col(i + 1)).norm(), 1e-9);
    }
    EXPECT_LT((BaseCurvature(rod) - design.start_curvatures.col(0)).norm(), 1e-9);
  }
}

TEST(RolledCurvature, ThinRodsMakeTheRingThatTheyShould) {
  // No thickness to speak of and no gap: rings on top of each other.
  const RodDesign design = Ribbon(1e-6, 1, 2000);
  const auto rolled = RolledCurvature(design, {.inner_radius = 0.05, .gap = 0}, 1);
  EXPECT_NEAR(rolled.value().row(1).mean(), 1 / 0.05, 1e-2);
}

TEST(RolledCurvature, TurnsAreAsManyAsAskedFor) {
  const RodDesign design = Ribbon(0.004, 0.5, 200);
  for (const double turns : {0.5, 1.0, 2.5, 4.0}) {
    const auto rolled = RolledCurvature(design, {.turns = turns}, 1);
    ASSERT_TRUE(rolled.ok()) << rolled.error().message;
    // The tangent turns like the angle, but for how the spiral's slope changes.
    const double turned = rolled.value().row(1).sum() * 0.75 / 200 / (2 * pi);
    EXPECT_NEAR(turned, turns, 0.03) << turns;
  }
  const auto many = RolledCurvature(design, {.turns = 40}, 1);
  ASSERT_FALSE(many.ok());
  EXPECT_NE(many.error().message.find("stowed.turns = 40: expected at most"), std::string::npos);
}

TEST(RolledCurvature, TighterThanTheRodIsThickIsAnError) {
  const auto tight = RolledCurvature(Ribbon(0.01, 1, 100), {.inner_radius = 0.015}, 1);
  ASSERT_FALSE(tight.ok());
  EXPECT_NE(tight.error().message.find("stowed.inner_radius = 0.015 m: expected 0.0205 m"),
            std::string::npos);
  EXPECT_FALSE(RolledCurvature(Ribbon(0.001, 1, 10), {.inner_radius = 0.04}, 1).ok());
}

Scene Stowed() {
  Scene scene;
  SceneGripper& gripper = scene.gripper.emplace();
  gripper.gripper.tentacles = 4;
  gripper.rod.base_radius = 0.004;
  gripper.stowed = Stow{.inner_radius = 0.02, .release_time = 0.5, .unroll_time = 0.4, .eject_speed = 2};
  return scene;
}

TEST(Stowed, TentaclesStartRolledUpAtRestAndEndStraight) {
  const Scene scene = Stowed();
  auto rods = MakeRods(scene, 0).value();
  for (Driven& d : rods) {
    const auto drive = [&](double time) {
      ApplyDrive(DriveAt(scene, d, CarrierGrowthAt(scene, rods, time), time), d, d.rod);
    };
    drive(0.499);
    EXPECT_LT(EnergyOf(d.rod).total(), 1e-15);  // the roll is its rest shape
    EXPECT_GT(d.rod.rest_curvature.norm(), 10);
    drive(0.7);
    const double half = d.rod.rest_curvature.row(1).maxCoeff();
    EXPECT_NEAR(half, 0.5 * d.actuation->roll()->row(1).tail(99).maxCoeff(), 1e-9);
    drive(0.9);
    EXPECT_LT(d.rod.rest_curvature.norm(), 1e-12);  // pulls wait for it
    EXPECT_EQ(d.actuation->PullAt(0.9), 0);
    EXPECT_GT(d.actuation->PullAt(1.5), 0);
    drive(60);
    EXPECT_GT(d.rod.rest_curvature.norm(), 10);
    // Rolls lie outside of the carrier.
    const Vector3d middle = MakeRods(scene, 0).value()[0].rod.position.rowwise().mean();
    EXPECT_GT(middle.head<2>().norm(), scene.gripper->gripper.carrier_radius);
    for (Index i = 0; i < 100; ++i) {
      const double strongest = d.actuation->strongest()[i];
      EXPECT_GE(strongest, d.actuation->roll()->col(i).norm());
      EXPECT_GE(strongest, d.actuation->Entry(d.actuation->entries() - 1).col(i).norm());
    }
  }
}

TEST(Stowed, SpringsThrowTheRollAwayFromTheCarrier) {
  Scene scene = Stowed();
  const auto rods = MakeRods(scene, 0).value();
  const std::optional<Ejection> push = EjectionOf(scene, rods[0]);
  ASSERT_TRUE(push.has_value());
  EXPECT_EQ(push->time, 0.5);
  EXPECT_EQ(push->velocity.col(0), Vector3d::Zero());
  const Vector3d away = rods[0].base_frame.row(2).transpose();
  EXPECT_LT(away.z(), -0.99);
  EXPECT_LT((push->velocity.rightCols<1>() - 2 * away).norm(), 1e-15);
  EXPECT_GT(push->velocity.col(5).norm(), 0);
  EXPECT_LT(push->velocity.col(5).norm(), 2);
  scene.gripper->stowed->eject_speed = 0;
  EXPECT_FALSE(EjectionOf(scene, rods[0]).has_value());
}

}  // namespace
}  // namespace tendril
