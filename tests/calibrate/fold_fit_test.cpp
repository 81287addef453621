// calibrate/fold/fold_fit.h: exact recovery, what cannot be identified, outliers, bad input, standard errors.
#include "calibrate/fold/fold_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "calibrate/student_t.h"
#include "tests/support/perturbed_tentacle.h"

namespace tendril {
namespace {

using test::FoldTruth;
using test::kExactly;
using test::kNoiseless;
using test::Random;
using ::testing::HasSubstr;

constexpr FoldTruth kTruth{0.93, 1.4, 1.3};

TentacleDesign Short() {
  TentacleDesign d;
  d.length = 0.32;
  d.holes = 21;
  return d;
}

std::vector<FoldObservation> Trials(int count, const TentacleDesign& design, const FoldTruth& truth,
                                    const test::Perturbation& how, const test::TrackerNoise& noise,
                                    const test::TrialPlan& plan = {.tentacles = 2}, std::uint64_t seed = 1) {
  std::vector<FoldObservation> observations;
  for (int trial = 0; trial < count; ++trial) {
    Random random(seed + static_cast<std::uint64_t>(trial));
    test::AddTrial("trial-" + std::to_string(trial), design, truth, plan, how, noise, random, observations);
  }
  return observations;
}

// Delays and rates are not logged in these trials.
FoldFitOptions Patient() {
  FoldFitOptions options;
  options.longest_lag = 1.5;
  return options;
}

Result<FoldFit> Fit(std::span<const FoldObservation> observations) {
  return FitFold(observations, Patient());
}

test::Perturbation LateOnly() {
  test::Perturbation how = kExactly;
  how.delay = 0.5;
  how.rate = 0.001875;
  return how;
}

void ExpectTruth(const FoldFit& fit, const FoldTruth& truth, double within) {
  EXPECT_NEAR(fit.parameters[0].value, truth.pull_scale, within);
  EXPECT_NEAR(fit.parameters[1].value, truth.stiffness_ratio, within);
  EXPECT_NEAR(fit.parameters[2].value, truth.stiffness_exponent, within);
}

TEST(FitFold, RecoversExactShapesWhateverTheLag) {
  for (const ShapeResidualKind kind :
       {ShapeResidualKind::kAlignedWindows, ShapeResidualKind::kLocalDistances}) {
    for (const FoldTruth& truth : {kTruth, FoldTruth{1.1, 0.5, 0.2}, FoldTruth{0.7, 3, 2}}) {
      FoldFitOptions options = Patient();
      options.residual.kind = kind;
      const auto fit = FitFold(Trials(2, Short(), truth, LateOnly(), kNoiseless), options);
      ASSERT_TRUE(fit.ok()) << fit.error().message;
      ExpectTruth(fit.value(), truth, 1e-8);
      EXPECT_LT(fit.value().residual_rms, 1e-9);
      EXPECT_TRUE(fit.value().converged) << fit.value().message;
      for (const FittedParameter& p : fit.value().parameters)
        EXPECT_TRUE(p.identified) << p.name << ": " << p.why;
    }
  }
}

TEST(FitFold, FindsALagPerTentacleWhenTheCommandNeverStandsStill) {
  test::Perturbation late = kExactly;
  late.delay = 0.5;
  const auto fit = Fit(Trials(2, Short(), kTruth, late, kNoiseless, {.tentacles = 2, .duration = 9.9}));
  ASSERT_TRUE(fit.ok()) << fit.error().message;
  ExpectTruth(fit.value(), kTruth, 1e-7);
}

TEST(FitFold, ClosedCreasesAreNoObstacle) {
  TentacleDesign design = Short();
  design.closed_angle = 0.8;  // reach .30: many creases close
  const auto fit =
      Fit(Trials(2, design, {0.95, 1.2, 1.1}, kExactly, kNoiseless, {.tentacles = 2, .pull = 0.25}));
  ASSERT_TRUE(fit.ok()) << fit.error().message;
  ExpectTruth(fit.value(), {0.95, 1.2, 1.1}, 1e-7);
}

TEST(FitFold, NamesTheExponentWithoutTaper) {
  TentacleDesign design = Short();
  design.taper = 1;
  design.stiffness_exponent = 1.7;
  const auto fit = Fit(Trials(2, design, {0.93, 1.4, 1.7}, {}, {}));
  ASSERT_TRUE(fit.ok()) << fit.error().message;
  const FittedParameter& exponent = fit.value().parameters[2];
  EXPECT_FALSE(exponent.identified);
  EXPECT_THAT(exponent.why, HasSubstr("do not taper"));
  EXPECT_EQ(exponent.value, 1.7);
  EXPECT_TRUE(std::isnan(exponent.standard_error));
  EXPECT_TRUE(fit.value().parameters[0].identified);
  EXPECT_TRUE(fit.value().parameters[1].identified);
  ASSERT_FALSE(fit.value().warnings.empty());
  EXPECT_THAT(fit.value().warnings[0], HasSubstr("stiffness_exponent"));
}

TEST(FitFold, NamesEverythingAtPullZero) {
  const auto fit = Fit(Trials(3, Short(), kTruth, {}, {}, {.tentacles = 1, .duration = 0}));
  ASSERT_TRUE(fit.ok()) << fit.error().message;
  for (const FittedParameter& p : fit.value().parameters) {
    EXPECT_FALSE(p.identified) << p.name;
    EXPECT_THAT(p.why, HasSubstr("pull is 0"));
  }
}

TEST(FitFold, NamesThePullWhenLagsHideIt) {
  auto observations = Trials(3, Short(), kTruth, {}, {}, {.tentacles = 1});
  for (FoldObservation& o : observations) o.settled_for = o.steady_for = 0;
  const auto fit = Fit(observations);
  ASSERT_TRUE(fit.ok()) << fit.error().message;
  EXPECT_FALSE(fit.value().parameters[0].identified);
  EXPECT_THAT(fit.value().parameters[0].why, HasSubstr("lag"));
  EXPECT_TRUE(fit.value().parameters[1].identified);
}

TEST(FitFold, NamesTheRatioOfASingleCrease) {
  TentacleDesign design;
  design.length = 0.03;
  design.holes = 2;
  auto observations = Trials(3, design, {0.9, 1, 1}, kExactly, kNoiseless, {.tentacles = 1});
  const auto fit = Fit(observations);
  ASSERT_FALSE(fit.ok());  // two nodes have no shape but a length
  EXPECT_THAT(fit.error().message, HasSubstr("2 of 2 nodes seen; 6 are needed"));
}

TEST(FitFold, SaturationLeavesNothingToTell) {
  TentacleDesign design = Short();
  design.closed_angle = 0.8;
  const double reach = 1 - std::cos(0.8);
  auto observations =
      Trials(3, design, {1, 1, 1}, kExactly, kNoiseless,
             {.tentacles = 1, .pull = reach * (1 - 1e-9), .pull_rate = 0.1, .duration = 13.2});
  std::erase_if(observations, [](const FoldObservation& o) { return o.time < 10; });
  const auto fit = Fit(observations);
  ASSERT_TRUE(fit.ok()) << fit.error().message;
  EXPECT_FALSE(fit.value().parameters[1].identified);
  EXPECT_FALSE(fit.value().parameters[2].identified);
}

TEST(FitFold, LeavesOutFramesThatNoFoldExplains) {
  auto observations = Trials(3, Short(), kTruth, LateOnly(), kNoiseless);
  Random random(5);
  for (const std::size_t bad : {std::size_t{4}, std::size_t{20}}) {
    for (Eigen::Index i = 0; i < observations[bad].curve.points.cols(); ++i) {
      observations[bad].curve.points.col(i) =
          Eigen::Vector3d(test::Normal(random, 0.05), test::Normal(random, 0.05), 0);
    }
  }
  const auto fit = Fit(observations);
  ASSERT_TRUE(fit.ok()) << fit.error().message;
  ExpectTruth(fit.value(), kTruth, 1e-7);
  ASSERT_EQ(fit.value().left_out.size(), 2U);
  EXPECT_EQ(fit.value().left_out[0].observation, 4U);
  EXPECT_EQ(fit.value().left_out[1].observation, 20U);
  EXPECT_THAT(fit.value().left_out[0].reason, HasSubstr("times as far"));
}

TEST(FitFold, ASingleWildNodeHardlyMatters) {
  auto observations = Trials(3, Short(), kTruth, LateOnly(), kNoiseless);
  for (std::size_t i = 0; i < observations.size(); i += 4) {
    observations[i].curve.points.col(7) += Eigen::Vector3d(0.02, -0.01, 0.01);
  }
  const auto fit = Fit(observations);
  ASSERT_TRUE(fit.ok()) << fit.error().message;
  ExpectTruth(fit.value(), kTruth, 0.02);
}

TEST(FitFold, InterpolatedAndUnseenNodesDoNotCount) {
  auto observations = Trials(2, Short(), kTruth, LateOnly(), kNoiseless);
  for (std::size_t i = 0; i < observations.size(); ++i) {
    FoldObservation& o = observations[i];
    o.curve.points.col(9).setConstant(0.5);
    o.interpolated[9] = 1;
    o.curve.points.col(3).setConstant(std::nan(""));
    o.curve.points.col(12).setConstant(0.7);
    o.sigma[12] = std::nan("");
    if (i == 2) o.curve.points.setConstant(std::nan(""));
    if (i == 3) o.commanded_pull = std::nan("");
    if (i == 4) o.commanded_pull = 2;
  }
  const auto fit = Fit(observations);
  ASSERT_TRUE(fit.ok()) << fit.error().message;
  ExpectTruth(fit.value(), kTruth, 1e-7);
  ASSERT_EQ(fit.value().left_out.size(), 3U);
  EXPECT_THAT(fit.value().left_out[0].reason, HasSubstr("0 of 21 nodes seen"));
  EXPECT_THAT(fit.value().left_out[1].reason, HasSubstr("commanded pull nan"));
  EXPECT_THAT(fit.value().left_out[2].reason, HasSubstr("beyond the design's reach"));
}

TEST(FitFold, OneTrialSaysThatItsErrorsAreTooSmall) {
  const auto fit = Fit(Trials(1, Short(), kTruth, {}, {}));
  ASSERT_TRUE(fit.ok()) << fit.error().message;
  EXPECT_FALSE(fit.value().clustered);
  EXPECT_EQ(fit.value().trials, 1);
  EXPECT_TRUE(fit.value().covariance.allFinite());
  EXPECT_THAT(fit.value().warnings, ::testing::Contains(HasSubstr("one trial only")));
  const auto two = Fit(Trials(2, Short(), kTruth, {}, {}));
  ASSERT_TRUE(two.ok()) << two.error().message;
  EXPECT_THAT(two.value().warnings, ::testing::Contains(HasSubstr("2 trials only")));
}

TEST(FitFold, BadCallsSayWhatTheyNeed) {
  EXPECT_THAT(Fit({}).error().message, HasSubstr("no observed curves"));
  auto observations = Trials(1, Short(), kTruth, kExactly, kNoiseless);
  observations[1].curve.points.resize(3, 5);
  const auto wrong = Fit(observations);
  ASSERT_FALSE(wrong.ok());
  EXPECT_EQ(wrong.error().kind, ErrorKind::kBadInput);
  EXPECT_THAT(wrong.error().message, HasSubstr("5 nodes; expected one per hole of its design, 21"));

  FoldFitOptions options = Patient();
  options.huber = 0;
  EXPECT_THAT(FitFold(Trials(1, Short(), kTruth, kExactly, kNoiseless), options).error().message,
              HasSubstr("huber"));
  options = Patient();
  options.residual.model_error = std::nan("");
  EXPECT_THAT(FitFold(Trials(1, Short(), kTruth, kExactly, kNoiseless), options).error().message,
              HasSubstr("model_error"));
}

TEST(FitFold, StopsWhenAsked) {
  const auto fit = FitFold(Trials(1, Short(), kTruth, {}, {}), {}, [](double) { return false; });
  ASSERT_FALSE(fit.ok());
  EXPECT_EQ(fit.error().kind, ErrorKind::kStopped);
}

TEST(FitFold, ScalesWithTheTentacle) {
  // A tentacle a hundred times as large, noise and tolerances alike: the same numbers.
  const auto plain = Trials(2, Short(), kTruth, {}, {});
  auto large = plain;
  for (FoldObservation& o : large) {
    o.design.length *= 100;
    o.design.base_width *= 100;
    o.design.unit_length *= 100;
    o.curve.points *= 100;
    o.sigma *= 100;
  }
  FoldFitOptions options = Patient();
  options.residual.model_error *= 100;
  const auto a = Fit(plain);
  const auto b = FitFold(large, options);
  ASSERT_TRUE(a.ok() && b.ok());
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(a.value().parameters[i].value, b.value().parameters[i].value, 1e-6);
    EXPECT_NEAR(a.value().parameters[i].standard_error, b.value().parameters[i].standard_error, 1e-5);
  }
}

// The clustered error of pull_scale is that of the trials' own estimates: the t statistic of a mean, when the
// trials weigh alike. Another route to the same number.
TEST(FitFold, ClusteredErrorsAgreeWithTheSpreadOfFitsTrialByTrial) {
  const int trials = 10;
  const auto together = Fit(Trials(trials, Short(), kTruth, {}, {}));
  ASSERT_TRUE(together.ok());
  Eigen::MatrixXd apart(trials, 3);
  for (int trial = 0; trial < trials; ++trial) {
    const auto one =
        Fit(Trials(1, Short(), kTruth, {}, {}, {.tentacles = 2}, 1 + static_cast<std::uint64_t>(trial)));
    ASSERT_TRUE(one.ok());
    for (int i = 0; i < 3; ++i) apart(trial, i) = one.value().parameters[static_cast<std::size_t>(i)].value;
  }
  for (int i = 0; i < 3; ++i) {
    const Eigen::ArrayXd column = apart.col(i).array();
    const double error = std::sqrt((column - column.mean()).square().sum() / (trials - 1) / trials);
    const FittedParameter& p = together.value().parameters[static_cast<std::size_t>(i)];
    EXPECT_NEAR(p.value, column.mean(), 1.0 * error) << p.name;
    EXPECT_NEAR(p.standard_error, error, 0.35 * error) << p.name;
  }
}

TEST(FitFold, ConfidenceWidensTheInterval) {
  const auto observations = Trials(4, Short(), kTruth, {}, {});
  FoldFitOptions options = Patient();
  options.confidence = 0.99;
  const auto fit = FitFold(observations, options);
  ASSERT_TRUE(fit.ok());
  const FittedParameter& p = fit.value().parameters[0];
  EXPECT_EQ(fit.value().degrees_of_freedom, 3);
  EXPECT_NEAR(p.interval.high - p.value, 5.841 * p.standard_error, 1e-3 * p.standard_error);
}

}  // namespace
}  // namespace tendril
