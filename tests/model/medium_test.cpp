// model/rods/medium.h: falling and drifting rods against closed forms, energy, and both steppers.
#include "model/rods/medium.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "model/machine.h"
#include "model/rods/rod_lanes.h"

namespace tendril {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

const Medium kWater = {.density = 1000};
constexpr double kRadius = 0.01;

// Free, straight, without taper, soft enough for long steps.
Rod FreeRod(const Vector3d& direction, double density) {
  RodDesign design;
  design.direction = direction;
  design.normal = Vector3d(0.36, 0.48, 0.8);
  design.length = 0.4;
  design.base_radius = kRadius;
  design.density = density;
  design.elements = 8;
  design.base = EndHold::kFree;
  return MakeRod(design).value();
}

PlainOptions InMedium(const Medium& medium, double time_step, double gravity = 9.81) {
  return {.time_step = time_step, .gravity = {0, 0, -gravity}, .medium = &medium};
}

// With the medium's.
double KineticEnergy(const Rod& rod, const Medium& medium, const Wetted& wetted) {
  const WettedNodes nodes = WettedNodesOf(rod, medium, wetted);
  double energy = 0;
  const Eigen::Index last = rod.elements();
  for (Eigen::Index i = 0; i <= last; ++i) {
    const Vector3d tangent =
        (rod.position.col(std::min(i + 1, last)) - rod.position.col(std::max<Eigen::Index>(i - 1, 0)))
            .normalized();
    const double along = tangent.dot(rod.velocity.col(i));
    const double across2 = rod.velocity.col(i).squaredNorm() - along * along;
    energy += 0.5 * (rod.mass[i] * along * along + across2 / nodes.inverse_across[i]);
  }
  return energy;
}

TEST(Medium, AFallBeginsWithTheAddedMassAcrossAndWithoutAlong) {
  std::vector<Rod> rods = {FreeRod(Vector3d::UnitX(), 1500), FreeRod(Vector3d::UnitZ(), 1500)};
  const double step = 1e-3;
  StepPlain(rods, 0, InMedium(kWater, step));
  for (Eigen::Index i = 0; i < 9; ++i) {
    EXPECT_NEAR(rods[0].velocity(2, i) / step, -(1500.0 - 1000) / (1500 + 1000) * 9.81, 1e-10);
    EXPECT_NEAR(rods[1].velocity(2, i) / step, -(1500.0 - 1000) / 1500 * 9.81, 1e-10);
  }
}

// rho_s pi r^2 l g is carried by rho/2 C_n 2 r l v^2, or by rho/2 C_t 2 pi r l v^2.
TEST(Medium, RodsSinkAsFastAsTheirClosedFormsSay) {
  std::vector<Rod> rods = {FreeRod(Vector3d::UnitX(), 1200), FreeRod(Vector3d::UnitZ(), 1200)};
  for (int k = 0; k < 10000; ++k) StepPlain(rods, 0, InMedium(kWater, 1e-3));
  const double pressed = 200 * 9.81 * kRadius / 1000;
  EXPECT_NEAR(-rods[0].velocity.row(2).mean() / std::sqrt(pressed * pi / 1.1), 1, 1e-9);
  EXPECT_NEAR(-rods[1].velocity.row(2).mean() / std::sqrt(pressed / 0.017), 1, 1e-9);
}

// From rest v = v_T tanh(a t / v_T).
TEST(Medium, AFallFollowsItsClosedFormToSecondOrder) {
  const double a = 200.0 / 2200 * 9.81, terminal = std::sqrt(2.0 * 9.81 * kRadius / 10 * pi / 1.1);
  const auto error = [&](int steps) {
    std::vector<Rod> rods = {FreeRod(Vector3d::UnitX(), 1200)};
    for (int k = 0; k < steps; ++k) StepPlain(rods, 0, InMedium(kWater, 0.2 / steps));
    return std::abs(-rods[0].velocity(2, 4) - terminal * std::tanh(a * 0.2 / terminal));
  };
  EXPECT_LT(error(200), 1e-3 * terminal);
  EXPECT_NEAR(error(200) / error(400), 4, 0.1);
}

TEST(Medium, ANeutrallyBuoyantRodHangsStill) {
  // A ribbon of a twentieth of the rod's volume, 20 times as dense as the rod that stands for it.
  std::vector<Rod> rods = {FreeRod(Vector3d(1, 2, 3), 50)};
  PlainOptions options = InMedium(kWater, 2e-4);
  options.wetted = {.drag_diameter_scale = 0.5, .displaced = 0.05};
  for (int k = 0; k < 1000; ++k) StepPlain(rods, 0, options);
  EXPECT_LT(rods[0].velocity.cwiseAbs().maxCoeff(), 1e-12);  // of 2 m/s
}

// Small motions across a rod are slower by the root of what moves with it.
TEST(Medium, AddedMassLowersACantileversFrequency) {
  const auto period = [](const Medium& medium) {
    RodDesign design;
    design.length = 0.4;
    design.base_radius = kRadius;
    design.density = 1200;
    design.elements = 20;
    design.base = EndHold::kFrame;
    design.start_curvature = {0.01, 0, 0};
    std::vector<Rod> rods = {MakeRod(design).value()};
    auto lanes = LaneRods<double>::Make(rods, RodForm::kEnergy).value();
    lanes.SetMedium(medium, rods, std::vector<Wetted>(1));
    // Between the tip's passages of the straight line, in the same direction.
    const size_t tip = (3 * 20 + 1) * kRodLanes;
    double before = 0, first = 0, last = 0;
    int passages = 0;
    for (int k = 0; passages < 6; ++k) {
      lanes.Advance(10, 0, {.time_step = 2e-4});
      const double now = lanes.positions()[tip];
      if (k > 0 && before < 0 && now >= 0) {
        (passages++ == 0 ? first : last) = 2e-3 * (k - now / (now - before));
      }
      before = now;
      if (k > 100000) return 0.0;
    }
    return (last - first) / 5;
  };
  const Medium ideal = {.density = 1000, .cross_drag = 0, .along_drag = 0};
  const double still = period({}), slower = period(ideal);
  // Euler and Bernoulli's first frequency.
  const double exact = 2 * pi / (3.516015 * std::sqrt(1e5 * kRadius * kRadius / 4 / 1200) / (0.4 * 0.4));
  EXPECT_NEAR(still / exact, 1, 0.01);
  EXPECT_NEAR(slower / still, std::sqrt((1200.0 + 1000) / 1200), 0.01 * slower / still);
}

// A rod across the flow: against it u = U / (1 + k U t).
TEST(Medium, AFlowCarriesAFreeRodUpToItsSpeed) {
  Medium flowing = kWater;
  flowing.flow = {0, 0.3, 0};
  std::vector<Rod> rods = {FreeRod(Vector3d::UnitX(), 1200), FreeRod(Vector3d(1, 1, 1), 1200)};
  double before = 0;
  for (int k = 0; k < 12000; ++k) {
    StepPlain(rods, 0, InMedium(flowing, 1e-3, 0));
    const double speed = rods[1].velocity.row(1).mean();
    ASSERT_TRUE(speed >= before && speed <= 0.3) << speed << " after " << before;
    before = speed;
  }
  const double k = 0.5 * 1000 * 1.1 * 2 * kRadius / (pi * kRadius * kRadius * 2200);
  EXPECT_NEAR(rods[0].velocity(1, 4), 0.3 - 0.3 / (1 + k * 0.3 * 12), 1e-9);
  EXPECT_GT(before, 0.26);
}

// A thousand times as long as it takes drag to stop the rod.
TEST(Medium, DragStopsARodAndNeverTurnsItRound) {
  for (const Vector3d& direction : {Vector3d(1, 0, 0), Vector3d(0, 0, 1), Vector3d(1, 0, 1)}) {
    const Medium ideal = {.density = 1000, .added_mass = 0};
    std::vector<Rod> rods = {FreeRod(direction, 1)};
    rods[0].velocity.row(2).setConstant(10);
    const double rate = 0.5 * 1000 * 0.017 * pi * 2 * kRadius / (pi * kRadius * kRadius) * 10;
    const double step = 1000 / rate;
    double speed = 10;
    // Only the kick: the rod's own waves would not bear such a step.
    for (int k = 0; k < 100; ++k) {
      KickPlain(rods[0], InMedium(ideal, step, 0), Eigen::Matrix3Xd::Zero(3, 9));
      const double now = rods[0].velocity.col(4).dot(Vector3d::UnitZ());
      EXPECT_GE(now, 0);
      EXPECT_LT(now, speed);
      speed = now;
      if (k == 0) {
        EXPECT_LT(now, 10);
      }
    }
    EXPECT_TRUE(rods[0].velocity.allFinite());
  }
}

// Rods in every shape and motion.
Rod WildRod(std::mt19937& random, int elements, EndHold base) {
  std::uniform_real_distribution<double> even(0, 1);
  std::normal_distribution<double> normal;
  RodDesign design;
  design.elements = elements;
  design.length = 0.4 + 0.4 * even(random);
  design.base_radius = 0.01 + 0.01 * even(random);
  design.taper = 0.5 + 0.5 * even(random);
  design.density = 500 + 1000 * even(random);
  design.direction = Vector3d(even(random), even(random), -1);
  design.base = base;
  design.start_curvature = {3 * normal(random), 3 * normal(random), 2 * normal(random)};
  Rod rod = MakeRod(design).value();
  for (auto kappa : rod.rest_curvature.colwise()) kappa << 3 * even(random), -4 * even(random), 1;
  rod.base.rest_curvature = rod.rest_curvature.col(0);
  for (auto v : rod.velocity.colwise()) {
    v = 0.3 * Vector3d(normal(random), normal(random), normal(random));
  }
  for (auto w : rod.spin.colwise()) w = 3 * Vector3d(normal(random), normal(random), normal(random));
  if (base != EndHold::kFree) rod.velocity.col(0).setZero();
  if (base == EndHold::kElement) rod.spin.col(0).setZero();
  return rod;
}

TEST(Medium, DragOnlyEverTakesEnergyFromAKick) {
  std::mt19937 random(5);
  for (int trial = 0; trial < 300; ++trial) {
    Rod dragged = WildRod(random, 12, EndHold::kFree), ideal = dragged;
    const Medium without = {.density = 1000, .cross_drag = 0, .along_drag = 0};
    const double step = std::pow(10, -6 + trial % 8);
    const Eigen::Matrix3Xd none = Eigen::Matrix3Xd::Zero(3, 13);
    KickPlain(dragged, InMedium(kWater, step, 0), none);
    KickPlain(ideal, InMedium(without, step, 0), none);
    ASSERT_LT(KineticEnergy(dragged, kWater, {}), KineticEnergy(ideal, kWater, {})) << "trial " << trial;
  }
}

TEST(Medium, AStillMediumGivesARodNoEnergy) {
  std::mt19937 random(6);
  for (const double added : {0.0, 1.0}) {
    Medium still = kWater;
    still.added_mass = added;
    for (int trial = 0; trial < 4; ++trial) {
      std::vector<Rod> rods = {WildRod(random, 12, EndHold::kFree)};
      const auto energy = [&] {
        const RodEnergy e = EnergyOf(rods[0]);
        return e.rotation + e.bend + e.shear + KineticEnergy(rods[0], still, {});
      };
      const double start = energy();
      double before = start;
      for (int part = 0; part < 20; ++part) {
        for (int k = 0; k < 100; ++k) StepPlain(rods, 0, InMedium(still, 5e-5, 0));
        const double now = energy();
        // The scheme's own swing is of the second order in the step.
        EXPECT_LT(now, before + 1e-4 * start) << "added mass " << added << ", trial " << trial;
        before = now;
      }
      EXPECT_LT(before, 0.9 * start);
    }
  }
}

// A known limit (docs/media.md): without the added mass's gradient only drag keeps the energy from growing.
TEST(Medium, WithoutDragACoilingRodGainsEnergyAndWithDragItLosesIt) {
  const auto share = [](const Medium& medium) {
    RodDesign design;
    design.elements = 30;
    design.length = 0.6;
    design.base_radius = kRadius;
    design.density = 1000;
    design.base = EndHold::kFree;
    std::vector<Rod> rods = {MakeRod(design).value()};
    for (auto kappa : rods[0].rest_curvature.colwise()) kappa << 6, 3, 1;
    for (auto v : rods[0].velocity.colwise()) v << 0, 0.2, 0.5;
    const auto energy = [&] {
      const RodEnergy e = EnergyOf(rods[0]);
      return e.rotation + e.bend + e.shear + KineticEnergy(rods[0], medium, {});
    };
    const double start = energy();
    auto lanes = LaneRods<double>::Make(rods, RodForm::kEnergy).value();
    lanes.SetMedium(medium, rods, std::vector<Wetted>(1));
    EXPECT_EQ(lanes.Advance(20000, 0, {.time_step = 1e-4}), 20000);
    lanes.Store(rods);
    return energy() / start;
  };
  EXPECT_NEAR(share({.density = 1000, .cross_drag = 0, .along_drag = 0}), 1.59, 0.02);
  EXPECT_NEAR(share({.density = 1000, .cross_drag = 0, .along_drag = 0, .added_mass = 0}), 1, 1e-3);
  EXPECT_LT(share(kWater), 0.1);
}

TEST(Medium, OneOfNoDensityIsVacuumToTheByte) {
  std::mt19937 random(7);
  const std::vector<Rod> rods = {WildRod(random, 12, EndHold::kFrame), WildRod(random, 12, EndHold::kFree)};
  const Medium vacuum = {.density = 0, .flow = {1, 2, 3}};
  auto with = LaneRods<double>::Make(rods, RodForm::kEnergy).value(), without = with;
  with.SetMedium(kWater, rods, std::vector<Wetted>(2));
  with.SetMedium(vacuum, rods, std::vector<Wetted>(2));
  PlainOptions options = {.time_step = 2e-5, .gravity = {0, 0, -9.81}};
  with.Advance(200, 0, options);
  without.Advance(200, 0, options);
  EXPECT_TRUE(std::ranges::equal(with.memory(), without.memory()));
  std::vector<Rod> plain = rods, in_vacuum = rods;
  for (int k = 0; k < 20; ++k) {
    StepPlain(plain, 0, options);
    StepPlain(in_vacuum, 0, InMedium(vacuum, 2e-5));
  }
  EXPECT_EQ(plain[0].position, in_vacuum[0].position);
}

class MediumLanes : public testing::TestWithParam<std::tuple<int, RodForm>> {
 protected:
  void SetUp() override {
    if (std::get<0>(GetParam()) > MachineDoubles()) GTEST_SKIP() << "this machine has no such registers";
    UseRodKernel(std::get<0>(GetParam()));
  }
  void TearDown() override { UseRodKernel(0); }
};

TEST_P(MediumLanes, StepAsThePlainStepperDoes) {
  const RodForm form = std::get<1>(GetParam());
  std::mt19937 random(8);
  const Medium flowing = {.density = 1000, .flow = {0.2, -0.1, 0.05}};
  const EndHold held = form == RodForm::kEnergy ? EndHold::kFrame : EndHold::kElement;
  std::vector<Rod> plain;
  std::vector<Wetted> wetted;
  for (int r = 0; r < 8; ++r) {
    plain.push_back(WildRod(random, 16, r % 2 == 0 ? held : EndHold::kFree));
    wetted.push_back({.drag_diameter_scale = 1 - 0.1 * r, .displaced = 0.1 * r});
  }
  std::vector<Rod> lanes = plain, single = plain, dry = plain;
  const PlainOptions options = {.form = form, .time_step = 2e-5, .damping = 0.5, .gravity = {0.5, 0, -9.8}};
  auto batch = LaneRods<double>::Make(plain, form).value();
  auto rough = LaneRods<float>::Make(plain, form).value();
  auto vacuum = batch;
  batch.SetMedium(flowing, plain, wetted);
  rough.SetMedium(flowing, plain, wetted);
  for (size_t r = 0; r < 8; ++r) {
    PlainOptions wet = options;
    wet.medium = &flowing;
    wet.wetted = wetted[r];
    for (int step = 0; step < 1000; ++step) StepPlain({&plain[r], 1}, 0, wet);
  }
  EXPECT_EQ(batch.Advance(1000, 0, options), 1000);
  EXPECT_EQ(rough.Advance(1000, 0, options), 1000);
  EXPECT_EQ(vacuum.Advance(1000, 0, options), 1000);
  batch.Store(lanes);
  rough.Store(single);
  vacuum.Store(dry);
  for (size_t r = 0; r < 8; ++r) {
    const auto apart = [&](const std::vector<Rod>& other) {
      return (other[r].position - plain[r].position).colwise().norm().maxCoeff();
    };
    EXPECT_LT(apart(lanes), 1e-12) << "rod " << r;
    EXPECT_LT(apart(single), 1e-3) << "rod " << r;
    EXPECT_GT(apart(dry), 1e-3) << "rod " << r << " did not feel the medium";
  }
}

INSTANTIATE_TEST_SUITE_P(Kernels, MediumLanes,
                         testing::Combine(testing::Values(2, 4, 8),
                                          testing::Values(RodForm::kPaper, RodForm::kEnergy)));

TEST(CheckMedium, NamesWhatIsWrong) {
  EXPECT_TRUE(CheckMedium(Water()).ok());
  EXPECT_TRUE(CheckMedium(Air()).ok());
  EXPECT_TRUE(CheckWetted({}).ok());
  EXPECT_NE(CheckMedium({.density = -1}).error().message.find("density is -1"), std::string::npos);
  EXPECT_FALSE(CheckMedium({.density = NAN}).ok());
  EXPECT_FALSE(CheckMedium({.density = 1, .flow = {0, NAN, 0}}).ok());
  EXPECT_FALSE(CheckMedium({.density = 1, .added_mass = -1}).ok());
  EXPECT_FALSE(CheckWetted({.displaced = -0.1}).ok());
  EXPECT_FALSE(CheckWetted({.drag_diameter_scale = INFINITY}).ok());
}

}  // namespace
}  // namespace tendril
