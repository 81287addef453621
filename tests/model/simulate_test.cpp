// model/scene: plans, drives and steps; closed forms for what comes out.
#include "model/scene/simulate.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <set>

#include "model/fold/fold.h"
#include "model/fold/rising_fold.h"
#include "model/scene/actuation.h"

namespace tendril {
namespace {

using Eigen::Vector3d;

Scene OneRod() {
  Scene scene;
  scene.gravity.setZero();
  SceneRod rod;
  rod.name = "a";
  rod.design.length = 0.3;
  rod.design.base_radius = 0.012;
  rod.design.density = 100;
  rod.design.youngs_modulus = 1e6;
  rod.design.shear_modulus = 4e5;
  rod.design.elements = 60;
  rod.damping = 30;
  scene.rods = {rod};
  return scene;
}

TEST(Simulate, RestCurvatureAndTwistMakeAHelix) {
  Scene scene = OneRod();
  const double kappa = 7.5, tau = 5;
  scene.rods[0].rest_curvature = {0, kappa, tau};
  scene.rods[0].ramp_end = 0.5;
  const SimulationPlan plan = PlanScene(scene).value();
  EXPECT_FALSE(plan.rod_contact);
  const Simulated run = Simulate(scene, plan, {0, 2}).value();
  ASSERT_EQ(run.diverged.has_value(), false);
  const Eigen::Matrix3Xd points = run.curves[0].curves.back().points;
  // All nodes lie on a cylinder of radius kappa / (kappa^2 + tau^2) about the axis along tau d3 + kappa d2.
  const Vector3d axis = Vector3d(0, kappa, tau).normalized();
  const double radius = kappa / (kappa * kappa + tau * tau);
  // The curve bends from d3 toward kappa x d3 = d2 x d3 = d1.
  const Vector3d centre = Vector3d(radius, 0, 0);
  for (Eigen::Index i = 1; i < points.cols(); ++i) {
    const Vector3d from = points.col(i) - centre;
    EXPECT_NEAR((from - axis.dot(from) * axis).norm(), radius, 1e-3 * radius) << i;
  }
  EXPECT_NEAR(axis.dot(points.rightCols<1>().col(0)), 0.3 * tau / std::hypot(kappa, tau), 1e-4);
}

TEST(Simulate, MeetsTheTimesAskedForInEqualSteps) {
  Scene scene = OneRod();
  scene.rods[0].tip_force = {0.001, 0, 0};
  const SimulationPlan plan = PlanScene(scene).value();
  const Simulated run = Simulate(scene, plan, {0, 0.01, 0.0123, 0.05}).value();
  ASSERT_EQ(run.curves[0].time.size(), 4);
  EXPECT_EQ(run.curves[0].time[2], 0.0123);
  EXPECT_NEAR(static_cast<double>(run.steps), 0.05 / plan.time_step, 1);
  EXPECT_FALSE(Simulate(scene, plan, {0.2, 0.1}).ok());
}

// Contact switched on by hand changes nothing where nothing touches: the plain and the fast stepper meet.
TEST(Simulate, FullPhysicsAgreesWithThePlanWhereNothingMeets) {
  Scene scene = OneRod();
  scene.rods.push_back(scene.rods[0]);
  scene.rods[1].design.start = {5, 0, 0};
  scene.rods[1].rest_curvature = {0, 2, 0};
  scene.rods[1].tip_force = {0, 1e-3, 0};
  for (const SimulationLevel level : {SimulationLevel::kPaper, SimulationLevel::kStandard}) {
    scene.level = level;
    const SimulationPlan plan = PlanScene(scene).value();
    const SimulationPlan full = PlanScene(scene, true).value();
    EXPECT_FALSE(plan.rod_contact || plan.self_contact);
    EXPECT_TRUE(full.rod_contact && full.self_contact);
    const Simulated a = Simulate(scene, plan, {0.02}).value();
    const Simulated b = Simulate(scene, full, {0.02}).value();
    for (size_t r = 0; r < 2; ++r) {
      const auto moved = a.curves[r].curves[0].points - b.curves[r].curves[0].points;
      EXPECT_LT(moved.cwiseAbs().maxCoeff(), 1e-12);
    }
  }
}

// Three rods of two lengths that coil about a bar and each other.
Scene Touching(ContactLaw law) {
  Scene scene;
  scene.contact = {law, 1e4, 0.05};
  if (law == ContactLaw::kHertzSegments) scene.contact.friction = 0.3, scene.contact.static_friction = 0.4;
  for (int k = 0; k < 3; ++k) {
    SceneRod rod;
    rod.name = std::to_string(k);
    rod.design.length = 0.4;
    rod.design.elements = k == 1 ? 30 : 40;
    rod.design.base_radius = 0.012;
    rod.design.start = {0.03 * k, 0, 0};
    rod.design.direction = -Vector3d::UnitZ();
    rod.damping = 20;
    rod.rest_curvature = {k == 1 ? 20.0 : -4, k == 1 ? -20.0 : 25, 2};
    rod.ramp_end = 0.5;
    scene.rods.push_back(rod);
  }
  SceneObject bar;
  bar.body = {{0.1, -0.2, -0.15}, {0.1, 0.2, -0.15}, 0.02};
  bar.shape = {{PrimitiveKind::kCapsule, 0.02, {0, 0, 0.2}}};
  bar.pose.translation() = Vector3d(0.1, 0, -0.15);
  bar.pose.linear() = Eigen::AngleAxisd(-0.5 * std::numbers::pi, Vector3d::UnitX()).toRotationMatrix();
  scene.objects = {bar};
  return scene;
}

TEST(Simulate, TouchingRodsInLanesDoAsInThePlainForm) {
  for (const ContactLaw law : {ContactLaw::kHertzSegments, ContactLaw::kHertzCenters}) {
    const Scene scene = Touching(law);
    SimulationPlan plan = PlanScene(scene).value();
    ASSERT_TRUE(plan.rod_contact && plan.object_contact && plan.self_contact);
    const Simulated fast = Simulate(scene, plan, {0.1, 0.3}).value();
    ASSERT_EQ(fast.diverged.has_value(), false);
    EXPECT_LT(fast.least_axis_share, 1);
    // Between centres axes can cross unseen: then nothing is claimed, nor by the plain form.
    EXPECT_EQ(fast.nothing_passed, law == ContactLaw::kHertzSegments ? std::optional(true) : std::nullopt)
        << fast.longest_move;
    plan.plain = true;
    const Simulated plain = Simulate(scene, plan, {0.1, 0.3}).value();
    EXPECT_EQ(plain.nothing_passed, std::nullopt);
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t f = 0; f < 2; ++f) {
        const double apart =
            (fast.curves[r].curves[f].points - plain.curves[r].curves[f].points).cwiseAbs().maxCoeff();
        EXPECT_LT(apart, 1e-9) << "rod " << r << " frame " << f;
      }
    }
  }
}

