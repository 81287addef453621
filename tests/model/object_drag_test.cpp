// model/objects/object_drag.h: sinking against closed forms, limits between kinds, unions, energy.
#include "model/objects/object_drag.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace tendril {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

const Medium kWater = {.density = 1000};
const Vector3d kGravity(0, 0, -9.81);

Primitive Part(PrimitiveKind kind, double radius, const Vector3d& half = {0, 0, 0.04}) {
  return {.kind = kind, .radius = radius, .half = half};
}

// Kicks along z with the added mass of that direction, until it sinks at an even speed.
double SinkingSpeed(const Shape& shape, double density) {
  const ObjectDrag drag = DragOf(shape).value();
  RigidBody body;
  body.mass = density * drag.volume;
  const double mass = body.mass + AddedMass(drag, kWater)(2, 2);
  const double step = 1e-4;
  for (int k = 0; k < 50000; ++k) {
    const BodyLoad load = ForceOnBody(drag, body, kWater, kGravity, step);
    body.velocity += step / mass * (load.force + body.mass * kGravity);
  }
  return -body.velocity.z();
}

TEST(ObjectDrag, ASphereSinksAsItsClosedFormSays) {
  const double r = 0.01, excess = 200;
  const double exact = std::sqrt(8.0 / 3 * excess / kWater.density * 9.81 * r / 0.47);
  EXPECT_NEAR(SinkingSpeed({Part(PrimitiveKind::kSphere, r)}, 1200) / exact, 1, 1e-3);
}

TEST(ObjectDrag, ACylinderSinksAcrossAndAlongAsItsClosedFormsSay) {
  const double r = 0.01, half = 0.04, excess = 200;
  Primitive upright = Part(PrimitiveKind::kCylinder, r), lying = upright;
  lying.object_from_primitive.rotate(Eigen::AngleAxisd(pi / 2, Vector3d::UnitY()));
  const double across = std::sqrt(excess * 9.81 * pi * r / (kWater.density * 1.1));
  const double along = std::sqrt(2 * excess * 9.81 * 2 * half / (kWater.density * 0.82));
  EXPECT_NEAR(SinkingSpeed({lying}, 1200) / across, 1, 1e-3);
  EXPECT_NEAR(SinkingSpeed({upright}, 1200) / along, 1, 1e-3);
}

TEST(ObjectDrag, AFallBeginsWithTheAddedMass) {
  const ObjectDrag drag = DragOf({Part(PrimitiveKind::kSphere, 0.02)}).value();
  RigidBody body;
  body.mass = 1500 * drag.volume;
  const Vector3d force = ForceOnBody(drag, body, kWater, kGravity, 0.1).force + body.mass * kGravity;
  const double acceleration = force.z() / (body.mass + AddedMass(drag, kWater)(2, 2));
  EXPECT_NEAR(acceleration, -(1500.0 - 1000) / (1500 + 0.5 * 1000) * 9.81, 1e-12);
}

TEST(ObjectDrag, AShortCapsuleIsASphere) {
  const DragPart ball = DragOf({Part(PrimitiveKind::kCapsule, 0.02, {0, 0, 0})}).value().parts[0];
  const DragPart capsule = DragOf({Part(PrimitiveKind::kCapsule, 0.02, {0, 0, 1e-12})}).value().parts[0];
  const DragPart sphere = DragOf({Part(PrimitiveKind::kSphere, 0.02)}).value().parts[0];
  EXPECT_EQ(ball.area, sphere.area);
  EXPECT_LT((capsule.area - sphere.area).norm(), 1e-9 * sphere.area.norm());
  EXPECT_LT((capsule.added - sphere.added).norm(), 1e-9 * sphere.added.norm());
  EXPECT_LT((capsule.turning - sphere.turning).norm(), 1e-9 * sphere.turning.norm());
}

// Two balls far out on a bar turn as balls on a circle do.
TEST(ObjectDrag, AUnionIsTheSumOfItsParts) {
  Shape balls(2, Part(PrimitiveKind::kSphere, 0.01));
  balls[0].object_from_primitive.translation() = Vector3d(0.5, 0, 0);
  balls[1].object_from_primitive.translation() = Vector3d(-0.5, 0, 0);
  RigidBody body;
  body.angular_momentum_in_body = {0, 0, 3};
  const BodyLoad load = ForceOnBody(DragOf(balls).value(), body, kWater, Vector3d::Zero(), 0);
  const double speed = 3 * 0.5;
  EXPECT_LT(load.force.norm(), 1e-12);
  const double one = 0.5 * 1000 * 0.47 * pi * 1e-4 * speed * speed;
  EXPECT_NEAR(load.torque.z(), -2 * one * 0.5, 1e-5 * one);
}

