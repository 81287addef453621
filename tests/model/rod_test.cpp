// model/rods: the rod's energy, that loads are its gradient, and what a free rod keeps.
#include "model/rods/rod.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "model/geometry/rotation.h"
#include "model/rods/rod_plain.h"

namespace tendril {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;

Rod Bent(std::mt19937& random, double strain = 0.05, double turn = 0.2) {
  RodDesign design;
  design.elements = 6;
  design.length = 0.3;
  design.taper = 0.5;
  design.direction = {1, 2, -1};
  design.base = EndHold::kFree;
  Rod rod = MakeRod(design).value();
  std::normal_distribution<double> normal;
  const auto draw = [&](double size) {
    return Vector3d(size * normal(random), size * normal(random), size * normal(random));
  };
  const double element = rod.rest_length[0];
  for (auto x : rod.position.colwise()) x += draw(strain * element);
  for (Eigen::Matrix3d& q : rod.directors) q = ExpSo3(draw(turn)) * q;
  for (auto k : rod.rest_curvature.colwise()) k = draw(5);
  for (auto s : rod.rest_strain.colwise()) s = draw(0.05);
  return rod;
}

TEST(Rod, IsStraightAndWeighsWhatItsVolumeDoes) {
  RodDesign design;
  design.elements = 40;
  design.direction = {0, 0, -2};
  design.normal = {1, 0, 5};
  const Rod rod = MakeRod(design).value();
  const double volume = std::numbers::pi * 0.02 * 0.02 * 0.75;
  EXPECT_NEAR(rod.mass.sum(), 100 * volume, 1e-15);
  EXPECT_NEAR((rod.position.col(40) - Vector3d(0, 0, -0.75)).norm(), 0, 1e-15);
  EXPECT_NEAR((rod.directors[7].row(0).transpose() - Vector3d::UnitX()).norm(), 0, 1e-15);
  EXPECT_LT(EnergyOf(rod).total(), 1e-25);  // rounding of the nodes
}

TEST(Rod, RefusesWhatIsNone) {
  const auto message = [](const auto& change) {
    RodDesign design;
    change(design);
    const Result<Rod> rod = MakeRod(design);
    return rod.ok() ? std::string() : rod.error().message;
  };
  EXPECT_EQ(message([](RodDesign&) {}), "");
  EXPECT_NE(message([](RodDesign& d) { d.elements = 1; }).find("elements = 1"), std::string::npos);
  EXPECT_NE(message([](RodDesign& d) { d.density = -1; }).find("density"), std::string::npos);
  EXPECT_NE(message([](RodDesign& d) { d.normal = d.direction; }).find("normal"), std::string::npos);
  EXPECT_NE(message([](RodDesign& d) { d.length = NAN; }).find("length"), std::string::npos);
}

// Every load against a central difference of the energy, by moving each node and turning each element.
TEST(RodLoads, AreMinusTheEnergysGradient) {
  std::mt19937 random(3);
  for (const double turn : {1e-6, 0.2, 0.9}) {
    Rod rod = Bent(random, 0.1, turn);
    if (turn > 0.1) {  // with half an element that bends at either end
      rod.base.hold = rod.tip.hold = EndHold::kFrame;
      rod.base.rest_curvature = {1, 2, -3};
      rod.tip.rest_curvature = {-2, 0, 1};
    }
    Matrix3Xd force, couple;
    InternalLoads(rod, RodForm::kEnergy, force, couple);
    const auto slope = [&](const auto& move, double step) {
      Rod plus = rod, minus = rod;
      move(plus, step);
      move(minus, -step);
      return (EnergyOf(plus).total() - EnergyOf(minus).total()) / (2 * step);
    };
    for (Eigen::Index i = 0; i < 7; ++i) {
      for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(force(k, i), -slope([&](Rod& r, double h) { r.position(k, i) += h; }, 1e-7),
                    1e-7 * force.norm());
        if (i == 6) continue;
        EXPECT_NEAR(couple(k, i),
                    -slope(
                        [&](Rod& r, double h) {
                          auto& q = r.directors[static_cast<std::size_t>(i)];
                          q = ExpSo3(-h * Vector3d::Unit(k)) * q;
                        },
                        1e-6),
                    1e-7 * couple.norm());
      }
    }
  }
}