// A held rod that lies on a fixed bar: what the bar bears is told, in either form.
TEST(Simulate, WhatAFixedObjectBearsIsTold) {
  Scene scene;
  scene.duration = 0.05;
  scene.contact.damping = 0.5;
  SceneRod rod;
  rod.name = "beam";
  rod.design.length = 0.4;
  rod.design.elements = 20;
  rod.design.base_radius = 0.012;
  rod.design.direction = Vector3d::UnitX();
  rod.design.normal = Vector3d::UnitZ();
  rod.damping = 20;
  scene.rods = {rod};
  SceneObject bar;
  bar.shape = {{PrimitiveKind::kBox, 0, {0.02, 0.1, 0.02}}};
  bar.pose.translation() = Vector3d(0.3, 0, -0.0319);
  scene.objects = {bar};
  SimulationPlan plan = PlanScene(scene).value();
  const Vector3d fast = Simulate(scene, plan, {0.05}).value().objects.at(0).forces.at(0);
  plan.plain = true;
  const Vector3d plain = Simulate(scene, plan, {0.05}).value().objects.at(0).forces.at(0);
  EXPECT_LT(plain.z(), -0.01);
  EXPECT_LT((fast - plain).norm(), 1e-7 * plain.norm());
}

// A rod that starts inside a fixed box or another rod, by so much of its radius.
struct StartInside {
  Simulated run;
  std::vector<std::string> warnings;
};
StartInside RunInside(double share, bool box) {
  Scene scene;
  scene.duration = 0.01;
  scene.gravity.setZero();
  SceneRod rod;
  rod.name = "beam";
  rod.design.length = 0.4;
  rod.design.elements = 20;
  rod.design.base_radius = 0.012;
  rod.design.direction = Vector3d::UnitX();
  rod.design.normal = Vector3d::UnitZ();
  scene.rods = {rod};
  if (box) {
    SceneObject bar;
    bar.name = "bar";
    bar.shape = {{PrimitiveKind::kBox, 0, {0.008, 0.1, 0.02}}};
    bar.pose.translation() = Vector3d(0.29, 0, -0.02 - 0.012 * (1 - share));
    scene.objects = {bar};
  } else {
    rod.name = "other";
    rod.design.direction = Vector3d::UnitY();
    rod.design.start = Vector3d(0.21, -0.21, -0.012 * (2 - share));
    scene.rods.push_back(rod);
  }
  StartInside inside;
  SimulateHooks hooks;
  hooks.warn = [&](const std::string& sentence) { inside.warnings.push_back(sentence); };
  inside.run = Simulate(scene, PlanScene(scene).value(), {0, 0.01}, 0, hooks).value();
  return inside;
}

