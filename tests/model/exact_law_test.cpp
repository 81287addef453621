// model/fold/exact_law.h: closed forms, the equations in 50 digits, the energy's minimum, and the extremes.
#include "model/fold/exact_law.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "model/fold/facet_chain.h"
#include "model/fold/fold.h"
#include "tests/support/random_design.h"

namespace tendril {
namespace {

using Digits50 = boost::multiprecision::cpp_bin_float_50;
constexpr double kDegree = std::numbers::pi / 180;

TentacleDesign Untapered() {
  TentacleDesign design;
  design.taper = 1;
  design.beta = design.alpha;
  return design;
}

// Equal creases fold alike: 2 d (1 - cos phi) in closed form, whatever the pull.
TEST(ExactLaw, EqualCreasesAreTheClosedForm) {
  TentacleDesign design = Untapered();
  design.spacing_ratio = 1;
  for (const double pull : {1e-300, 1e-16, 1e-6, 0.1, 0.5, 0.999, 1 - 1e-12, std::nextafter(1.0, 0.0)}) {
    const ExactFold fold = SolveExactFold(design, pull).value();
    const double expected = static_cast<double>(2 * asin(sqrt(Digits50(pull) / 2)));
    for (const double angle : fold.angle) EXPECT_NEAR(angle, expected, 4e-15 * expected) << pull;
    const double d = 0.0075;
    const double b = 4e9 * 0.02 * 1e-12 / (12 * 1e-3);
    EXPECT_NEAR(fold.tension, 2 * b / d * (expected / std::sin(expected)), 1e-14 * fold.tension) << pull;
  }
  EXPECT_EQ(SolveExactFold(design, 1).value().closed.size(), 48u);
}

// Without taper at spacing ratio 0.5 the short ones stay flat until the long ones have closed.
TEST(ExactLaw, LongCreasesCloseBeforeShortOnesStart) {
  const TentacleDesign design = Untapered();
  const ExactFold fold = SolveExactFold(design, 0.3).value();
  for (Eigen::Index i = 0; i < 48; i += 2) {
    EXPECT_NEAR(fold.angle[i] / kDegree, 56.633, 5e-4);
    EXPECT_EQ(fold.angle[i + 1], 0);
  }
  const double b = HingeStiffness(design, LayOut(design).value())[0];
  const ExactFold later = SolveExactFold(design, 0.75).value();
  ASSERT_EQ(later.closed.size(), 24u);
  EXPECT_EQ(later.closed[1], 2);
  EXPECT_GT(later.angle[1], 0);
  EXPECT_GT(later.tension, 2 * b / 0.005);
  EXPECT_GT(later.closing_moment[0], 0);
  // Between: long creases closed, short ones not yet begun, just beyond the pull of 2/3.
  const double third = 2.0 / 3;
  EXPECT_NEAR(SolveExactFold(design, third + 1e-9).value().tension, 2 * b / 0.005, 1e-8 * 2 * b / 0.005);
  EXPECT_LT(SolveExactFold(design, third - 1e-9).value().tension, b * std::numbers::pi / 0.010 * (1 + 1e-9));
}

// The order in which a taper's creases fold is that of d sin^2 a / B: from the tip.
TEST(ExactLaw, ATaperFoldsFromTheTip) {
  TentacleDesign design;
  design.beta = design.alpha;
  design.spacing_ratio = 1;
  const ExactFold fold = SolveExactFold(design, 0.05).value();
  for (Eigen::Index i = 1; i < 48; ++i) EXPECT_GE(fold.angle[i], fold.angle[i - 1]);
  EXPECT_EQ(fold.angle[0], 0);
  EXPECT_GT(fold.angle[47], 20 * kDegree);
}

struct Residuals {
  double constraint = 0;  // relative to the flat length, and to the pull where it is small
  double force = 0;       // largest relative disagreement of a crease with the tension
};

// The equations as they are written, in 50 digits, at the answer's doubles.
Residuals ResidualsOf(const TentacleLayout& layout, const Eigen::VectorXd& stiffness, double rest,
                      const ExactFold& fold, double pull) {
  Residuals residuals;
  const Digits50 right = 2 * atan(Digits50(1));
  Digits50 flat = 0, shortening = 0;
  for (Eigen::Index i = 0; i < layout.half_spacing.size(); ++i) {
    const Digits50 d = layout.half_spacing[i];
    const double cosine_of_crease = std::cos(layout.crease_angle[i]);
    const Digits50 c =
        std::abs(cosine_of_crease) > 1e-15 ? Digits50(cos(Digits50(layout.crease_angle[i]))) : Digits50(0);
    const Digits50 s = 1 - c * c;
    const bool closed = std::binary_search(fold.closed.begin(), fold.closed.end(), static_cast<int>(i));
    const Digits50 angle = closed ? right : Digits50(fold.angle[i]);
    const Digits50 root = sqrt(1 - s * sin(angle) * sin(angle));
    flat += 2 * d;
    shortening += 2 * d * (1 - root);
    const Digits50 tension = fold.tension;
    if (closed) {
      const Digits50 needed =
          c == 0 ? Digits50(2 * Digits50(stiffness[i]) * (right - rest) / d) : Digits50(0);
      if (needed > tension) residuals.force = std::max(residuals.force, double(needed / tension - 1));
      continue;
    }
    if (angle == 0) {
      const Digits50 critical = 2 * Digits50(stiffness[i]) / (d * s);
      if (tension > critical) residuals.force = std::max(residuals.force, double(tension / critical - 1));
      continue;
    }
    if (fold.tension == 0) continue;  // slack or at rest
    const Digits50 moment = tension * d * s * sin(angle) * cos(angle) / root;
    const Digits50 spring = 2 * Digits50(stiffness[i]) * (angle - Digits50(rest));
    // A rounding of the angle itself changes either side; near a right angle the moment most of all.
    const double rounding =
        2e-16 * fold.angle[i] * (1 / (fold.angle[i] - rest) + 1 / (std::numbers::pi / 2 - fold.angle[i]));
    const double off = std::abs(double(moment / spring - 1));
    residuals.force = std::max(residuals.force, off - rounding);
  }
  residuals.constraint =
      std::abs(double((shortening - Digits50(pull) * flat) / (flat * std::min(pull, 1.0))));
  return residuals;
}

TEST(ExactLaw, MeetsItsEquationsInFiftyDigits) {
  std::mt19937_64 random(17);
  int solved = 0;
  for (int trial = 0; trial < 300; ++trial) {
    TentacleDesign design = test::RandomDesign(random);
    const TentacleLayout layout = LayOut(design).value();
    const Eigen::VectorXd stiffness = HingeStiffness(design, layout);
    const double largest = LargestExactPull(layout, design.closed_angle);
    const double share = std::uniform_real_distribution<double>(0, 1)(random);
    const double pull = largest * (trial % 3 == 0 ? std::pow(10, -12 * share) : share);
    const Result<ExactFold> fold = SolveExactFold(layout, stiffness, 0, design.closed_angle, pull);
    ASSERT_TRUE(fold.ok()) << fold.error().message;
    const Residuals residuals = ResidualsOf(layout, stiffness, 0, fold.value(), pull);
    EXPECT_LT(residuals.force, 1e-14) << trial << " pull " << pull;
    EXPECT_LT(residuals.constraint, 2e-14) << trial << " pull " << pull;
    ++solved;
  }
  EXPECT_EQ(solved, 300);
}

// Among shapes of the same pull none has less energy: tried in random directions along the constraint.
TEST(ExactLaw, NoShapeOfThePullHasLessEnergy) {
  std::mt19937_64 random(23);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 60; ++trial) {
    TentacleDesign design = test::RandomDesign(random);
    design.stiffness_ratio = 0.5 + trial % 3;
    const TentacleLayout layout = LayOut(design).value();
    const Eigen::VectorXd stiffness = HingeStiffness(design, layout);
    const double rest = trial % 2 == 0 ? 0 : 0.2;
    const auto shortening = [&](const Eigen::VectorXd& angle) {
      const Eigen::ArrayXd s = layout.crease_angle.array().sin().square();
      return (2 * layout.half_spacing.array() * (1 - (1 - s * angle.array().sin().square()).sqrt())).sum();
    };
    const auto energy = [&](const Eigen::VectorXd& angle) {
      return (2 * stiffness.array() * (angle.array() - rest).square()).sum();
    };
    const double pull = 0.6 * LargestExactPull(layout, design.closed_angle);
    const ExactFold fold = SolveExactFold(layout, stiffness, rest, design.closed_angle, pull).value();
    if (fold.slack) continue;
    const double target = shortening(fold.angle);
    for (int direction = 0; direction < 20; ++direction) {
      Eigen::VectorXd other = fold.angle;
      for (double& angle : other) angle += 0.05 * normal(random);
      other = other.cwiseAbs().cwiseMin(std::numbers::pi / 2);
      // Back to the pull by scaling all angles.
      double low = 0, high = 50;
      const auto scaled = [&](double k) -> Eigen::VectorXd {
        return (k * other).cwiseMin(std::numbers::pi / 2);
      };
      for (int i = 0; i < 100; ++i) {
        const double k = 0.5 * (low + high);
        (shortening(scaled(k)) < target ? low : high) = k;
      }
      EXPECT_GE(energy(scaled(high)), energy(fold.angle) * (1 - 1e-9)) << trial;
    }
  }
}

TEST(ExactLaw, TheRigidShapeReallyHasThePull) {
  for (const double pull : {0.05, 0.3, 0.6}) {
    const TentacleDesign design;
    const TentacleLayout layout = LayOut(design).value();
    const ExactFold fold = SolveExactFold(design, pull).value();
    const TendonCurve curve = TendonCurveOf(layout, FoldChain(layout, fold.angle), fold.angle);
    EXPECT_NEAR(KinematicPull(layout, curve), pull, 1e-14);
    EXPECT_NEAR(fold.tendon_length, (1 - pull) * 0.72, 1e-14);
  }
}

TEST(ExactLaw, BelowItsRestShapeTheTendonIsSlack) {
  TentacleDesign design = Untapered();
  design.spacing_ratio = 1;
  design.rest_angle = 15 * kDegree;
  const double rest_pull = 1 - std::cos(design.rest_angle);
  const ExactFold slack = SolveExactFold(design, 0.9 * rest_pull).value();
  EXPECT_TRUE(slack.slack);
  EXPECT_EQ(slack.tension, 0);
  EXPECT_EQ(slack.angle[5], design.rest_angle);
  const ExactFold taut = SolveExactFold(design, 0.2).value();
  EXPECT_FALSE(taut.slack);
  const double expected = std::acos(0.8);
  EXPECT_NEAR(taut.angle[5], expected, 1e-14);
  const double b = HingeStiffness(design, LayOut(design).value())[0];
  EXPECT_NEAR(taut.tension, 2 * b * (expected - design.rest_angle) / (0.0075 * std::sin(expected)),
              1e-13 * taut.tension);
}

// A rest angle, fitted per pull, brings the two laws near each other.
TEST(ExactLaw, WithARestAngleItComesNearThePapersLaw) {
  for (const double pull : {0.1, 0.2, 0.3}) {
    TentacleDesign design;
    const Fold paper = SolveFold(design, pull).value();
    double least = 1e9;
    for (int step = 0; step < 600; ++step) {
      const double rest = 0.05 * step;
      design.rest_angle = rest * kDegree;
      const ExactFold exact = SolveExactFold(design, pull).value();
      if (exact.slack) break;
      least = std::min(least, (exact.angle - paper.angle).norm() / std::sqrt(48.0) / kDegree);
    }
    EXPECT_LT(least, 2.35) << pull;
  }
}

TEST(ExactLaw, RefusesWhatCannotBe) {
  const TentacleDesign design;
  const double largest = LargestExactPull(LayOut(design).value(), design.closed_angle);
  EXPECT_NEAR(largest, 1 - (2 * std::cos(75 * kDegree)) * 0.005 * 24 / 0.72, 1e-15);
  EXPECT_EQ(SolveExactFold(design, 1).error().kind, ErrorKind::kUnreachable);
  EXPECT_EQ(SolveExactFold(design, -0.1).error().kind, ErrorKind::kBadInput);
  EXPECT_EQ(SolveExactFold(design, NAN).error().kind, ErrorKind::kBadInput);
  TentacleDesign other = design;
  other.rest_angle = -0.1;
  EXPECT_EQ(SolveExactFold(other, 0.1).error().kind, ErrorKind::kBadInput);
  const ExactFold all = SolveExactFold(design, largest).value();
  EXPECT_EQ(all.closed.size(), 48u);
  EXPECT_TRUE(std::isinf(all.tension));
}

}  // namespace
}  // namespace tendril
