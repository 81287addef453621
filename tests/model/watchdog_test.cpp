// model/scene/watchdog.h: what goes wrong is found where it is, and what goes well raises no alarm.
#include "model/scene/watchdog.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "model/scene/plan.h"
#include "model/scene/simulate.h"

namespace tendril {
namespace {

using Eigen::Vector3d;

Scene TwoRods() {
  Scene scene;
  scene.duration = 0.5;
  scene.gravity.setZero();
  for (int k = 0; k < 2; ++k) {
    SceneRod rod;
    rod.name = k == 0 ? "lower" : "upper";
    rod.design.length = 0.3;
    rod.design.base_radius = 0.01;
    rod.design.elements = 20;
    rod.design.base = EndHold::kFree;
    rod.design.direction = k == 0 ? Vector3d(1, 0, 0) : Vector3d(0, 1, 0);
    rod.design.normal = Vector3d::UnitZ();
    rod.design.start = k == 0 ? Vector3d(-0.15, 0, 0) : Vector3d(0.01, -0.14, 0.03);
    rod.velocity = {0, 0, k == 0 ? 0.0 : -1.0};
    scene.rods.push_back(rod);
  }
  return scene;
}

TEST(Watchdog, NamesTheElementThatIsNotFinite) {
  const Scene scene = TwoRods();
  const std::vector<Driven> rods = MakeRods(scene, 0).value();
  std::vector<Rod> at{rods[0].rod, rods[1].rod};
  EXPECT_FALSE(FindNotFinite(rods, at));
  at[1].velocity(2, 7) = std::numeric_limits<double>::quiet_NaN();
  const auto found = FindNotFinite(rods, at);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->rod, "upper");
  EXPECT_EQ(found->element, 7);
}

TEST(Watchdog, NamesTheDeepestOverlapTheFarthestTurnAndTheFastest) {
  const Scene scene = TwoRods();
  const std::vector<Driven> rods = MakeRods(scene, 0).value();
  std::vector<Rod> at{rods[0].rod, rods[1].rod};
  at[1].position.row(2).setConstant(0.005);
  const Divergence deepest = FindDeepest(scene, rods, at, {});
  EXPECT_EQ(deepest.rod, "upper");
  EXPECT_EQ(deepest.element, 9) << deepest.why;  // of 20 over 0.3 m, at y = 0
  EXPECT_NE(deepest.why.find("lower, element 10"), std::string::npos) << deepest.why;

  at[0].spin.col(3) = Vector3d(0, 500, 0);
  const Divergence turned = FindFarTurned(rods, at, 1e-3);
  EXPECT_EQ(turned.rod + std::to_string(turned.element), "lower3") << turned.why;
  at[1].velocity.col(16) = Vector3d(0, 0, 9);
  const Divergence fastest = FindFastest(rods, at);
  EXPECT_EQ(fastest.rod + std::to_string(fastest.element), "upper15") << fastest.why;
}

// Elements of 15 mm that pass a thin bar: what is nearest is beside their middles.
TEST(Watchdog, FindsTheDeepestPlaceAlongAnElement) {
  Scene scene = TwoRods();
  SceneObject bar;
  bar.name = "bar";
  bar.shape = {{PrimitiveKind::kCapsule, 0.002, {0, 0, 0.1}}};
  for (const double along : {0.0, 0.004, 0.0149}) {
    const std::vector<Driven> rods = MakeRods(scene, 0).value();
    std::vector<Rod> at{rods[0].rod};
    const Vector3d start = at[0].position.col(7), end = at[0].position.col(8);
    const double radius = at[0].radius[7];
    const Vector3d tangent = (end - start).normalized(), side = tangent.unitOrthogonal();
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() =
        Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), tangent.cross(side)).toRotationMatrix();
    // Across the rod, 0.9 of its radius deep.
    pose.translation() = start + along * tangent + (0.1 * radius + 0.002) * side;
    scene.objects = {bar};
    scene.rods.resize(1);
    const Divergence deepest = FindDeepest(scene, {rods[0]}, at, {pose});
    EXPECT_NE(deepest.why.find(", 0.9 of its radius"), std::string::npos) << along << ": " << deepest.why;
    EXPECT_TRUE(deepest.element == 7 || (along == 0 && deepest.element == 6)) << deepest.element;
  }
}