TEST(ObjectDrag, StripsOfALongCylinderAddUpToItsTurning) {
  const double r = 0.005, half = 0.2, spin = 2;
  double torque = 0;
  for (int k = 0; k < 10000; ++k) {
    const double s = half * (2 * k + 1 - 10000) / 10000, strip = 2 * half / 10000;
    torque += 0.5 * 1000 * 1.1 * 2 * r * strip * spin * spin * std::abs(s * s * s);
  }
  RigidBody body;
  body.angular_momentum_in_body = {spin, 0, 0};
  const ObjectDrag drag = DragOf({Part(PrimitiveKind::kCylinder, r, {0, 0, half})}).value();
  EXPECT_NEAR(-ForceOnBody(drag, body, kWater, Vector3d::Zero(), 0).torque.x() / torque, 1, 1e-3);
}

// Any shape, any motion, steps from short to far beyond what drag takes to stop a body.
TEST(ObjectDrag, TakesEnergyWhateverTheStep) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const auto any = [&] { return Vector3d(normal(random), normal(random), normal(random)); };
  const PrimitiveKind kinds[] = {PrimitiveKind::kSphere, PrimitiveKind::kCapsule, PrimitiveKind::kCylinder,
                                 PrimitiveKind::kBox};
  for (int trial = 0; trial < 2000; ++trial) {
    Shape shape;
    for (int k = 0; k < 3; ++k) {
      shape.push_back(Part(kinds[random() % 4], 0.02, Vector3d(0.01, 0.02, 0.03)));
      shape.back().object_from_primitive.translation() = 0.1 * any();
      shape.back().object_from_primitive.rotate(Eigen::AngleAxisd(normal(random), any().normalized()));
    }
    RigidBody body;
    body.mass = 0.1;
    body.inertia = 1e-4 * Vector3d(1, 2, 2.5);
    body.lab_from_body = Eigen::AngleAxisd(normal(random), any().normalized());
    body.velocity = any();
    body.angular_momentum_in_body = 1e-3 * any();
    const double step = std::pow(10, -6 + trial % 9);
    const auto energy = [&] {
      return 0.5 * body.mass * body.velocity.squaredNorm() +
             0.5 * body.angular_momentum_in_body.cwiseAbs2().cwiseQuotient(body.inertia).sum();
    };
    const double before = energy();
    const BodyLoad load = ForceOnBody(DragOf(shape).value(), body, kWater, Vector3d::Zero(), step);
    body.velocity += step / body.mass * load.force;
    body.angular_momentum_in_body += step * (body.lab_from_body.inverse() * load.torque);
    ASSERT_LT(energy(), before) << "trial " << trial << ", step " << step;
    ASSERT_TRUE(body.velocity.allFinite());
  }
}

TEST(ObjectDrag, NamesWhatItCannotDrag) {
  EXPECT_FALSE(DragOf({}).ok());
  EXPECT_FALSE(DragOf({Part(PrimitiveKind::kSphere, 0)}).ok());
  EXPECT_FALSE(DragOf({Part(PrimitiveKind::kCylinder, 0.01, {0, 0, NAN})}).ok());
  EXPECT_FALSE(DragOf({Part(PrimitiveKind::kBox, 0, {0.1, 0, 0.1})}).ok());
  const auto table = DragOf({Part(PrimitiveKind::kHalfSpace, 0)});
  ASSERT_FALSE(table.ok());
  EXPECT_NE(table.error().message.find("half space"), std::string::npos);
}

TEST(ObjectDrag, NothingInVacuum) {
  RigidBody body;
  body.velocity = {1, 2, 3};
  const ObjectDrag drag = DragOf({Part(PrimitiveKind::kSphere, 0.02)}).value();
  EXPECT_EQ(ForceOnBody(drag, body, {}, kGravity, 1).force.norm(), 0);
  EXPECT_EQ(AddedMass(drag, {}).norm(), 0);
}

}  // namespace
}  // namespace tendril