TEST(RodLoads, TurnAndMoveWithTheRod) {
  std::mt19937 random(5);
  const Rod rod = Bent(random);
  const Eigen::Matrix3d turn = ExpSo3(Vector3d(0.3, -1.2, 0.7));
  Rod turned = rod;
  turned.position = (turn * rod.position).colwise() + Vector3d(1, 2, 3);
  for (Eigen::Matrix3d& q : turned.directors) q = q * turn.transpose();
  for (const RodForm form : {RodForm::kPaper, RodForm::kEnergy}) {
    Matrix3Xd force, couple, turned_force, turned_couple;
    InternalLoads(rod, form, force, couple);
    InternalLoads(turned, form, turned_force, turned_couple);
    EXPECT_LT((turned_force - turn * force).norm(), 1e-12 * force.norm());
    EXPECT_LT((turned_couple - couple).norm(), 1e-12 * couple.norm());
  }
}

Vector3d Momentum(const Rod& rod) { return rod.velocity * rod.mass; }

Vector3d AngularMomentum(const Rod& rod) {
  Vector3d sum = Vector3d::Zero();
  for (Eigen::Index i = 0; i < rod.mass.size(); ++i) {
    sum += rod.mass[i] * Vector3d(rod.position.col(i)).cross(Vector3d(rod.velocity.col(i)));
  }
  for (Eigen::Index i = 0; i < rod.elements(); ++i) {
    sum += rod.directors[static_cast<std::size_t>(i)].transpose() *
           rod.inertia.col(i).cwiseProduct(rod.spin.col(i));
  }
  return sum;
}

// A free rod that bends, stretches, shears and twists without damping.
Rod FreeRod() {
  RodDesign design;
  design.elements = 20;
  design.length = 0.5;
  design.base_radius = 0.01;
  design.density = 500;
  design.youngs_modulus = 1e6;
  design.shear_modulus = 1e6 / 3;
  design.direction = Vector3d::UnitX();
  design.normal = Vector3d::UnitZ();
  design.base = EndHold::kFree;
  Rod rod = MakeRod(design).value();
  for (int i = 0; i <= 20; ++i) {
    const double s = std::numbers::pi * i / 20;
    rod.velocity.col(i) << 0.1 * std::cos(s), 0.3 * std::sin(3 * s), 0.5 * std::cos(2 * s);
    if (i < 20) rod.spin.col(i) << 0.5, -1, 5 * std::cos(s + 0.5 * std::numbers::pi / 20);
  }
  return rod;
}

struct Drifts {
  double energy = 0;  // largest relative deviation
  double momentum = 0, angular = 0;
};

Drifts DriftsOf(RodForm form, double time_step) {
  Rod rod = FreeRod();
  const Vector3d momentum = Momentum(rod), angular = AngularMomentum(rod);
  const double energy = EnergyOf(rod).total();
  const PlainOptions options{.form = form, .time_step = time_step};
  Drifts drifts;
  for (int step = 0; step * time_step < 0.5; ++step) {
    StepPlain({&rod, 1}, step * time_step, options);
    drifts.energy = std::max(drifts.energy, std::abs(EnergyOf(rod).total() / energy - 1));
  }
  drifts.momentum = (Momentum(rod) - momentum).norm() / momentum.norm();
  drifts.angular = (AngularMomentum(rod) - angular).norm() / angular.norm();
  return drifts;
}

TEST(StepPlain, AFreeRodKeepsItsMomenta) {
  const Drifts drifts = DriftsOf(RodForm::kEnergy, 1e-4);
  EXPECT_LT(drifts.momentum, 1e-12);
  EXPECT_LT(drifts.angular, 1e-11);
  EXPECT_LT(DriftsOf(RodForm::kPaper, 1e-4).momentum, 1e-12);
}

