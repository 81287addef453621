// model/rods/rod_lanes.h: the plain stepper's results, on every kernel, in double and single precision.
#include "model/rods/rod_lanes.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "model/machine.h"

namespace tendril {
namespace {

using Eigen::Vector3d;

// Rods that differ in everything but their number of elements.
std::vector<Rod> Rods(std::mt19937& random, RodForm form, int count, int elements) {
  std::uniform_real_distribution<double> even(0, 1);
  std::vector<Rod> rods;
  for (int k = 0; k < count; ++k) {
    RodDesign design;
    design.elements = elements;
    design.length = 0.5 + 0.5 * even(random);
    design.base_radius = 0.01 + 0.01 * even(random);
    design.taper = 0.5 + 0.5 * even(random);
    design.direction = Vector3d(even(random), even(random), -1);
    // The energy form may hold the very ends' directors, and both ends.
    const EndHold held = form == RodForm::kEnergy && k % 2 == 0 ? EndHold::kFrame : EndHold::kElement;
    design.base = k % 3 == 2 ? EndHold::kFree : held;
    design.tip = k % 4 == 3 ? held : EndHold::kFree;
    design.start_curvature = {0.5, 0, k % 5 == 4 ? 1.0 : 0.0};
    Rod rod = MakeRod(design).value();
    for (auto kappa : rod.rest_curvature.colwise())
      kappa << 3 * even(random), -4 * even(random), 2 * even(random);
    for (auto sigma : rod.rest_strain.colwise()) sigma << 0, 0, -0.1 * even(random);
    rod.base.rest_curvature = rod.rest_curvature.col(0);
    rod.tip_couple = {0.001, -0.002, 0.0005};
    if (design.base == EndHold::kFree) {
      for (auto w : rod.spin.colwise()) w << 5, -3, 8;
    }
    rods.push_back(rod);
  }
  return rods;
}

double Farthest(const std::vector<Rod>& a, const std::vector<Rod>& b) {
  double farthest = 0;
  for (size_t r = 0; r < a.size(); ++r) {
    farthest = std::max(farthest, (a[r].position - b[r].position).colwise().norm().maxCoeff());
    for (size_t i = 0; i < a[r].directors.size(); ++i) {
      farthest = std::max(farthest, 0.01 * (a[r].directors[i] - b[r].directors[i]).cwiseAbs().maxCoeff());
    }
  }
  return farthest;
}

PlainOptions Options(RodForm form) {
  return {.form = form, .time_step = 2e-5, .damping = 0.5, .gravity = {0.5, 0, -9.8}};
}

class RodLanes : public testing::TestWithParam<std::tuple<int, RodForm>> {
 protected:
  void SetUp() override {
    if (std::get<0>(GetParam()) > MachineDoubles()) GTEST_SKIP() << "this machine has no such registers";
    UseRodKernel(std::get<0>(GetParam()));
  }
  void TearDown() override { UseRodKernel(0); }
};

TEST_P(RodLanes, StepAsThePlainStepperDoes) {
  const RodForm form = std::get<1>(GetParam());
  std::mt19937 random(7);
  for (const int count : {1, 3, 8}) {
    std::vector<Rod> plain = Rods(random, form, count, 20), lanes = plain, single = plain;
    auto batch = LaneRods<double>::Make(lanes, form).value();
    auto rough = LaneRods<float>::Make(lanes, form).value();
    const std::vector<Rod> start = plain;
    for (int step = 0; step < 2000; ++step) StepPlain(plain, step * 2e-5, Options(form));
    EXPECT_EQ(batch.Advance(1500, 0, Options(form)), 1500);
    EXPECT_EQ(batch.Advance(500, 0.03, Options(form)), 500);
    EXPECT_EQ(rough.Advance(2000, 0, Options(form)), 2000);
    batch.Store(lanes);
    rough.Store(single);
    EXPECT_GT(Farthest(start, plain), 1e-3) << "nothing moved";
    EXPECT_LT(Farthest(plain, lanes), 1e-12);
    EXPECT_LT(Farthest(plain, single), 1e-3);
  }
}

TEST_P(RodLanes, ARodDoesNotFeelItsNeighbours) {
  const RodForm form = std::get<1>(GetParam());
  std::mt19937 random(8);
  const std::vector<Rod> rods = Rods(random, form, 8, 10);
  const auto run = [&](std::vector<Rod> some) {
    auto batch = LaneRods<double>::Make(some, form).value();
    batch.Advance(500, 0, Options(form));
    batch.Store(some);
    return some;
  };
  const std::vector<Rod> all = run(rods);
  const std::vector<Rod> one = run({rods[5]});
  EXPECT_EQ((all[5].position - one[0].position).cwiseAbs().maxCoeff(), 0) << "to the bit";
}

// Rest curvatures that grow and a force at the tip, both set in the middle of each step.
TEST_P(RodLanes, WhatIsSetInTheMiddleOfAStepCounts) {
  const RodForm form = std::get<1>(GetParam());
  std::mt19937 random(9);
  std::vector<Rod> plain = Rods(random, form, 2, 12), lanes = plain;
  auto batch = LaneRods<double>::Make(lanes, form).value();
  const auto curvature = [](double time) { return 100 * time; };
  const Vector3d pull(0.01, -0.02, 0.03);
  for (int step = 0; step < 1000; ++step) {
    StepPlain(plain, step * 2e-5, Options(form),
              [&](double time, std::span<Rod> rods, std::span<Eigen::Matrix3Xd> forces) {
                for (Rod& rod : rods) rod.rest_curvature.row(1).setConstant(curvature(time));
                forces[1].col(12) += pull;
              });
  }
  batch.Advance(1000, 0, Options(form), [&](double time, LaneRods<double>& rods) {
    for (size_t i = 0; i < 11; ++i) {
      for (size_t lane = 0; lane < 2; ++lane) {
        rods.rest_curvatures()[(3 * i + 1) * kRodLanes + lane] = curvature(time);
      }
    }
    for (size_t k = 0; k < 3; ++k) {
      rods.forces()[(3 * 12 + k) * kRodLanes + 1] += pull[static_cast<Eigen::Index>(k)];
    }
  });
  batch.Store(lanes);
  EXPECT_LT(Farthest(plain, lanes), 1e-12);
}

// Couples on every element and forces on every node, new ones in every step.
TEST_P(RodLanes, CouplesFromOutsideCountAsInThePlainStepper) {
  const RodForm form = std::get<1>(GetParam());
  std::mt19937 random(12);
  const std::vector<Rod> start = Rods(random, form, 8, 12);
  std::vector<Rod> plain = start, lanes = start, without = start;
  auto batch = LaneRods<double>::Make(lanes, form).value();
  batch.UseCouples(true);
  const PlainOptions options = Options(form);
  std::normal_distribution<double> force(0, 0.01), couple(0, 0.001);
  for (Rod& rod : plain) DriftPlain(rod, form, 0.5 * options.time_step);
  batch.Drift(0.5 * options.time_step);
  for (int step = 0; step < 500; ++step) {
    std::ranges::fill(batch.forces(), 0.0);
    std::ranges::fill(batch.couples(), 0.0);
    for (size_t lane = 0; lane < 8; ++lane) {
      const Eigen::Matrix3Xd forces = Eigen::Matrix3Xd::NullaryExpr(3, 13, [&] { return force(random); });
      const Eigen::Matrix3Xd couples = Eigen::Matrix3Xd::NullaryExpr(3, 12, [&] { return couple(random); });
      for (size_t k = 0; k < 36; ++k) batch.couples()[k * kRodLanes + lane] += couples.data()[k];
      for (size_t k = 0; k < 39; ++k) batch.forces()[k * kRodLanes + lane] += forces.data()[k];
      KickPlain(plain[lane], options, forces, couples);
      DriftPlain(plain[lane], form, options.time_step);
    }
    batch.Kick(options);
    batch.Drift(options.time_step);
  }
  ASSERT_FALSE(batch.trouble().any());
  batch.Store(lanes);
  EXPECT_LT(Farthest(plain, lanes), 1e-12);
  std::vector<double> spins(batch.couples().size());
  batch.LabSpins(spins);
  for (size_t lane = 0; lane < 8; ++lane) {
    for (size_t i = 0; i < 12; ++i) {
      const Vector3d spin =
          plain[lane].directors[i].transpose() * plain[lane].spin.col(static_cast<Eigen::Index>(i));
      for (size_t k = 0; k < 3; ++k) {
        EXPECT_NEAR(spins[(3 * i + k) * kRodLanes + lane], spin[static_cast<Eigen::Index>(k)], 1e-9);
      }
    }
  }
}

// The published form does not keep angular momentum: docs/validation.md, free_rod, has by how much.
class EnergyRodLanes : public RodLanes {};

// Rods are turned any way, so that an element's own axes are not the lab's.
TEST_P(EnergyRodLanes, ACoupleMakesThatMuchAngularMomentum) {
  const RodForm form = std::get<1>(GetParam());
  const Vector3d along = Vector3d(1, -2, 0.5).normalized();
  const Vector3d couple = 1e-4 * along;  // N m on each element
  RodDesign design;
  design.direction = along;
  design.elements = 16;
  design.base = EndHold::kFree;
  std::vector<Rod> rods(3, MakeRod(design).value());
  rods[1].spin.row(0).setConstant(2);     // tumbles
  rods[2].rest_curvature.setConstant(1);  // coils
  const auto momentum = [](const Rod& rod) {
    Vector3d sum = Vector3d::Zero();
    for (Eigen::Index i = 0; i < rod.mass.size(); ++i) {
      sum += rod.mass[i] * rod.position.col(i).cross(rod.velocity.col(i));
    }
    for (Eigen::Index i = 0; i < rod.elements(); ++i) {
      sum += rod.directors[static_cast<size_t>(i)].transpose() *
             rod.inertia.col(i).cwiseProduct(rod.spin.col(i));
    }
    return sum;
  };
  std::vector<Vector3d> start;
  for (const Rod& rod : rods) start.push_back(momentum(rod));
  auto batch = LaneRods<double>::Make(rods, form).value();
  batch.UseCouples(true);
  const int steps = 1000;
  EXPECT_EQ(batch.Advance(steps, 0, {.form = form, .time_step = 2e-5},
                          [&](double, LaneRods<double>& lanes) {
                            for (size_t k = 0; k < lanes.couples().size(); ++k) {
                              lanes.couples()[k] += couple[static_cast<Eigen::Index>(k / kRodLanes % 3)];
                            }
                          }),
            steps);
  batch.Store(rods);
  const Vector3d given = steps * 2e-5 * 16 * couple;
  for (size_t r = 0; r < rods.size(); ++r) {
    EXPECT_LT((momentum(rods[r]) - start[r] - given).norm(), 1e-12 * (given.norm() + start[r].norm())) << r;
  }
}

TEST_P(RodLanes, CouplesThatAreNotUsedChangeNoByte) {
  const RodForm form = std::get<1>(GetParam());
  std::mt19937 random(13);
  const std::vector<Rod> rods = Rods(random, form, 8, 10);
  const auto run = [&](bool couples) {
    auto batch = LaneRods<double>::Make(rods, form).value();
    batch.UseCouples(true);
    batch.UseCouples(couples);
    batch.Advance(200, 0, Options(form), [](double, LaneRods<double>&) {});
    return std::vector<double>(batch.memory().begin(), batch.memory().end());
  };
  EXPECT_EQ(run(true), run(false));
}

TEST_P(RodLanes, WhatDivergesStopsAndSaysSo) {
  const RodForm form = std::get<1>(GetParam());
  std::mt19937 random(10);
  std::vector<Rod> rods = Rods(random, form, 4, 20);
  PlainOptions options = Options(form);
  options.time_step = 2e-3;  // ten times beyond the limit
  auto batch = LaneRods<double>::Make(rods, form).value();
  EXPECT_LT(batch.Advance(100000, 0, options), 1000);
  EXPECT_TRUE(batch.trouble().any());
}

INSTANTIATE_TEST_SUITE_P(Kernels, RodLanes,
                         testing::Combine(testing::Values(2, 4, 8),
                                          testing::Values(RodForm::kPaper, RodForm::kEnergy)));
INSTANTIATE_TEST_SUITE_P(Kernels, EnergyRodLanes,
                         testing::Combine(testing::Values(2, 4, 8), testing::Values(RodForm::kEnergy)));

TEST(LaneRods, RefusesWhatDoesNotFitSideBySide) {
  std::mt19937 random(11);
  std::vector<Rod> rods = Rods(random, RodForm::kPaper, 2, 10);
  rods.push_back(Rods(random, RodForm::kPaper, 1, 11)[0]);
  EXPECT_FALSE(LaneRods<double>::Make(rods, RodForm::kPaper).ok());
  EXPECT_FALSE(LaneRods<double>::Make({}, RodForm::kPaper).ok());
}

}  // namespace
}  // namespace tendril