TEST(Simulate, WhatStartsInsideAnotherIsToldAtOnceAndTooDeepIsNotRun) {
  for (const bool box : {false, true}) {
    EXPECT_TRUE(RunInside(-0.1, box).warnings.empty()) << "apart";
    EXPECT_TRUE(RunInside(0.01, box).warnings.empty()) << "as good as touching";
    const StartInside shallow = RunInside(0.1, box);
    EXPECT_FALSE(shallow.run.diverged.has_value());
    ASSERT_EQ(shallow.warnings.size(), 1U);
    EXPECT_NE(shallow.warnings[0].find(box ? "beam, element 14" : "other, element 10"), std::string::npos)
        << shallow.warnings[0];
    EXPECT_NE(shallow.warnings[0].find(box ? " mm deep in bar" : " mm from that of beam"), std::string::npos)
        << shallow.warnings[0];
    // 1.2 mm, less what they have been pushed apart in the first step.
    EXPECT_NE(shallow.warnings[0].find(box ? "it is 1.1" : "its axis is 22.8"), std::string::npos)
        << shallow.warnings[0];
    for (const double share : {0.3, 1.5}) {
      const StartInside deep = RunInside(share, box);
      ASSERT_TRUE(deep.run.diverged.has_value()) << share;
      EXPECT_TRUE(deep.run.diverged->at_start);
      EXPECT_TRUE(deep.warnings.empty());
    }
  }
}

void ExpectSameBytes(const std::vector<CurveSeries>& a, const std::vector<CurveSeries>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t r = 0; r < a.size(); ++r) {
    const std::size_t frames = std::min(a[r].curves.size(), b[r].curves.size());
    for (std::size_t back = 1; back <= frames; ++back) {
      const FramedCurve& one = a[r].curves[a[r].curves.size() - back];
      const FramedCurve& other = b[r].curves[b[r].curves.size() - back];
      EXPECT_EQ((one.points - other.points).cwiseAbs().maxCoeff(), 0) << r << ", " << back << " from the end";
      EXPECT_EQ((one.normals - other.normals).cwiseAbs().maxCoeff(), 0) << r << ", " << back;
    }
  }
}