// The energy's swing falls with the square of the step; in the paper's form it does not fall.
TEST(StepPlain, OnlyTheEnergyFormKeepsEnergyAsTheStepShrinks) {
  const double coarse = DriftsOf(RodForm::kEnergy, 1e-4).energy;
  const double fine = DriftsOf(RodForm::kEnergy, 5e-5).energy;
  EXPECT_LT(coarse, 2e-3);
  EXPECT_NEAR(coarse / fine, 4, 0.4);
  const double paper = DriftsOf(RodForm::kPaper, 1e-5).energy;
  EXPECT_GT(paper, 1e-3);
  EXPECT_NEAR(DriftsOf(RodForm::kPaper, 2e-5).energy / paper, 1, 0.05);
}

// A clamped rod with a rest curvature comes to rest in the helix of that curvature, whose nodes are known.
TEST(StepPlain, RestCurvatureMakesTheHelixOfItsRadiusAndPitch) {
  const double k = 12, tau = 4;
  for (const RodForm form : {RodForm::kPaper, RodForm::kEnergy}) {
    RodDesign design;
    design.elements = 30;
    design.length = 0.45;
    design.base_radius = 0.015;
    Rod rod = MakeRod(design).value();
    const PlainOptions options{.form = form, .time_step = 2e-4, .damping = 8};
    for (int step = 0; step < 30000; ++step) {
      StepPlain({&rod, 1}, step * 2e-4, options, [&](double time, std::span<Rod> rods, auto) {
        rods[0].rest_curvature.colwise() = std::min(time / 0.5, 1.0) * Vector3d(0, k, tau);
      });
    }
    EXPECT_LT(EnergyOf(rod).total(), 1e-18);
    // Chords of equal length turned by equal rotations: the axis and radius follow from one such rotation.
    const Eigen::AngleAxisd turn(Eigen::Matrix3d(rod.directors[1].transpose() * rod.directors[0]));
    const Vector3d edge = rod.position.col(1) - rod.position.col(0);
    const double element = design.length / design.elements;
    EXPECT_NEAR(turn.angle(), element * std::hypot(k, tau), 1e-9);
    const double rise = std::abs(turn.axis().dot(edge));
    EXPECT_NEAR(rise / turn.angle(), tau / (k * k + tau * tau), 2e-3 * tau / (k * k + tau * tau));
    const double radius = 0.5 * std::sqrt(edge.squaredNorm() - rise * rise) / std::sin(0.5 * turn.angle());
    EXPECT_NEAR(radius, k / (k * k + tau * tau), 2e-3 * k / (k * k + tau * tau));
  }
}

TEST(Rod, StartsAlikeFromACurvatureStatedOnceOrEverywhere) {
  RodDesign once;
  once.elements = 40;
  once.start_curvature = {0.4, -1.2, 0.9};
  RodDesign everywhere = once;
  everywhere.start_curvature.setZero();
  everywhere.start_curvatures = once.start_curvature.replicate(1, 40);
  const Rod a = MakeRod(once).value(), b = MakeRod(everywhere).value();
  EXPECT_LT((a.position - b.position).norm(), 1e-13);
  for (std::size_t i = 0; i < 40; ++i) EXPECT_LT((a.directors[i] - b.directors[i]).norm(), 1e-13) << i;
}

TEST(Rod, StartsWithTheCurvatureOfEachNode) {
  RodDesign design;
  design.elements = 30;
  design.base = EndHold::kFrame;
  design.start_curvatures = 5 * Eigen::Matrix3Xd::Random(3, 30);
  const Rod rod = MakeRod(design).value();
  EXPECT_LT((BaseCurvature(rod) - design.start_curvatures.col(0)).norm(), 1e-11);
  for (Eigen::Index i = 0; i < 29; ++i) {
    EXPECT_LT((CurvatureOf(rod, i) - design.start_curvatures.col(i + 1)).norm(), 1e-11) << i;
  }
  for (Eigen::Index i = 0; i < 30; ++i) EXPECT_LT(StrainOf(rod, i).norm(), 1e-13) << i;
  design.start_curvatures.conservativeResize(3, 29);
  const auto short_of_one = MakeRod(design);
  ASSERT_FALSE(short_of_one.ok());
  EXPECT_NE(short_of_one.error().message.find("start_curvatures = 29 columns"), std::string::npos);
}

}  // namespace
}  // namespace tendril
