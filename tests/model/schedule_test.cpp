// model/scene/schedule.h: smooth ways between phases, velocities as the positions' derivatives, pulls that
// get where they are told.
#include "model/scene/schedule.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "model/geometry/rotation.h"
#include "model/scene/actuation.h"
#include "model/scene/simulate.h"

namespace tendril {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

std::vector<Phase> Busy() {
  std::vector<Phase> phases(5);
  phases[0].duration = 0.7;
  phases[1].duration = 1.3;
  phases[1].move = {0.1, -0.2, 0.3};
  phases[1].shake_amplitude = {0, 0.02, 0.01};
  phases[1].shake_frequency = 3.7;  // no whole number of cycles
  phases[2].duration = 0.9;
  phases[2].turn = 2.2;
  phases[2].turn_axis = {1, 2, -0.5};
  phases[2].move = {-0.4, 0, 0.1};
  phases[3].duration = 0.2;
  phases[3].shake_amplitude = {0.05, 0, 0};
  phases[3].shake_frequency = 2;  // shorter than a period
  phases[4].duration = 1.1;
  phases[4].turn = -1;
  return phases;
}

TEST(SmoothShare, StartsAndEndsWithoutSpeedOrAcceleration) {
  EXPECT_EQ(SmoothShare(-1), 0);
  EXPECT_EQ(SmoothShare(0), 0);
  EXPECT_EQ(SmoothShare(0.5), 0.5);
  EXPECT_EQ(SmoothShare(1), 1);
  EXPECT_EQ(SmoothShare(2), 1);
  // As s^3: neither a square nor anything below.
  EXPECT_NEAR(SmoothShare(1e-4) / 1e-12, 10, 2e-3);
  EXPECT_NEAR((1 - SmoothShare(1 - 1e-3)) / 1e-9, 10, 2e-2);
}

TEST(Schedule, VelocityAndSpinAreTheDerivativesOfPlaceAndTurn) {
  const Schedule schedule(Busy());
  const double h = 1e-5;
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> times(0.01, schedule.duration() - 0.01);
  for (int i = 0; i < 2000; ++i) {
    const double time = times(random);
    const CarrierMotion now = schedule.At(time), before = schedule.At(time - h),
                        after = schedule.At(time + h);
    EXPECT_LT((now.velocity - (after.offset - before.offset) / (2 * h)).norm(), 1e-5) << time;
    const Vector3d spin = LogSo3(Matrix3d(after.turned * before.turned.transpose())) / (2 * h);
    EXPECT_LT((now.spin - spin).norm(), 1e-5) << time;
    EXPECT_LE(now.velocity.norm(), schedule.Fastest());
    EXPECT_LE(now.spin.norm(), schedule.FastestSpin());
    EXPECT_LT((now.turned * now.turned.transpose() - Matrix3d::Identity()).norm(), 1e-13);
  }
}

TEST(Schedule, PlaceVelocityAndAccelerationHaveNoJumpsBetweenPhases) {
  const Schedule schedule(Busy());
  double at = 0;
  for (std::size_t k = 0; k <= 5; ++k) {
    if (k > 0) at += schedule.phases()[k - 1].duration;
    // Within h of a phase's end velocity grows as h^2 and the way as h^3; an acceleration that jumped would
    // give h and h^2.
    for (const double h : {1e-3, 1e-4}) {
      const CarrierMotion before = schedule.At(at - h), here = schedule.At(at), after = schedule.At(at + h);
      EXPECT_LT((after.offset - before.offset).norm(), 2e3 * h * h * h) << k;
      EXPECT_LT(before.velocity.norm() + after.velocity.norm(), 3e3 * h * h) << k;
      EXPECT_LT(before.spin.norm() + after.spin.norm(), 3e2 * h * h) << k;
      EXPECT_EQ(here.velocity.norm(), 0) << k;
    }
  }
}

TEST(Schedule, EndsWhereTheWaysLeadAndShakesEndWhereTheyBegan) {
  const Schedule schedule(Busy());
  EXPECT_DOUBLE_EQ(schedule.duration(), 4.2);
  const CarrierMotion end = schedule.At(1e9);
  EXPECT_LT((end.offset - Vector3d(-0.3, -0.2, 0.4)).norm(), 1e-15);
  const Matrix3d turned = ExpSo3(Vector3d(0, 0, -1)) * ExpSo3(2.2 * Vector3d(1, 2, -0.5).normalized());
  EXPECT_LT((end.turned - turned).norm(), 1e-14);
  EXPECT_EQ(end.velocity.norm(), 0);
  EXPECT_EQ(schedule.At(-1).offset, Vector3d::Zero());
  EXPECT_EQ(schedule.At(HUGE_VAL).offset, end.offset);
  EXPECT_EQ(schedule.PhaseAt(0.7), 1U);
  EXPECT_EQ(schedule.PhaseAt(0.699), 0U);
  EXPECT_EQ(schedule.PhaseAt(99), 4U);
}

TEST(Schedule, AShakeReachesItsAmplitudeAndFrequency) {
  Phase phase;
  phase.duration = 4;
  phase.shake_amplitude = {0, 0.03, 0};
  phase.shake_frequency = 5;
  const Schedule schedule({phase});
  int crossings = 0;
  double most = 0;
  for (int i = 1; i <= 4000; ++i) {
    const double now = schedule.At(i * 1e-3).offset.y(), before = schedule.At((i - 1) * 1e-3).offset.y();
    crossings += now > 0 && before <= 0 ? 1 : 0;
    most = std::max(most, now);
  }
  EXPECT_NEAR(most, 0.03, 1e-6);
  EXPECT_EQ(crossings, 20);
}

SceneGripper Gripping() {
  SceneGripper gripper;
  gripper.pull = 0.3;
  gripper.pull_rate = 0.1;
  return gripper;
}

TEST(PullSchedule, WithoutPhasesIsARampWithADelay) {
  const PullSchedule pulls(Gripping(), {}, 0.4, 0.11);
  for (const double time : {0.0, 0.3, 0.4, 1.0, 2.0, 3.12, 3.13, 10.0}) {
    EXPECT_EQ(pulls.At(time), std::clamp(0.11 * (time - 0.4), 0.0, 0.3)) << time;
  }
  EXPECT_EQ(pulls.RateAt(0.2), 0);
  EXPECT_EQ(pulls.RateAt(1), 0.11);
  EXPECT_EQ(pulls.RateAt(9), 0);
}

TEST(PullSchedule, GoesToEachTargetAndStays) {
  std::vector<Phase> phases(6);
  phases[1].pull = 0.2;        // from 1 s
  phases[2].move = {0, 0, 1};  // goes on
  phases[3].pull = 0;          // released from 3 s
  phases[4].pull = 0.3, phases[4].pull_rate = 10;
  phases[4].duration = 5;
  phases[3].duration = 5;
  const PullSchedule pulls(Gripping(), phases, 0.5, 0.11);
  EXPECT_EQ(pulls.At(1.5), 0);
  EXPECT_NEAR(pulls.At(2.5), 0.11, 1e-15);  // in the phase after
  EXPECT_NEAR(pulls.At(3), 0.165, 1e-15);   // let go before it got there
  EXPECT_NEAR(pulls.At(4), 0.055, 1e-15);   // and at once: the delay is the first motion's alone
  EXPECT_NEAR(pulls.RateAt(4), -0.11, 1e-15);
  EXPECT_NEAR(pulls.At(7), 0, 1e-15);
  EXPECT_NEAR(pulls.RateAt(8.001), 11, 1e-13);  // 10 a second in the share of its own to the gripper's
  EXPECT_NEAR(pulls.At(8.1), 0.3, 1e-15);
  EXPECT_NEAR(pulls.At(HUGE_VAL), 0.3, 1e-15);
  for (int i = 1; i < 14000; ++i) {
    const double h = 1e-3, step = pulls.At(i * h) - pulls.At((i - 1) * h);
    EXPECT_LE(std::abs(step), 11 * h * (1 + 1e-9)) << i;
  }
}

TEST(PullSchedule, WithoutANamedPullTheGrippersIsTheFirst) {
  std::vector<Phase> phases(2);
  phases[1].move = {0, 0, 1};
  const PullSchedule pulls(Gripping(), phases, 0, 0.1);
  EXPECT_EQ(pulls.At(2), 0.2);
  EXPECT_EQ(StrongestPull(Gripping(), phases), 0.3);
  phases[0].pull = 0.1;
  phases[1].pull = 0.0;
  EXPECT_EQ(StrongestPull(Gripping(), phases), 0.1);
}

TEST(AddPhase, KeepsWhatCameBeforeToTheBit) {
  Scene scene;
  scene.duration = 4;
  scene.gripper = Gripping();
  scene.gripper->design.holes = 13;
  scene.gripper->gripper.tentacles = 2;
  scene.gripper->rod.elements = 12;
  const Scene before = scene;
  Phase lift;
  lift.name = "lift";
  lift.duration = 2;
  lift.move = {0, 0, 0.15};
  AddPhase(scene, lift);
  Phase release;
  release.pull = 0;
  AddPhase(scene, release);
  EXPECT_EQ(scene.duration, 7);
  ASSERT_EQ(scene.phases.size(), 3U);
  const auto rods = MakeRods(before, 1).value(), longer = MakeRods(scene, 1).value();
  for (const double time : {0.0, 0.4, 1.7, 3.9}) {
    for (std::size_t r = 0; r < rods.size(); ++r) {
      const auto at = [&](const Scene& s, const std::vector<Driven>& all) {
        return DriveAt(s, all[r], CarrierGrowthAt(s, all, time), time);
      };
      const DriveState a = at(before, rods), b = at(scene, longer);
      EXPECT_EQ(a.place.entry, b.place.entry);
      EXPECT_EQ(a.place.share, b.place.share);
      EXPECT_EQ(a.base_position, b.base_position);
      EXPECT_EQ(a.base_velocity, b.base_velocity);
    }
  }
  // Grown and shrunk again.
  EXPECT_NEAR(LargestCarrierGrowth(scene), CarrierGrowthAt(scene, longer, 6).by, 1e-15);
  EXPECT_LT(CarrierGrowthAt(scene, longer, 6.9).by, 0.9 * LargestCarrierGrowth(scene));
  const double end = 6;  // lifted, and the tendons drawn in
  const DriveState lifted = DriveAt(scene, longer[0], CarrierGrowthAt(scene, longer, end), end);
  EXPECT_NEAR(lifted.base_position.z(), longer[0].base_start.z() + 0.15, 1e-15);
}

// The drives' positions and velocities agree for whatever moves at once.
TEST(DriveAt, VelocitiesAreTheDerivativesOfPositionsOnACarrierThatMoves) {
  Scene scene;
  scene.gripper = Gripping();
  scene.gripper->design.holes = 13;
  scene.gripper->gripper.tentacles = 2;
  scene.gripper->rod.elements = 12;
  SceneRod rod;
  rod.design.tip = EndHold::kFrame;
  rod.tip_motion = {.velocity = {0, 0.1, 0}, .spin = {1, 0, 0}, .from = 0, .until = 5};
  scene.rods.push_back(rod);
  scene.phases = Busy();
  scene.phases[0].pull = 0.3;
  scene.duration = 4.2;
  const auto rods = MakeRods(scene, 0).value();
  const double h = 1e-5;
  for (int k = 0; k < 20; ++k) {
    const double time = 0.73 + 0.171 * k;
    for (const Driven& d : rods) {
      const auto at = [&](double t) { return DriveAt(scene, d, CarrierGrowthAt(scene, rods, t), t); };
      const DriveState now = at(time), before = at(time - h), after = at(time + h);
      EXPECT_LT((now.base_velocity - (after.base_position - before.base_position) / (2 * h)).norm(), 1e-5);
      EXPECT_LT((now.tip_velocity - (after.tip_position - before.tip_position) / (2 * h)).norm(), 1e-5);
      // The frame turns with the carrier: rows are directors, so from the right.
      const Matrix3d turned = d.carrier->At(time).turned;
      EXPECT_LT((now.base_frame * turned - d.base_frame).norm(), 1e-13);
    }
  }
}

TEST(Simulate, ALiftedRodHangsAsBeforeWhereItWasLiftedTo) {
  Scene scene;
  SceneRod rod;
  rod.design.direction = {0, 0, -1};
  rod.design.length = 0.3;
  rod.design.base_radius = 0.012;
  rod.design.youngs_modulus = 1e6;
  rod.design.shear_modulus = 4e5;
  rod.design.elements = 20;
  rod.damping = 20;
  scene.rods = {rod};
  scene.duration = 0.5;
  Phase carry;
  carry.duration = 1;
  carry.move = {0.1, 0, 0.2};
  AddPhase(scene, carry);
  Phase wait;
  wait.duration = 1.5;
  AddPhase(scene, wait);
  const SimulationPlan plan = PlanScene(scene).value();
  const Simulated run = Simulate(scene, plan, {0.5, 3}).value();
  ASSERT_FALSE(run.diverged.has_value());
  const Eigen::Matrix3Xd before = run.curves[0].curves[0].points, after = run.curves[0].curves[1].points;
  EXPECT_LT(((after.colwise() - Vector3d(0.1, 0, 0.2)) - before).colwise().norm().maxCoeff(), 2e-4);
}

}  // namespace
}  // namespace tendril