TEST(Simulate, WhatIsAskedForOnTheWayChangesNothing) {
  Scene scene = Touching(ContactLaw::kHertzSegments);
  scene.duration = 0.4;
  for (const SimulationLevel level : {SimulationLevel::kPaper, SimulationLevel::kStandard}) {
    scene.level = level;
    const SimulationPlan plan = PlanScene(scene).value();
    std::vector<double> many;
    for (int i = 0; i <= 97; ++i) many.push_back(0.4 * i / 97);
    const Simulated with = Simulate(scene, plan, many).value();
    const Simulated without = Simulate(scene, plan, {0.4}).value();
    EXPECT_LT(with.least_axis_share, 1) << "nothing touched";
    ExpectSameBytes(with.curves, without.curves);
  }
}

TEST(Simulate, ThreadsChangeNoByte) {
  Scene scene = Touching(ContactLaw::kHertzSegments);
  scene.duration = 0.2;
  scene.objects.clear();  // the others would start inside it
  const std::vector<SceneRod> three = scene.rods;
  while (scene.rods.size() < 21) {
    SceneRod rod = three[scene.rods.size() % 3];
    rod.design.start += Vector3d(0.09 * static_cast<double>(scene.rods.size() / 3), 0.01, 0);
    scene.rods.push_back(rod);
  }
  const SimulationPlan plan = PlanScene(scene).value();
  const Simulated one = Simulate(scene, plan, {0.1, 0.2}).value();
  ASSERT_FALSE(one.diverged) << one.diverged->Sentence();
  EXPECT_LT(one.least_axis_share, 1) << "nothing touched";
  for (const int threads : {2, 3, 16}) {
    const Simulated many = Simulate(scene, plan, {0.1, 0.2}, 0, {.threads = threads}).value();
    ExpectSameBytes(one.curves, many.curves);
  }
}

TEST(Simulate, AnInterruptedRunGoesOnToTheSameBytes) {
  Scene scene = Touching(ContactLaw::kHertzSegments);
  scene.duration = 0.4;
  scene.contact.damping = 0.05;
  SimulationPlan plan = PlanScene(scene).value();
  const std::vector<double> times{0, 0.1, 0.2, 0.3, 0.4};
  const Simulated whole = Simulate(scene, plan, times).value();
  std::vector<SimulationState> states;
  SimulateHooks hooks;
  hooks.keep = [&](const auto& make) { states.push_back(make()); };
  hooks.progress = [&](double done) { return done < 0.45; };
  const Simulated part = Simulate(scene, plan, times, 0, hooks).value();
  EXPECT_TRUE(part.stopped);
  ASSERT_FALSE(states.empty());
  for (const SimulationState* state : {&states.front(), &states.back()}) {
    const Simulated rest = Simulate(scene, plan, times, 0, {.resume_from = state}).value();
    ExpectSameBytes(whole.curves, rest.curves);
    EXPECT_EQ(rest.curves[0].time.size(), 5);
    EXPECT_EQ(rest.longest_move, whole.longest_move);
    EXPECT_EQ(rest.least_axis_share, whole.least_axis_share);
    const double blocks = rest.resumed_at / rest.time_step / static_cast<double>(kBlock);
    EXPECT_GT(rest.resumed_at, 0);
    EXPECT_NEAR(blocks, std::round(blocks), 1e-9) << "states are made between blocks";
  }
  EXPECT_EQ(whole.resumed_at, 0);
  // A state of another scene is refused.
  scene.rods.pop_back();
  EXPECT_FALSE(Simulate(scene, PlanScene(scene).value(), times, 0, {.resume_from = &states.back()}).ok());
}