TEST(Watchdog, SoftContactStopsTheRunBeforeAxesCross) {
  Scene scene = TwoRods();
  scene.contact.stiffness = 1;
  const Simulated run = Simulate(scene, PlanScene(scene).value(), {0, 0.01, 0.5}).value();
  ASSERT_TRUE(run.diverged);
  EXPECT_NE(run.diverged->why.find("of the radii's sum"), std::string::npos) << run.diverged->why;
  EXPECT_EQ(run.diverged->rod, "upper");
  EXPECT_NEAR(run.diverged->time, 0.02, 0.004) << "0.02 m to go at 1 m/s";
  EXPECT_EQ(run.curves[0].time.size(), 2) << "what was reached is kept";
  scene.contact.stiffness = 1e4;
  EXPECT_FALSE(Simulate(scene, PlanScene(scene).value(), {0.5}).value().diverged);
}

// Energy that comes from the step: just beyond the limit it grows slowly, without a number that would give it
// away at once.
TEST(Watchdog, AStepBarelyTooLongIsFound) {
  Scene scene = TwoRods();
  scene.rods.resize(1);
  scene.rods[0].velocity = {0, 0, 0.1};
  scene.rods[0].spin = {0, 5, 3};
  const double stable = StableStepsOf(MakeRods(scene, 0).value()[0].rod, 0).Least();
  scene.duration = 2000 * stable;
  scene.time_step = 1.25 * stable;
  const Simulated bad = Simulate(scene, PlanScene(scene).value(), {scene.duration}).value();
  ASSERT_TRUE(bad.diverged);
  EXPECT_LT(bad.diverged->suggested_step, stable);
  scene.time_step = 0.9 * stable;
  EXPECT_FALSE(Simulate(scene, PlanScene(scene).value(), {scene.duration}).value().diverged);
}

// No more energy comes into a scene than its budget says: the alarm at ten times as much is never false.
TEST(Watchdog, TheBudgetHoldsForWhatScenesDo) {
  for (int k = 0; k < 4; ++k) {
    Scene scene = TwoRods();
    scene.rods.resize(1);
    SceneRod& rod = scene.rods[0];
    rod.design.base = EndHold::kFrame;
    if (k == 0) scene.gravity = {0, 0, -9.8};
    if (k == 1) rod.rest_curvature = {5, -20, 8};  // all at once
    if (k == 2) rod.tip_force = {0, 0.1, -0.05};
    if (k == 3) {
      rod.design.tip = EndHold::kFrame;
      rod.tip_motion = {.velocity = {-0.5, 0, 0.1}, .spin = {30, 0, 0}, .from = 0, .until = 0.2};
    }
    const std::vector<Driven> rods = MakeRods(scene, 0).value();
    const double budget = EnergyBudget(scene, rods);
    EXPECT_GT(budget, 0) << k;
    std::vector<double> times;
    for (int i = 0; i <= 50; ++i) times.push_back(0.01 * i);
    const Simulated run = Simulate(scene, PlanScene(scene).value(), times).value();
    ASSERT_FALSE(run.diverged) << k << run.diverged->Sentence();
    double fastest = 0;
    for (std::size_t f = 1; f < run.curves[0].curves.size(); ++f) {
      const auto moved = run.curves[0].curves[f].points - run.curves[0].curves[f - 1].points;
      double energy = 0;
      for (Eigen::Index i = 0; i < moved.cols(); ++i) {
        energy += 0.5 * rods[0].rod.mass[i] * (moved.col(i) / 0.01).squaredNorm();
      }
      fastest = std::max(fastest, energy);
    }
    EXPECT_LT(fastest, budget) << k;
    EXPECT_GT(fastest, 1e-4 * budget) << k << ": a budget that no scene could exceed";
  }
}

// Nothing holds it: after 3 s of free fall it is fast, and right.
TEST(Watchdog, AFreeFallIsNoDivergence) {
  Scene scene = TwoRods();
  scene.rods.resize(1);
  scene.duration = 3;
  scene.gravity = {0, 0, -9.8};
  const Simulated run = Simulate(scene, PlanScene(scene).value(), {3}).value();
  ASSERT_FALSE(run.diverged) << run.diverged->Sentence();
  EXPECT_NEAR(run.curves[0].curves[0].points(2, 10), -0.5 * 9.8 * 9, 1e-3);
}

}  // namespace
}  // namespace tendril
