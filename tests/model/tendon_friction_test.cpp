// model/fold/tendon_friction.h: the capstan's bounds, published angles, loading and release.
#include "model/fold/tendon_friction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "model/fold/exact_law.h"

namespace tendril {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

TentacleDesign Uniform(double friction) {
  TentacleDesign design;
  design.taper = 1;
  design.spacing_ratio = 1;
  design.beta = design.alpha;
  design.tendon_friction = friction;
  design.wrap_angle = 0.1;
  return design;
}

TEST(FrictionTendon, WithoutFrictionItIsTheExactLaw) {
  TentacleDesign design;
  design.tendon_friction = 0;
  FrictionTendon tendon = FrictionTendon::Make(design).value();
  for (const double pull : {0.05, 0.3, 0.6, 0.2, 0.01}) {
    const FrictionFold fold = tendon.MoveTo(pull).value();
    const ExactFold exact = SolveExactFold(design, pull).value();
    EXPECT_LT((fold.angle - exact.angle).cwiseAbs().maxCoeff(), 1e-6) << pull;
    EXPECT_NEAR(fold.tension[0], exact.tension, 1e-9 * exact.tension) << pull;
  }
}

// Published: about 50 degrees at the base, 40 at the tip. Every hole slides, and equal chords do not deflect:
// the tension falls by exp(-mu theta0) from hole to hole.
TEST(FrictionTendon, PullingFoldsTheBaseMore) {
  FrictionTendon tendon = FrictionTendon::Make(Uniform(0.01)).value();
  const FrictionFold fold = tendon.MoveTo(0.3).value();
  EXPECT_NEAR(fold.angle[0] / kDegree, 50, 1);
  EXPECT_NEAR(fold.angle[47] / kDegree, 40, 1);
  for (Eigen::Index i = 1; i < 48; ++i) {
    EXPECT_LT(fold.angle[i], fold.angle[i - 1]);
    EXPECT_LE(fold.tension[i], fold.tension[i - 1] * std::exp(-0.001) * (1 + 1e-12));
  }
  EXPECT_NEAR(fold.tendon_length, 0.7 * 48 * 0.015, 1e-12);
}

TEST(FrictionTendon, APullAndReleaseIsALoopWithoutJumps) {
  double largest[2] = {};
  for (const int refined : {0, 1}) {
    FrictionTendon tendon = FrictionTendon::Make(Uniform(0.01)).value();
    const int steps = refined == 0 ? 60 : 240;
    std::vector<FrictionFold> folds;
    const auto sweep = [&](double from, double to) {
      for (int i = 1; i <= steps; ++i) folds.push_back(tendon.MoveTo(from + (to - from) * i / steps).value());
    };
    sweep(0, 0.3);
    sweep(0.3, 0);
    // At the same pull the base is folded more on the way up, less on the way down.
    const FrictionFold& up = folds[static_cast<std::size_t>(steps / 2 - 1)];
    const FrictionFold& down = folds[static_cast<std::size_t>(steps + steps / 2 - 1)];
    EXPECT_GT(up.angle[0], down.angle[0] + kDegree);
    EXPECT_LT(up.angle[47], down.angle[47] - kDegree);
    EXPECT_GT(up.tension[0], 1.02 * down.tension[0]);
    EXPECT_NEAR(up.tendon_length, down.tendon_length, 1e-12);
    for (std::size_t i = 1; i < folds.size(); ++i) {
      largest[refined] =
          std::max(largest[refined], (folds[i].angle - folds[i - 1].angle).cwiseAbs().maxCoeff());
    }
  }
  // A crease starts as a square root and the number of folded ones as another: a quarter of the step moves
  // the first ones by 4^(-1/4) of what the whole did. A jump would stay.
  EXPECT_NEAR(largest[1] / largest[0], std::pow(0.25, 0.25), 0.05);
}

TEST(FrictionTendon, EasingThePullALittleMovesOnlyTheBase) {
  FrictionTendon tendon = FrictionTendon::Make(Uniform(0.01)).value();
  const FrictionFold pulled = tendon.MoveTo(0.3).value();
  const FrictionFold eased = tendon.MoveTo(0.299).value();
  // (At the tip all that changes is the deflection at the holes, and with it the friction, a little.)
  EXPECT_NEAR(eased.angle[47], pulled.angle[47], 1e-4);
  EXPECT_LT(eased.angle[0], pulled.angle[0] - 0.01);
}

TEST(FrictionTendon, ReleasedWhollyItIsFlatAgain) {
  FrictionTendon tendon = FrictionTendon::Make(Uniform(0.02)).value();
  ASSERT_TRUE(tendon.MoveTo(0.25).ok());
  const FrictionFold fold = tendon.MoveTo(0).value();
  EXPECT_EQ(fold.angle.maxCoeff(), 0);
  EXPECT_EQ(tendon.MoveTo(2).error().kind, ErrorKind::kUnreachable);
  EXPECT_EQ(tendon.MoveTo(-1).error().kind, ErrorKind::kBadInput);
  EXPECT_TRUE(tendon.MoveTo(0.1).ok());
}

// Pulled and partly released, so that holes slide either way and some stick: against differences of the whole
// history. Pulls lie between steps of 0.01, so that a changed pull takes as many.
TEST(FrictionTendon, SlopesAreTheDifferencesLimit) {
  TentacleDesign oblique;
  oblique.holes = 21;
  oblique.length = 0.33;
  oblique.taper = 0.8;
  oblique.spacing_ratio = 0.9;
  oblique.alpha = 1.8;
  oblique.stiffness_ratio = 0.8;
  oblique.rest_angle = 0.15;
  oblique.tendon_friction = 0.05;
  TentacleDesign slender = Uniform(0.02);
  slender.holes = 21;
  slender.length = 0.33;
  slender.taper = 0.95;
  struct Parameter {
    const char* name;
    double TentacleDesign::*of_design;  // null: the pull
    double DesignChange::*of_change;
  };
  const std::vector<Parameter> parameters = {
      {"friction", &TentacleDesign::tendon_friction, &DesignChange::tendon_friction},
      {"wrap angle", &TentacleDesign::wrap_angle, &DesignChange::wrap_angle},
      {"taper", &TentacleDesign::taper, &DesignChange::taper},
      {"spacing ratio", &TentacleDesign::spacing_ratio, &DesignChange::spacing_ratio},
      {"alpha", &TentacleDesign::alpha, &DesignChange::alpha},
      {"stiffness ratio", &TentacleDesign::stiffness_ratio, &DesignChange::stiffness_ratio},
      {"pull", nullptr, &DesignChange::pull}};
  for (const TentacleDesign& design : {oblique, slender}) {
    for (const std::vector<double>& path : {std::vector<double>{0.295}, {0.295, 0.225}}) {
      for (const Parameter& parameter : parameters) {
        if (parameter.of_design == nullptr && path.size() > 1) continue;
        DesignChange change;
        change.*parameter.of_change = 1;
        FrictionTendon tendon = FrictionTendon::Make(design).value();
        tendon.Follow(change);
        FrictionFold fold;
        for (const double pull : path) fold = tendon.MoveTo(pull).value();
        const auto at = [&](double h) {
          TentacleDesign changed = design;
          if (parameter.of_design != nullptr) changed.*parameter.of_design += h;
          FrictionTendon moved = FrictionTendon::Make(changed).value();
          FrictionFold end;
          for (const double pull : path) {
            end = moved.MoveTo(pull + (parameter.of_design == nullptr ? h : 0)).value();
          }
          return end.angle;
        };
        const double h = 1e-5;
        const Eigen::VectorXd expected = (at(h) - at(-h)) / (2 * h);
        EXPECT_LE((fold.angle_slope - expected).norm(), 2e-5 * expected.norm() + 1e-7)
            << parameter.name << ", taper " << design.taper << ", moves " << path.size();
      }
    }
  }
}

}  // namespace
}  // namespace tendril
