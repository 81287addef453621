// What bodies do that touch, slide, roll, stick and hang, in scenes as they are run, against closed forms.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "model/rods/press.h"
#include "model/scene/simulate.h"
#include "model/scene/stepper.h"
#include "tests/support/rigid_bodies.h"

namespace tendril {
namespace {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using testing_support::KineticEnergyOf;

constexpr double kGravity = 9.80665;

// A table, level; what is tilted is gravity.
Scene OnTable(double slope, double friction) {
  Scene scene;
  scene.gravity = kGravity * Vector3d(std::sin(slope), 0, -std::cos(slope));
  scene.contact.friction = friction;
  SceneObject table;
  table.name = table.kind = "table";
  table.shape = {{PrimitiveKind::kHalfSpace}};
  scene.objects = {table};
  return scene;
}

SceneObject Brick(const Vector3d& half, double mass) {
  SceneObject box;
  box.name = box.kind = "box";
  const BalancedShape balanced = Balanced({{PrimitiveKind::kBox, 0, half}}).value();
  box.shape = balanced.shape;
  box.motion = ObjectMotion::kFree;
  box.mass = mass;
  box.inertia = mass * balanced.inertia;
  return box;
}

// The depth at which a brick rests on its lower face.
double DepthAtRest(const Scene& scene, const SceneObject& box) {
  const double half = box.shape[0].half.z();
  int below = 0;
  for (const SurfaceSphere& at : SurfaceSpheres(box.shape)) below += at.centre.z() < -0.999 * half ? 1 : 0;
  return -box.mass * scene.gravity.z() / (below * SolidContact::StiffnessOf(scene.contact));
}

// A brick on the table, as it stands there when nothing tilts it; x at the times asked for.
std::vector<double> BrickSlides(double slope, double friction, const std::vector<double>& times) {
  Scene scene = OnTable(slope, friction);
  SceneObject box = Brick({0.03, 0.03, 0.01}, 0.1);
  box.pose.translation().z() = 0.01 - DepthAtRest(scene, box);
  scene.objects.push_back(box);
  const double step = 1e-4;
  Bodies bodies(scene, step);
  const std::vector<Wrench> none(2);
  std::vector<double> x;
  std::int64_t made = 0;
  for (const double time : times) {
    for (; static_cast<double>(made) * step < time; ++made) bodies.Step(0, none);
    x.push_back(bodies.PosesAt(0)[1].translation().x());
  }
  return x;
}

// A rod lying on the table, along the slope or across it.
Scene RodOnTable(double slope, double friction, bool across) {
  Scene scene = OnTable(slope, friction);
  scene.contact.damping = 0.5;
  SceneRod rod;
  rod.name = "rod";
  rod.design.base = EndHold::kFree;
  rod.design.direction = across ? Vector3d::UnitY() : Vector3d::UnitX();
  rod.design.normal = Vector3d::UnitZ();
  rod.design.length = 0.2;
  rod.design.elements = 20;
  rod.design.base_radius = 0.01;
  rod.design.density = 1000;
  rod.design.youngs_modulus = 1e6;
  rod.design.shear_modulus = 4e5;
  const double per_length = -scene.gravity.z() * 1000 * std::numbers::pi * 1e-4;
  const double depth = per_length / SurfaceStiffness(scene.contact.stiffness, 0.01);
  rod.design.start = -0.1 * rod.design.direction + Vector3d(0, 0, 0.01 - depth);
  scene.rods = {rod};
  return scene;
}

struct RodAt {
  double x = 0, speed = 0, spin = 0;  // mean position and velocity along x, and spin about the rod
};
std::vector<RodAt> RodMoves(const Scene& scene, const std::vector<double>& times) {
  const SimulationPlan plan = PlanScene(scene).value();
  EXPECT_TRUE(plan.object_contact);
  Stepper stepper(scene, plan, MakeRods(scene, 0).value(), plan.time_step);
  std::vector<RodAt> all;
  for (const double time : times) {
    const auto kicks = static_cast<std::int64_t>(std::llround(time / plan.time_step));
    const auto diverged = stepper.AdvanceTo(kicks);
    EXPECT_FALSE(diverged) << diverged->Sentence();
    const Rod rod = stepper.At(static_cast<double>(kicks) * plan.time_step)[0];
    const double mass = rod.mass.sum();
    all.push_back({rod.position.row(0).dot(rod.mass) / mass, rod.velocity.row(0).dot(rod.mass) / mass,
                   rod.spin.row(2).mean()});
  }
  return all;
}

// Let go all at once it slips by a millimetre or so before it stays.
TEST(ABrickOnASlope, SlidesJustAboveTheAngleWhoseTangentIsMuAndNotBelow) {
  for (const double mu : {0.2, 0.5}) {
    const std::vector<double> below = BrickSlides(std::atan(0.9975 * mu), mu, {0, 2, 3});
    EXPECT_LT(std::abs(below[2] - below[1]), 1e-6) << mu;
    const std::vector<double> above = BrickSlides(std::atan(1.0025 * mu), mu, {0, 2, 3});
    EXPECT_GT(above[2] - above[1], 1e-3) << mu;
  }
}

TEST(ABrickOnASlope, SlidesWithWhatFrictionLeavesOfItsWeight) {
  for (const double mu : {0.0, 0.1, 0.3}) {
    const double slope = 0.5;
    const std::vector<double> x = BrickSlides(slope, mu, {0.2, 0.6, 1.0});
    const double expected = kGravity * (std::sin(slope) - mu * std::cos(slope));
    EXPECT_NEAR((x[2] - 2 * x[1] + x[0]) / (0.4 * 0.4), expected, 0.005 * expected) << mu;
  }
}

TEST(ABrickOnASlope, DoesNotCreep) {
  for (const double share : {0.1, 0.5, 0.9}) {
    const std::vector<double> x = BrickSlides(std::atan(share * 0.4), 0.4, {2, 3, 4});
    EXPECT_LT(std::abs(x[1] - x[0]), 1e-6) << share;
    EXPECT_LT(std::abs(x[2] - x[1]), 1e-8) << share;
  }
}

TEST(ARodOnASlope, SlidesJustAboveTheAngleWhoseTangentIsMuAndNotBelow) {
  const double mu = 0.3;
  const std::vector<RodAt> below = RodMoves(RodOnTable(std::atan(0.9975 * mu), mu, false), {0, 2, 3});
  EXPECT_LT(std::abs(below[2].x - below[1].x), 1e-6);
  const std::vector<RodAt> above = RodMoves(RodOnTable(std::atan(1.0025 * mu), mu, false), {0, 2, 3});
  EXPECT_GT(above[2].x - above[1].x, 1e-3);
}

TEST(ARodOnASlope, SlidesWithWhatFrictionLeavesOfItsWeight) {
  for (const double mu : {0.0, 0.3}) {
    const double slope = 0.5, expected = kGravity * (std::sin(slope) - mu * std::cos(slope));
    const std::vector<RodAt> at = RodMoves(RodOnTable(slope, mu, false), {0.2, 0.6});
    EXPECT_NEAR((at[1].speed - at[0].speed) / 0.4, expected, 0.005 * expected) << mu;
  }
}

TEST(ARodOnASlope, DoesNotCreep) {
  const std::vector<RodAt> at = RodMoves(RodOnTable(std::atan(0.5 * 0.4), 0.4, false), {2, 3});
  EXPECT_LT(std::abs(at[1].x - at[0].x), 1e-6);
}

// A solid cylinder that rolls has half as much inertia again: a = 2/3 g sin; friction gives a third of the
// weight along the slope, and slips where mu < tan / 3.
TEST(ARodAcrossASlope, RollsWithTwoThirdsOfTheFall) {
  const double slope = 0.3, expected = 2.0 / 3 * kGravity * std::sin(slope);
  const std::vector<RodAt> at = RodMoves(RodOnTable(slope, 0.5, true), {0.1, 0.5});
  EXPECT_NEAR((at[1].speed - at[0].speed) / 0.4, expected, 0.01 * expected);
  EXPECT_NEAR(at[1].spin * 0.01, at[1].speed, 0.01 * at[1].speed);
}

// So slender that the plan makes it slower to bend: not so to turn about itself.
TEST(ARodAcrossASlope, RollsLikewiseWhereItIsSlender) {
  const double slope = 0.3, expected = 2.0 / 3 * kGravity * std::sin(slope);
  Scene scene = RodOnTable(slope, 0.5, true);
  RodDesign& rod = scene.rods[0].design;
  scene.contact.damping = 0.005;
  rod.base_radius = 0.001;
  rod.length = 0.6;
  rod.elements = 40;
  const double per_length = -scene.gravity.z() * 1000 * std::numbers::pi * 1e-6;
  rod.start = Vector3d(0, -0.3, 0.001 - per_length / SurfaceStiffness(scene.contact.stiffness, 0.001));
  const std::vector<RodAt> at = RodMoves(scene, {0.05, 0.15});
  EXPECT_NEAR((at[1].speed - at[0].speed) / 0.1, expected, 0.01 * expected);
}

TEST(ARodAcrossASlope, SlipsWhereMuIsBelowAThirdOfTheTangent) {
  const double slope = 0.6, mu = 0.5 * std::tan(slope) / 3;
  const std::vector<RodAt> at = RodMoves(RodOnTable(slope, mu, true), {0.1, 0.5});
  const double expected = kGravity * (std::sin(slope) - mu * std::cos(slope));
  EXPECT_NEAR((at[1].speed - at[0].speed) / 0.4, expected, 0.01 * expected);
  // The couple of mu N turns it by 2 mu g cos / r.
  const double turning = 2 * mu * kGravity * std::cos(slope) / 0.01;
  EXPECT_NEAR((at[1].spin - at[0].spin) / 0.4, turning, 0.01 * turning);
}

TEST(ABrickThatIsDropped, ComesToRestOnTheTable) {
  for (const Vector3d& axis : {Vector3d(1, 0, 0), Vector3d(1, 2, -0.5)}) {
    Scene scene = OnTable(0, 0.4);
    SceneObject box = Brick({0.03, 0.02, 0.01}, 0.1);
    box.pose.linear() = Eigen::AngleAxisd(0.3, axis.normalized()).toRotationMatrix();
    box.pose.translation().z() = 0.06;
    box.spin = {1, 0, 2};
    scene.objects.push_back(box);
    Bodies bodies(scene, 1e-4);
    const double start = box.mass * kGravity * 0.05;
    for (int step = 0; step < 40000; ++step) {
      bodies.Step(0, std::vector<Wrench>(2));
      ASSERT_LT(KineticEnergyOf(bodies.body(1)), 1.2 * start) << step;
    }
    EXPECT_LT(KineticEnergyOf(bodies.body(1)), 1e-12 * start);
    const Isometry3d pose = bodies.PosesAt(0)[1];
    EXPECT_NEAR(pose.translation().z(), 0.01 - DepthAtRest(scene, box), 1e-6);
    EXPECT_NEAR(std::abs(pose.linear()(2, 2)), 1, 1e-9);
  }
}

// Beside a rod that is far away and does nothing, as scenes need one.
Scene Hanging(const BodyString& string, double turned) {
  Scene scene;
  SceneRod rod;
  rod.name = "away";
  rod.design.start = {5, 0, 0};
  rod.design.length = 0.2;
  rod.design.elements = 10;
  rod.design.direction = -Vector3d::UnitZ();
  scene.rods = {rod};
  SceneObject box = Brick({0.01, 0.02, 0.05}, 0.2);
  box.motion = ObjectMotion::kHanging;
  box.string = string;
  const double below = string.length + string.to_in_body.z();
  box.pose.linear() = Eigen::AngleAxisd(turned, Vector3d::UnitY()).toRotationMatrix();
  box.pose.translation() = string.from - below * box.pose.linear().col(2);
  scene.objects = {box};
  return scene;
}

// By where its middle comes by, s.
double Period(Scene scene) {
  scene.duration = 3;
  scene.time_step = 2e-4;
  std::vector<double> times;
  for (int k = 0; k <= 3000; ++k) times.push_back(1e-3 * k);
  const Simulated run = Simulate(scene, PlanScene(scene).value(), times).value();
  const std::vector<Isometry3d>& poses = run.objects[0].poses;
  std::vector<double> crossings;
  for (std::size_t k = 1; k < poses.size(); ++k) {
    const double before = poses[k - 1].translation().x(), x = poses[k].translation().x();
    if (before * x < 0) crossings.push_back(times[k - 1] + 1e-3 * before / (before - x));
  }
  return crossings.size() < 5 ? 0 : 0.5 * (crossings[4] - crossings[0]);
}

TEST(AnObjectThatHangs, SwingsWithThePeriodOfAPendulum) {
  for (const double angle : {0.05, 1.0}) {
    const double longer = std::comp_ellint_1(std::sin(angle / 2)) / (0.5 * std::numbers::pi);
    // By its centre: it does not turn.
    const double simple = 2 * std::numbers::pi * std::sqrt(0.25 / kGravity) * longer;
    EXPECT_NEAR(Period(Hanging({Vector3d(0, 0, 1), Vector3d::Zero(), 0.25}, angle)), simple, 1e-4 * simple);
    // On a ball joint at its upper end: a plate of edges 2 cm and 10 cm.
    const double inertia = (0.01 * 0.01 + 0.05 * 0.05) / 3 + 0.05 * 0.05;
    const double compound = 2 * std::numbers::pi * std::sqrt(inertia / (kGravity * 0.05)) * longer;
    EXPECT_NEAR(Period(Hanging({Vector3d(0, 0, 1), Vector3d(0, 0, 0.05), 0}, angle)), compound,
                1e-4 * compound);
  }
}

TEST(AnObjectThatHangs, StaysWhereItIsAtRest) {
  const Scene scene = Hanging({Vector3d(0.1, 0.2, 1), Vector3d(0, 0, 0.05), 0.25}, 0);
  const SimulationPlan plan = PlanScene(scene).value();
  Stepper stepper(scene, plan, MakeRods(scene, 0).value(), plan.time_step);
  const auto kicks = static_cast<std::int64_t>(std::llround(2 / plan.time_step));
  ASSERT_FALSE(stepper.AdvanceTo(kicks));
  const Isometry3d pose = stepper.PosesAt(static_cast<double>(kicks) * plan.time_step)[0];
  EXPECT_LT((pose.matrix() - scene.objects[0].pose.matrix()).cwiseAbs().maxCoeff(), 1e-9);
}

struct Momenta {
  Vector3d linear = Vector3d::Zero(), angular = Vector3d::Zero();
  double size = 0, angular_size = 0, energy = 0;  // sizes: sums of parts' lengths
};
Momenta MomentaOf(const std::vector<Rod>& rods, const SimulationPlan& plan, double stiffness) {
  Momenta all;
  for (const Rod& rod : rods) {
    all.energy += EnergyOf(rod).total();
    for (Index i = 0; i < rod.mass.size(); ++i) {
      const Vector3d momentum = rod.mass[i] * rod.velocity.col(i), at = rod.position.col(i);
      all.linear += momentum;
      all.angular += at.cross(momentum);
      all.size += momentum.norm();
      all.angular_size += at.norm() * momentum.norm();
    }
    for (Index i = 0; i < rod.elements(); ++i) {
      all.angular += rod.directors[static_cast<std::size_t>(i)].transpose() *
                     rod.inertia.col(i).cwiseProduct(rod.spin.col(i));
    }
  }
  const auto side = [](const Rod& rod, Index i) {
    return PressSide{rod.position.col(i), rod.position.col(i + 1), rod.radius[i], rod.rest_length[i]};
  };
  for (Index i = 0; i < rods[0].elements(); ++i) {
    for (Index j = 0; j < rods[1].elements(); ++j) {
      all.energy += PressOf(stiffness, plan.contact_points, side(rods[1], i), side(rods[0], j)).energy;
    }
  }
  return all;
}

TEST(TwoRodsThatCollideWithFriction, KeepMomentaAndGainNoEnergy) {
  for (const double damping : {0.0, 0.1}) {
    Scene scene;
    scene.gravity.setZero();
    scene.contact.friction = 0.3;
    scene.contact.static_friction = 0.5;
    scene.contact.damping = damping;
    for (int k = 0; k < 2; ++k) {
      SceneRod rod;
      rod.name = std::to_string(k);
      rod.design.base = EndHold::kFree;
      rod.design.length = 0.3;
      rod.design.elements = 30;
      rod.design.base_radius = 0.01;
      rod.design.density = 500;
      rod.design.youngs_modulus = 1e6;
      rod.design.shear_modulus = 4e5;
      rod.design.direction = k == 0 ? Vector3d(1, 0, 0) : Vector3d(0.5, 1, 0.1);
      rod.design.normal = Vector3d::UnitZ();
      rod.design.start = Vector3d(0.02 * k, 0.01, 0.03 * k) - 0.15 * rod.design.direction.normalized();
      rod.velocity = k == 0 ? Vector3d(0.3, 0, 0.2) : Vector3d(0, -0.2, -0.5);
      rod.spin = k == 0 ? Vector3d(20, 0, 1) : Vector3d(0, 3, 0);
      scene.rods.push_back(rod);
    }
    const SimulationPlan plan = PlanScene(scene).value();
    Stepper stepper(scene, plan, MakeRods(scene, 0).value(), plan.time_step);
    Momenta start;
    double largest = 0, last = 0;
    for (int look = 0; look <= 100; ++look) {
      const std::int64_t kicks = look * std::llround(0.004 / plan.time_step);
      ASSERT_FALSE(stepper.AdvanceTo(kicks));
      const Momenta now =
          MomentaOf(stepper.At(static_cast<double>(kicks) * plan.time_step), plan, scene.contact.stiffness);
      if (look == 0) start = now;
      EXPECT_LT((now.linear - start.linear).norm(), 1e-10 * start.size) << look;
      EXPECT_LT((now.angular - start.angular).norm(), 1e-10 * start.angular_size) << look;
      largest = std::max(largest, now.energy / start.energy);
      last = now.energy / start.energy;
    }
    EXPECT_LT(stepper.contacts()->least_share(), 0.99) << "they did not touch";
    EXPECT_LT(largest, 1 + 1e-3) << damping;
    EXPECT_LT(last, 0.99) << "friction took nothing";
    EXPECT_GT(last, 0.2);
  }
}

}  // namespace
}  // namespace tendril