TEST(Simulate, AStepTooLongDivergesAndSaysSo) {
  Scene scene = OneRod();
  scene.rods[0].rest_curvature = {0, 5, 0};
  scene.time_step = 0.01;
  const Simulated run = Simulate(scene, PlanScene(scene).value(), {0, 1, 2}).value();
  ASSERT_TRUE(run.diverged.has_value());
  EXPECT_EQ(run.diverged->rod, "a");
  EXPECT_GT(run.diverged->time, 0);
  EXPECT_LT(run.diverged->suggested_step, 0.01);
  EXPECT_NE(run.diverged->Sentence().find("element"), std::string::npos) << run.diverged->Sentence();
  EXPECT_EQ(run.curves[0].time.size(), 1) << "what was reached is kept";
}

TEST(UniformDraw, IsEvenAndDoesNotRepeat) {
  std::set<double> seen;
  double sum = 0, squares = 0;
  const int n = 20000;
  for (int i = 0; i < n; ++i) {
    const double u = UniformDraw(1, static_cast<std::uint64_t>(i / 8), static_cast<std::uint64_t>(i % 8), 0);
    EXPECT_TRUE(u >= 0 && u < 1);
    seen.insert(u);
    sum += u;
    squares += u * u;
  }
  EXPECT_EQ(seen.size(), static_cast<size_t>(n));
  EXPECT_NEAR(sum / n, 0.5, 4 / std::sqrt(12.0 * n));
  EXPECT_NEAR(squares / n, 1.0 / 3, 0.01);
  EXPECT_NE(UniformDraw(1, 2, 3, 0), UniformDraw(1, 3, 2, 0));
}

TEST(TentacleActuation, FoldsByWhatACalibrationFound) {
  SceneGripper gripper;
  gripper.rod.elements = 40;
  gripper.design.law = FoldLaw::kExact;
  gripper.design.rest_angle = 0.2;
  gripper.design.tendon_friction = 0.05;
  gripper.design.pull_scale = 0.9;
  const TentacleActuation fitted = TentacleActuation::Make(gripper, false, 5, 0, 0).value();
  const double pull = 0.2;  // an entry of the table, which ends at 0.3
  const TentacleActuation::Place place = fitted.PlaceOf(pull);
  const Eigen::Matrix3Xd at =
      ((1 - place.share) * fitted.Entry(place.entry) + place.share * fitted.Entry(place.entry + 1))
          .rightCols(39);
  const TentacleLayout layout = LayOut(gripper.design).value();
  const RisingFold fold = SolveRisingFold(FoldLaw::kExact, gripper.design, layout, 0.9 * pull).value();
  const RestCurvature exact = RestCurvatureOf(
      layout, TendonCurveOf(layout, FoldChain(layout, fold.angle), fold.angle), {.elements = 40});
  EXPECT_LT((at - exact.curvature).cwiseAbs().maxCoeff(), 1e-6 * exact.curvature.cwiseAbs().maxCoeff());
}

TEST(TentacleActuation, PullsAfterItsDelayAtItsRate) {
  SceneGripper gripper;
  gripper.rod.elements = 40;
  const TentacleActuation first = TentacleActuation::Make(gripper, false, 5, 0, 0).value();
  EXPECT_EQ(first.PullAt(0), 0);
  EXPECT_EQ(first.PullAt(100), 0.3);
  const double rate = (first.PullAt(4) - first.PullAt(3)) / 1;
  EXPECT_NEAR(rate, 0.03, 0.001875);
  // Half-way between table entries it is still the fold's own curvature.
  const double pull = 0.2005;
  const TentacleActuation::Place place = first.PlaceOf(pull);
  const Eigen::Matrix3Xd at =
      ((1 - place.share) * first.Entry(place.entry) + place.share * first.Entry(place.entry + 1))
          .rightCols(39);
  const TentacleLayout layout = LayOut(gripper.design).value();
  const Fold fold = SolveFold(gripper.design, pull).value();
  const RestCurvature exact = RestCurvatureOf(
      layout, TendonCurveOf(layout, FoldChain(layout, fold.angle), fold.angle), {.elements = 40});
  EXPECT_LT((at - exact.curvature).cwiseAbs().maxCoeff(), 1e-3 * exact.curvature.cwiseAbs().maxCoeff());
}

}  // namespace
}  // namespace tendril
