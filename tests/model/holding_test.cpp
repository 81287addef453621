// model/scene/holding.h: what is added to a scene, and what is said of frames whose course is known.
#include "model/scene/holding.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace tendril {
namespace {

using Eigen::Vector3d;

Scene Grasp(double gravity = 9.80665) {
  Scene scene;
  scene.duration = 8;
  scene.gravity = {0, 0, -gravity};
  scene.gripper.emplace();
  SceneObject ball;
  ball.kind = "sphere";
  ball.shape = {{PrimitiveKind::kSphere, 0.03}};
  ball.motion = ObjectMotion::kHanging;
  ball.mass = 0.2;
  ball.pose.translation() = Vector3d(0.01, 0, -0.3);
  scene.objects.push_back(ball);
  return scene;
}

// A run in which the object is at start + place(time), pressed on while `touched`.
Simulated Course(
    const Scene& scene, const std::function<Vector3d(double)>& place,
    const std::function<bool(double)>& touched = [](double) { return true; }) {
  Simulated run;
  run.curves.resize(1);
  run.objects.resize(1);
  const int frames = static_cast<int>(std::lround(30 * scene.duration));
  run.curves[0].time.setLinSpaced(frames + 1, 0, scene.duration);
  for (const double time : run.curves[0].time) {
    Eigen::Isometry3d pose = scene.objects[0].pose;
    pose.translation() += place(time);
    run.objects[0].poses.push_back(pose);
    run.objects[0].forces.emplace_back(0, 0, touched(time) ? 1.9 : 0);
  }
  return run;
}

// Up by the height between the lift and the watch.
Vector3d Lifted(const HoldingTimes& times, double time, double height = 0.15) {
  return {0, 0, height * std::clamp((time - times.lift) / (times.watch - times.lift), 0.0, 1.0)};
}

HoldingResult Judged(const Scene& scene, HoldingTest test, const HoldingTimes& times, const Simulated& run) {
  const Result<HoldingResult> result = JudgeHolding(scene, test, times, {}, run, 0.05);
  EXPECT_TRUE(result.ok()) << (result.ok() ? "" : result.error().message);
  return result.value();
}

TEST(AddHoldingTest, ComesBehindAllThatTheSceneDoes) {
  Scene scene = Grasp();
  const HoldingTimes times = AddHoldingTest(scene, HoldingTest::kLift).value();
  EXPECT_DOUBLE_EQ(times.lift, 8);
  EXPECT_DOUBLE_EQ(times.end, 12);
  EXPECT_DOUBLE_EQ(scene.duration, 12);
  ASSERT_EQ(scene.phases.size(), 3u);
  EXPECT_NEAR(scene.phases[1].move.z(), 0.15, 1e-15);
}

TEST(AddHoldingTest, StrikesFromFourSidesWithTheStatedImpulse) {
  Scene scene = Grasp();
  const HoldingTimes times = AddHoldingTest(scene, HoldingTest::kStrike).value();
  ASSERT_EQ(scene.pushes.size(), 60u);
  EXPECT_DOUBLE_EQ(times.end - times.test, 60);
  Vector3d sum = Vector3d::Zero();
  for (const Push& push : scene.pushes) {
    Vector3d impulse = Vector3d::Zero();
    constexpr int kParts = 1000;
    const double part = (push.until - push.from) / kParts;
    for (int k = 0; k < kParts; ++k) impulse += part * ForceAt(push, push.from + (k + 0.5) * part);
    EXPECT_NEAR(impulse.norm(), 0.02, 1e-7);
    EXPECT_EQ(impulse.z(), 0);
    sum += impulse;
  }
  EXPECT_LT(sum.norm(), 1e-12);
}

TEST(AddHoldingTest, RefusesWhatCannotBeLifted) {
  Scene scene = Grasp();
  scene.objects[0].motion = ObjectMotion::kFixed;
  EXPECT_FALSE(AddHoldingTest(scene, HoldingTest::kLift).ok());
  scene.objects.clear();
  EXPECT_FALSE(AddHoldingTest(scene, HoldingTest::kLift).ok());
  scene = Grasp();
  scene.gripper.reset();
  EXPECT_FALSE(AddHoldingTest(scene, HoldingTest::kLift).ok());
}

TEST(JudgeHolding, LiftedIsWhatStaysAboveItsStart) {
  Scene scene = Grasp();
  const HoldingTimes times = AddHoldingTest(scene, HoldingTest::kLift).value();
  const auto lift = [&](const std::function<Vector3d(double)>& place) {
    return Judged(scene, HoldingTest::kLift, times, Course(scene, place));
  };
  const HoldingResult lifted = lift([&](double t) { return Lifted(times, t); });
  EXPECT_TRUE(lifted.held);
  EXPECT_NEAR(lifted.rise, 0.15, 1e-12);
  // Pushed aside, it rises on its string; left behind there, trembling; lifted, and slipping all the while.
  EXPECT_FALSE(Judged(scene, HoldingTest::kLift, times,
                      Course(
                          scene, [](double) { return Vector3d(0.2, 0, 0.02); }, [](double) { return false; }))
                   .held);
  EXPECT_FALSE(lift([](double t) { return Vector3d(0, 0, 1e-4 * std::sin(t)); }).held);
  EXPECT_FALSE(lift([&](double t) {
                 return Vector3d(Lifted(times, t) - Vector3d(0, 0, 0.05 * std::max(0.0, t - times.watch)));
               }).held);
}

TEST(JudgeHolding, WithoutWeightItHasToComeAlong) {
  Scene scene = Grasp(0);
  const HoldingTimes times = AddHoldingTest(scene, HoldingTest::kLift).value();
  const auto with = [&](double height) {
    return Judged(scene, HoldingTest::kLift, times,
                  Course(scene, [&, height](double t) { return Lifted(times, t, height); }))
        .held;
  };
  EXPECT_TRUE(with(0.14));
  EXPECT_FALSE(with(0.05));
}

TEST(JudgeHolding, PayloadIsTheLoadAtWhichItSlips) {
  Scene scene = Grasp();
  const HoldingTimes times = AddHoldingTest(scene, HoldingTest::kLoad).value();
  const double slips = times.test + 7;  // at 0.1 kg/s
  const HoldingResult result =
      Judged(scene, HoldingTest::kLoad, times, Course(scene, [&](double t) {
               return Vector3d(Lifted(times, t) - Vector3d(0, 0, t > slips ? 0.14 : 0));
             }));
  EXPECT_NEAR(result.payload, 0.9, 0.005);
  EXPECT_NEAR(result.payload_ratio, 18, 0.1);
  EXPECT_FALSE(result.payload_is_least);
  const HoldingResult never =
      Judged(scene, HoldingTest::kLoad, times, Course(scene, [&](double t) { return Lifted(times, t); }));
  EXPECT_TRUE(never.payload_is_least);
  EXPECT_NEAR(never.payload, 2.2, 1e-12);
  const HoldingResult left =
      Judged(scene, HoldingTest::kLoad, times, Course(scene, [](double) { return Vector3d(0, 0, 0); }));
  EXPECT_TRUE(std::isnan(left.payload));
  EXPECT_FALSE(left.held);
}

TEST(JudgeHolding, CountsStrikesUntilItIsLost) {
  Scene scene = Grasp();
  const HoldingTimes times = AddHoldingTest(scene, HoldingTest::kStrike).value();
  const auto lost_after = [&](double seconds) {
    return Judged(scene, HoldingTest::kStrike, times, Course(scene, [&, seconds](double t) {
                    const double sunk = t > times.test + seconds ? 0.14 : 0;
                    return Vector3d(Lifted(times, t) - Vector3d(0.004 * std::sin(t - times.test), 0, sunk));
                  }));
  };
  EXPECT_EQ(lost_after(20.5).strikes, 20);
  EXPECT_FALSE(lost_after(20.5).held);
  const HoldingResult held = lost_after(100);
  EXPECT_EQ(held.strikes, 60);
  EXPECT_TRUE(held.held);
  EXPECT_NEAR(held.shift, 0.004, 1e-4);
}

TEST(JudgeHolding, TimesTheRelease) {
  Scene scene = Grasp();
  const HoldingTimes times = AddHoldingTest(scene, HoldingTest::kRelease).value();
  const auto lift = [&](double t) { return Lifted(times, t); };
  const HoldingResult free = Judged(scene, HoldingTest::kRelease, times,
                                    Course(scene, lift, [&](double t) { return t < times.test + 1.5; }));
  EXPECT_TRUE(free.held);
  EXPECT_NEAR(free.release_time, 1.5, 0.04);
  const HoldingResult caught = Judged(scene, HoldingTest::kRelease, times, Course(scene, lift));
  EXPECT_FALSE(caught.held);
  EXPECT_TRUE(std::isnan(caught.release_time));
}

TEST(JudgeHolding, ARunThatEndedBeforeIsNotJudged) {
  Scene scene = Grasp();
  const HoldingTimes times = AddHoldingTest(scene, HoldingTest::kLift).value();
  Scene shorter = scene;
  shorter.duration = 11;
  const Simulated run = Course(shorter, [&](double t) { return Lifted(times, t); });
  EXPECT_FALSE(JudgeHolding(scene, HoldingTest::kLift, times, {}, run, 0.05).ok());
}

}  // namespace
}  // namespace tendril
