// model/fold/rising_fold.h: agreement with the laws it joins, slopes against central differences, extremes.
#include "model/fold/rising_fold.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "model/fold/exact_law.h"
#include "model/fold/fold.h"
#include "model/fold/tendon_friction.h"

namespace tendril {
namespace {

double Uniform(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

TentacleDesign RandomDesign(std::mt19937_64& random) {
  TentacleDesign d;
  d.holes = 17;
  d.taper = Uniform(random, 0.3, 1);
  d.spacing_ratio = Uniform(random, 0.3, 1);
  d.alpha = Uniform(random, 1.2, 1.9);
  d.beta = Uniform(random, 1.1, 2.0);
  d.stiffness_ratio = Uniform(random, 0.5, 2);
  d.stiffness_exponent = Uniform(random, 0, 2);
  return d;
}

TEST(SolveRisingFold, WithoutRestAngleAndFrictionItIsEitherLaw) {
  std::mt19937_64 random(3);
  for (int draw = 0; draw < 20; ++draw) {
    const TentacleDesign design = RandomDesign(random);
    const TentacleLayout layout = LayOut(design).value();
    for (const double pull : {0.0, 1e-6, 0.1, 0.35}) {
      EXPECT_EQ((SolveRisingFold(FoldLaw::kPaper, design, layout, pull).value().angle -
                 SolveFold(design, pull).value().angle)
                    .norm(),
                0);
      EXPECT_LT((SolveRisingFold(FoldLaw::kExact, design, layout, pull).value().angle -
                 SolveExactFold(design, pull).value().angle)
                    .norm(),
                1e-5);
    }
  }
}

// The path-dependent tendon, in steps of 0.01, slides everywhere on the way up.
TEST(SolveRisingFold, AgreesWithTheTendonThatIsPulledStepByStep) {
  for (const double friction : {0.01, 0.05, 0.2}) {
    TentacleDesign design;
    design.rest_angle = 0.15;
    design.tendon_friction = friction;
    FrictionTendon tendon = FrictionTendon::Make(design).value();
    for (const double pull : {0.05, 0.15, 0.3}) {
      const FrictionFold steps = tendon.MoveTo(pull).value();
      const RisingFold once = SolveRisingFold(FoldLaw::kExact, design, LayOut(design).value(), pull).value();
      EXPECT_LT((steps.angle - once.angle).cwiseAbs().maxCoeff(), 2e-3) << friction << " " << pull;
      EXPECT_NEAR(once.tendon_length, (1 - pull) * 0.72, 1e-10);
    }
  }
}

TEST(SolveRisingFold, PaperLawHoldsItsOwnEquationsWithRestAngleAndFriction) {
  TentacleDesign design;
  design.rest_angle = 0.1;
  design.tendon_friction = 0.1;
  const TentacleLayout layout = LayOut(design).value();
  const RisingFold fold = SolveRisingFold(FoldLaw::kPaper, design, layout, 0.3).value();
  double length = 0;
  for (Eigen::Index i = 0; i < fold.angle.size(); ++i) {
    length += 2 * layout.half_spacing[i] * std::cos(fold.angle[i]);
    EXPECT_NEAR(
        fold.angle[i],
        std::min(0.1 + fold.tension[i] * layout.half_spacing[i] / layout.width[i], design.closed_angle),
        1e-12);
    if (i == 0) continue;
    const double fallen = std::log(fold.tension[i - 1] / fold.tension[i]) / 0.1 - design.wrap_angle;
    EXPECT_GE(fallen, -1e-9);
    EXPECT_LT(fallen, 2);
    // Perpendicular creases fold in one plane: the tendon turns by the difference of the angles.
    TentacleDesign straight = design;
    straight.beta = straight.alpha;
    const RisingFold plane =
        SolveRisingFold(FoldLaw::kPaper, straight, LayOut(straight).value(), 0.3).value();
    EXPECT_NEAR(std::log(plane.tension[i - 1] / plane.tension[i]),
                0.1 * (design.wrap_angle + std::abs(plane.angle[i] - plane.angle[i - 1])), 1e-9);
  }
  EXPECT_NEAR(length, 0.7 * FlatTendonLength(layout), 1e-12);
}

struct Place {
  double pull, rest, friction, ratio, exponent;
  double& operator[](int i) {
    double* const all[] = {&pull, &rest, &friction, &ratio, &exponent};
    return *all[i];
  }
};

TEST(SlopesOf, AgreeWithCentralDifferences) {
  std::mt19937_64 random(11);
  int compared = 0;
  for (int draw = 0; draw < 60; ++draw) {
    TentacleDesign design = RandomDesign(random);
    const FoldLaw law = draw % 2 == 0 ? FoldLaw::kPaper : FoldLaw::kExact;
    const TentacleLayout flat = LayOut(design).value();
    Eigen::MatrixXd directions(flat.width.size(), 2);
    directions.col(0).setZero();
    for (Eigen::Index i = 1; i < flat.width.size(); i += 2) directions(i, 0) = 1;
    directions.col(1) = (flat.width.array() / design.base_width).log().matrix();
    const auto fold = [&](Place p) {
      design.rest_angle = p.rest;
      design.tendon_friction = p.friction;
      TentacleLayout at = flat;
      at.stiffness = (directions * Eigen::Vector2d(p.ratio, p.exponent)).array().exp();
      return SolveRisingFold(law, design, at, p.pull).value();
    };
    const Place at{Uniform(random, 0.12, 0.4), Uniform(random, 0.05, 0.2), Uniform(random, 0.01, 0.2),
                   Uniform(random, -0.5, 0.5), Uniform(random, 0, 2)};
    const RisingFold here = fold(at);
    design.rest_angle = at.rest;
    design.tendon_friction = at.friction;
    TentacleLayout layout = flat;
    layout.stiffness = (directions * Eigen::Vector2d(at.ratio, at.exponent)).array().exp();
    const RisingSlopes slopes = SlopesOf(law, design, layout, here, directions);
    for (int k = 0; k < 5; ++k) {
      Place low = at, high = at;
      low[k] -= 1e-6;
      high[k] += 1e-6;
      const RisingFold a = fold(low), b = fold(high);
      if (a.closed != b.closed || (a.tension[0] > 0) != (b.tension[0] > 0)) continue;
      const Eigen::VectorXd numeric = (b.angle - a.angle) / 2e-6;
      const Eigen::VectorXd slope = k == 0   ? slopes.pull
                                    : k == 1 ? slopes.rest_angle
                                    : k == 2 ? slopes.friction
                                             : Eigen::VectorXd(slopes.stiffness.col(k - 3));
      EXPECT_LT((numeric - slope).cwiseAbs().maxCoeff(), 2e-5 * (1 + numeric.cwiseAbs().maxCoeff()))
          << "draw " << draw << " direction " << k;
      ++compared;
    }
  }
  EXPECT_GT(compared, 250);
}

TEST(SolveRisingFold, ExtremesAreFinite) {
  for (const FoldLaw law : {FoldLaw::kPaper, FoldLaw::kExact}) {
    for (const double rest : {0.0, 0.2}) {
      for (const double friction : {0.0, 0.3, 5.0}) {
        TentacleDesign design;
        design.rest_angle = rest;
        design.tendon_friction = friction;
        const TentacleLayout layout = LayOut(design).value();
        const double largest = LargestPullOf(law, layout, design.closed_angle);
        for (const double pull : {0.0, 1e-12, 0.01, 0.3, 0.999 * largest, largest}) {
          const auto fold = SolveRisingFold(law, design, layout, pull);
          ASSERT_TRUE(fold.ok()) << fold.error().message;
          EXPECT_TRUE(fold.value().angle.allFinite());
          EXPECT_GE(fold.value().angle.minCoeff(), rest);
          const RisingSlopes slopes =
              SlopesOf(law, design, layout, fold.value(), Eigen::MatrixXd::Ones(layout.width.size(), 1));
          EXPECT_TRUE(slopes.pull.allFinite() && slopes.rest_angle.allFinite() &&
                      slopes.friction.allFinite() && slopes.stiffness.allFinite())
              << NameOf(law) << " rest " << rest << " friction " << friction << " pull " << pull;
        }
        EXPECT_EQ(SolveRisingFold(law, design, layout, 1.01).error().kind, ErrorKind::kUnreachable);
      }
    }
  }
  TentacleDesign design;
  design.rest_angle = -0.1;
  EXPECT_EQ(SolveRisingFold(FoldLaw::kPaper, design, LayOut(design).value(), 0.1).error().kind,
            ErrorKind::kBadInput);
}

}  // namespace
}  // namespace tendril
