// model/rods/solid_contact.h: objects that meet make no momentum and no energy, whichever is named first.
#include "model/rods/solid_contact.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <span>
#include <vector>

#include "model/rods/roughness.h"
#include "model/scene/bodies.h"
#include "tests/support/rigid_bodies.h"

namespace tendril {
namespace {

using Eigen::Vector3d;
using testing_support::KineticEnergyOf;

constexpr double kStep = 1e-4;

SceneObject Free(const Shape& shape, double mass) {
  SceneObject object;
  const BalancedShape balanced = Balanced(shape).value();
  object.shape = balanced.shape;
  object.motion = ObjectMotion::kFree;
  object.mass = mass;
  object.inertia = mass * balanced.inertia;
  return object;
}

// A box, a cylinder and a capsule that fly into each other, turning.
Scene Meeting() {
  Scene scene;
  scene.gravity.setZero();
  scene.contact.friction = 0.4;
  scene.contact.static_friction = 0.6;
  scene.objects = {Free({{PrimitiveKind::kBox, 0, {0.03, 0.02, 0.015}}}, 0.1),
                   Free({{PrimitiveKind::kCylinder, 0.02, {0, 0, 0.02}}}, 0.06),
                   Free({{PrimitiveKind::kCapsule, 0.015, {0, 0, 0.03}}}, 0.04)};
  const double x[] = {-0.06, 0.02, 0.1};
  for (std::size_t b = 0; b < 3; ++b) {
    SceneObject& object = scene.objects[b];
    const double k = static_cast<double>(b);
    object.pose.linear() = Eigen::AngleAxisd(1 + k, Vector3d(1, k, -1).normalized()).toRotationMatrix();
    object.pose.translation() = Vector3d(x[b], 0.003 * k, -0.002 * k);
    object.velocity = Vector3d(0.5 * (1 - k), 0.05 * (k - 1), 0.02);
    object.spin = {2 * k, 3, 1 - k};
  }
  return scene;
}

struct Momenta {
  Vector3d linear = Vector3d::Zero(), angular = Vector3d::Zero();
};
Momenta MomentaOf(const Bodies& bodies, std::size_t count) {
  Momenta all;
  for (std::size_t b = 0; b < count; ++b) {
    const RigidBody& body = bodies.body(b);
    all.linear += body.mass * body.velocity;
    all.angular +=
        body.mass * body.position.cross(body.velocity) + body.lab_from_body * body.angular_momentum_in_body;
  }
  return all;
}

TEST(Roughness, IsASolidsOwnBeforeTheContacts) {
  Contact contact;
  contact.friction = 0.3;
  contact.static_friction = 0.5;
  Solid plain, ice, rubber;
  ice.friction = 0.02;
  rubber.friction = 0.9, rubber.static_friction = 1.1;
  EXPECT_EQ(RoughnessOf(contact, plain).at_rest, 0.5);
  EXPECT_EQ(RoughnessOf(contact, ice).at_rest, 0.02);
  EXPECT_EQ(RoughnessOf(contact, plain, plain).kinetic, 0.3);
  // Of two the rougher counts.
  EXPECT_EQ(RoughnessOf(contact, ice, plain).at_rest, 0.5);
  EXPECT_EQ(RoughnessOf(contact, plain, ice).kinetic, 0.3);
  EXPECT_EQ(RoughnessOf(contact, ice, rubber).kinetic, 0.9);
  EXPECT_EQ(RoughnessOf(contact, rubber, ice).at_rest, 1.1);
}

double EnergyOf(const Bodies& bodies) {
  double energy = 0;
  for (std::size_t b = 0; b < 3; ++b) energy += KineticEnergyOf(bodies.body(b));
  return energy;
}

TEST(SolidContact, OfThreeThatMeetKeepsMomentaAndGainsNoEnergy) {
  const Scene scene = Meeting();
  Bodies bodies(scene, kStep);
  const Momenta start = MomentaOf(bodies, 3);
  const double energy = EnergyOf(bodies);
  const std::vector<Wrench> none(3);
  double largest = 0;
  for (int step = 0; step < 10000; ++step) {
    bodies.Step(0, none);
    const Momenta now = MomentaOf(bodies, 3);
    ASSERT_LT((now.linear - start.linear).norm(), 1e-10 * 0.1) << step;
    ASSERT_LT((now.angular - start.angular).norm(), 1e-10 * 0.01) << step;
    largest = std::max(largest, EnergyOf(bodies));
  }
  EXPECT_LT(largest, energy * (1 + 1e-6));
  EXPECT_LT(EnergyOf(bodies), 0.8 * energy) << "they did not meet";
}

TEST(SolidContact, OrderDoesNotCount) {
  const Scene scene = Meeting();
  Scene reversed = scene;
  std::reverse(reversed.objects.begin(), reversed.objects.end());
  Bodies bodies(scene, kStep), other(reversed, kStep);
  const std::vector<Wrench> none(3);
  for (int step = 0; step < 2000; ++step) {
    bodies.Step(0, none);
    other.Step(0, none);
    for (std::size_t b = 0; b < 3; ++b) {
      ASSERT_LT((bodies.solids()[b].pose.matrix() - other.solids()[2 - b].pose.matrix()).norm(), 1e-9)
          << step << ", " << b;
    }
  }
}

// Between any poses and motions: pressing apart from friction and damping, both together take energy.
TEST(SolidContact, FrictionAndDampingGiveOutNoEnergy) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const auto draw = [&] { return Vector3d(normal(random), normal(random), normal(random)); };
  Contact contact;
  contact.friction = 0.4;
  contact.static_friction = 0.6;
  const double stiffness = SolidContact::StiffnessOf(contact);
  int touched = 0;
  for (int run = 0; run < 300; ++run) {
    // A ball has one place of its surface: its depth and springs are known from outside.
    std::vector<Solid> solids(2);
    solids[0].shape = {{PrimitiveKind::kSphere, 0.02}};
    solids[1].shape = {{PrimitiveKind::kBox, 0, {0.03, 0.02, 0.01}}};
    solids[1].pose.linear() = Eigen::AngleAxisd(normal(random), draw().normalized()).toRotationMatrix();
    solids[0].pose.translation() = solids[1].pose * Vector3d(0.01 * normal(random), 0, 0.0295);
    const double masses[] = {0.1, 0};
    SolidContact of_both(contact, solids, masses);
    for (int step = 0; step < 40; ++step) {
      if (step % 8 == 0) {
        for (Solid& solid : solids) solid.velocity = 0.2 * draw(), solid.spin = 20 * draw();
      }
      const auto stored = [&] {
        const std::vector<double> saved = of_both.Save();
        return 0.5 * stiffness * (saved[0] * saved[0] + saved[1] * saved[1] + saved[2] * saved[2]);
      };
      const double before = stored();
      std::vector<Wrench> wrenches(2);
      of_both.Add(solids, kStep, wrenches);
      double power = 0;
      for (std::size_t s = 0; s < 2; ++s) {
        power += wrenches[s].force.dot(solids[s].velocity) + wrenches[s].torque.dot(solids[s].spin);
      }
      const SurfaceDistance at =
          DistanceTo(solids[1].shape[0], solids[1].pose.inverse() * solids[0].pose.translation());
      const double depth = 0.02 - at.distance;
      if (depth > 0) {
        ++touched;
        const Vector3d out = solids[1].pose.linear() * at.normal;
        const Vector3d point = solids[0].pose.translation() - 0.5 * (0.02 + at.distance) * out;
        const Vector3d of_box =
            solids[1].velocity + solids[1].spin.cross(point - solids[1].pose.translation());
        const Vector3d of_ball =
            solids[0].velocity + solids[0].spin.cross(point - solids[0].pose.translation());
        const double pressing = stiffness * depth * out.dot(of_ball - of_box);
        ASSERT_LE((power - pressing) * kStep + stored() - before,
                  1e-12 * (std::abs(power * kStep) + std::abs(pressing * kStep) + before))
            << run << ", " << step;
      }
      for (Solid& solid : solids) {
        solid.pose.translation() += kStep * solid.velocity;
        solid.pose.linear() =
            Eigen::AngleAxisd(kStep * solid.spin.norm(), solid.spin.normalized()) * solid.pose.linear();
      }
    }
  }
  EXPECT_GT(touched, 1000);
}

TEST(SolidContact, SpringsAreSavedAndRestored) {
  const Scene scene = Meeting();
  Bodies bodies(scene, kStep), other(scene, kStep);
  const std::vector<Wrench> none(3);
  for (int step = 0; step < 1000; ++step) bodies.Step(0, none);
  ASSERT_TRUE(other.Restore(bodies.Save()));
  for (int step = 0; step < 1000; ++step) {
    bodies.Step(0, none);
    other.Step(0, none);
  }
  EXPECT_EQ(bodies.Save(), other.Save());
  std::vector<double> longer = bodies.Save();
  longer.push_back(0);
  EXPECT_FALSE(other.Restore(longer));
  EXPECT_FALSE(other.Restore(std::span(longer).first(5)));
}

}  // namespace
}  // namespace tendril
