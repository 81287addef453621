// model/fold/fold.h: the closed form of one crease, published angles, the length constraint against 50
// digits, and its extremes.
#include "model/fold/fold.h"

#include <gtest/gtest.h>

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/support/random_design.h"

namespace tendril {
namespace {

using test::RandomDesign;
using Digits50 = boost::multiprecision::cpp_bin_float_50;

constexpr double kDegree = std::numbers::pi / 180;

// The paper's equation by bisection in 50 digits, from the layout's doubles.
std::vector<Digits50> ExactAngles(const TentacleLayout& layout, double base_width, double closed_angle,
                                  double pull) {
  const Eigen::Index n = layout.half_spacing.size();
  // pi / 2 as a double stands for a right angle.
  const Digits50 closed =
      closed_angle == std::numbers::pi / 2 ? 2 * atan(Digits50(1)) : Digits50(closed_angle);
  std::vector<Digits50> x;
  Digits50 flat = 0;
  Digits50 smallest = 1e300;
  for (Eigen::Index i = 0; i < n; ++i) {
    const Digits50 stiffness_width = Digits50(base_width) * layout.stiffness[i];
    x.push_back(layout.half_spacing[i] / stiffness_width);
    flat += 2 * Digits50(layout.half_spacing[i]);
    smallest = std::min(smallest, x.back());
  }
  const Digits50 half_pull_length = Digits50(pull) * flat / 4;
  const auto angle_at = [&](const Digits50& k, Eigen::Index i) {
    const Digits50 angle = k * x[i];
    return angle < closed ? angle : closed;
  };
  // Bisection on log k: the answer may be 1e-150 or 1e9.
  Digits50 low = log(Digits50(1e-170));
  Digits50 high = log(closed / smallest);
  for (int iteration = 0; iteration < 66; ++iteration) {
    const Digits50 middle = (low + high) / 2;
    const Digits50 k = exp(middle);
    Digits50 taken = 0;
    for (Eigen::Index i = 0; i < n; ++i) {
      const Digits50 s = sin(angle_at(k, i) / 2);
      taken += layout.half_spacing[i] * s * s;
    }
    (taken < half_pull_length ? low : high) = middle;
  }
  std::vector<Digits50> angles;
  for (Eigen::Index i = 0; i < n; ++i) angles.push_back(angle_at(exp(high), i));
  return angles;
}

double LargestRelativeError(const TentacleDesign& design, double pull) {
  const TentacleLayout layout = LayOut(design).value();
  const Fold fold = SolveFold(layout, design.base_width, design.closed_angle, pull).value();
  const auto exact = ExactAngles(layout, design.base_width, design.closed_angle, pull);
  double largest = 0;
  for (Eigen::Index i = 0; i < fold.angle.size(); ++i) {
    const Digits50 error = abs(fold.angle[i] / exact[i] - 1);
    largest = std::max(largest, static_cast<double>(error));
  }
  return largest;
}

TEST(SolveFold, PublishedAnglesOfTheUntaperedTentacle) {
  TentacleDesign design;
  design.taper = 1;
  const Result<Fold> fold = SolveFold(design, 0.3);
  ASSERT_TRUE(fold.ok()) << fold.error().message;
  EXPECT_NEAR(fold.value().angle[1] / kDegree, 26.477, 5e-4);
  EXPECT_NEAR(fold.value().angle[0] / kDegree, 52.955, 5e-4);
}

TEST(SolveFold, OneCreaseFollowsItsClosedForm) {
  TentacleDesign design;
  design.holes = 2;
  for (const double pull : {1e-300, 1e-20, 1e-9, 0.3, 0.999, std::nextafter(1.0, 0.0), 1.0}) {
    const Result<Fold> fold = SolveFold(design, pull);
    ASSERT_TRUE(fold.ok()) << fold.error().message;
    const double exact = 2 * std::asin(std::sqrt(pull / 2));
    EXPECT_NEAR(fold.value().angle[0] / exact, 1, 1e-14) << "pull " << pull;
  }
}

TEST(SolveFold, AnglesAreRightTo12DigitsFromTheSmallestPullToTheLastBelowReach) {
  std::mt19937_64 random(20261122);
  for (int trial = 0; trial < 10; ++trial) {
    const TentacleDesign design = RandomDesign(random);
    const double any = std::uniform_real_distribution<double>(0, 1)(random);
    for (const double pull : {1e-300, 1e-18, 1e-7, any, 1 - 1e-9, std::nextafter(1.0, 0.0)}) {
      EXPECT_LT(LargestRelativeError(design, pull), 1e-12)
          << "trial " << trial << " pull " << pull << " ratio " << design.stiffness_ratio;
    }
  }
}

// Soft creases shut, stiff ones hardly moved: the stiff ones' angles are in the pull's last digits.
TEST(SolveFold, StiffCreasesKeepTheirDigitsWhereTheSoftOnesHaveJustClosed) {
  TentacleDesign design;  // soft (alpha) creases hold two thirds of the tendon
  for (const double ratio : {1e3, 1e6, 1e9}) {
    design.stiffness_ratio = ratio;
    for (const double pull : {2.0 / 3, std::nextafter(2.0 / 3, 1.0), 2.0 / 3 + 1e-14, 2.0 / 3 + 1e-8}) {
      EXPECT_LT(LargestRelativeError(design, pull), 1e-12) << "ratio " << ratio << " pull " << pull;
    }
  }
}

TEST(SolveFold, OtherClosedAnglesKeepTheLawToo) {
  for (const double degrees : {1.0, 30.0, 89.0}) {
    TentacleDesign design;
    design.closed_angle = degrees * kDegree;
    const double reach = LargestPull(design.closed_angle);
    EXPECT_NEAR(reach / (2 * std::pow(std::sin(design.closed_angle / 2), 2)), 1, 1e-15);
    for (const double share : {1e-9, 0.5, 0.99, 1 - 1e-12}) {
      EXPECT_LT(LargestRelativeError(design, share * reach), 1e-12) << degrees << " deg, share " << share;
    }
  }
}

TEST(SolveFold, TendonIsAsLongAsThePullLeavesIt) {
  std::mt19937_64 random(7);
  for (int trial = 0; trial < 300; ++trial) {
    TentacleDesign design = RandomDesign(random);
    design.closed_angle = std::uniform_real_distribution<double>(0.01, std::numbers::pi / 2)(random);
    const double pull =
        LargestPull(design.closed_angle) * std::uniform_real_distribution<double>(0, 1)(random);
    const TentacleLayout layout = LayOut(design).value();
    const Fold fold = SolveFold(layout, design.base_width, design.closed_angle, pull).value();
    long double length = 0;  // as the paper has it
    for (Eigen::Index i = 0; i < fold.angle.size(); ++i) {
      length += 2 * layout.half_spacing[i] * std::cos(static_cast<long double>(fold.angle[i]));
    }
    const double wanted = (1 - pull) * FlatTendonLength(layout);
    EXPECT_NEAR(static_cast<double>(length), wanted, 1e-12 * FlatTendonLength(layout)) << "trial " << trial;
    EXPECT_NEAR(fold.tendon_length, wanted, 1e-12 * FlatTendonLength(layout));
    // Force balance of open creases: one k for all.
    for (Eigen::Index i = 0; i < fold.angle.size(); ++i) {
      if (fold.angle[i] >= design.closed_angle) continue;
      const double k = fold.angle[i] * design.base_width * layout.stiffness[i] / layout.half_spacing[i];
      EXPECT_NEAR(k / fold.scale, 1, 1e-14);
    }
  }
}

TEST(SolveFold, FlatAndClosedAreExact) {
  for (const int holes : {2, 49, 2000}) {
    TentacleDesign design;
    design.holes = holes;
    design.length = 0.03 * holes;
    const Fold flat = SolveFold(design, 0).value();
    EXPECT_EQ(flat.scale, 0);
    EXPECT_EQ(flat.angle.cwiseAbs().maxCoeff(), 0);
    EXPECT_TRUE(flat.closed.empty());
    const Fold closed = SolveFold(design, 1).value();
    EXPECT_EQ(static_cast<int>(closed.closed.size()), holes - 1);
    EXPECT_EQ(closed.angle.minCoeff(), std::numbers::pi / 2);
    EXPECT_EQ(closed.tendon_length, 0);
  }
}

TEST(SolveFold, AnglesDoNotDependOnTheUnitOfLength) {
  const Fold metres = SolveFold(TentacleDesign{}, 0.5).value();
  for (const double scale : {1e-3 / 0.75, 100 / 0.75}) {  // a tentacle of 1 mm, one of 100 m
    TentacleDesign design;
    for (double* length : {&design.length, &design.base_width, &design.unit_length, &design.hole_diameter}) {
      *length *= scale;
    }
    const Fold scaled = SolveFold(design, 0.5).value();
    EXPECT_LT((scaled.angle - metres.angle).cwiseAbs().maxCoeff(), 1e-13);
    EXPECT_EQ(scaled.closed, metres.closed);
  }
}

TEST(SolveFold, AnglesGrowWithThePull) {
  Eigen::VectorXd before = Eigen::VectorXd::Zero(48);
  for (int percent = 1; percent <= 100; ++percent) {
    const Fold fold = SolveFold(TentacleDesign{}, 0.01 * percent).value();
    EXPECT_GE((fold.angle - before).minCoeff(), 0) << percent;
    before = fold.angle;
  }
}

TEST(SolveFold, BeyondReachNamesTheLargestPull) {
  TentacleDesign design;
  design.closed_angle = 0.5;
  const auto fold = SolveFold(design, 0.5);
  ASSERT_FALSE(fold.ok());
  EXPECT_EQ(fold.error().kind, ErrorKind::kUnreachable);
  EXPECT_NE(fold.error().message.find("0.1224"), std::string::npos) << fold.error().message;
  EXPECT_EQ(SolveFold(TentacleDesign{}, std::nextafter(1.0, 2.0)).error().kind, ErrorKind::kUnreachable);
}

TEST(SolveFold, RefusesAPullThatIsNone) {
  for (const double pull : {-1e-300, -1.0, std::nan(""), HUGE_VAL}) {
    const auto fold = SolveFold(TentacleDesign{}, pull);
    ASSERT_FALSE(fold.ok());
    EXPECT_EQ(fold.error().kind, ErrorKind::kBadInput);
  }
}

}  // namespace
}  // namespace tendril
