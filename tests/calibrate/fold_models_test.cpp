// calibrate/fold: models beyond the paper's law on shapes that are exactly a model's, their comparison,
// profiles and the hint for the next pull.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "calibrate/fold/fold_compare.h"
#include "calibrate/fold/fold_profile.h"
#include "calibrate/fold/held_out.h"
#include "model/fold/facet_chain.h"
#include "model/fold/tendon_friction.h"
#include "tests/support/perturbed_tentacle.h"

namespace tendril {
namespace {

using ::testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180;

TentacleDesign Short() {
  TentacleDesign d;
  d.length = 0.32;
  d.holes = 21;
  return d;
}

struct Truth {
  FoldLaw law = FoldLaw::kPaper;
  double rest_angle = 0;
  double friction = 0;
};

// Held at three pulls each; scatter is the trial's own stiffness.
std::vector<FoldObservation> Trials(int count, const Truth& truth, double scatter, double noise,
                                    std::uint64_t seed = 1,
                                    const std::vector<double>& pulls = {0.0, 0.1, 0.2, 0.3}) {
  std::vector<FoldObservation> observations;
  for (int trial = 0; trial < count; ++trial) {
    test::Random random(seed + static_cast<std::uint64_t>(trial));
    TentacleDesign design = Short();
    design.rest_angle = truth.rest_angle;
    design.tendon_friction = truth.friction;
    design.stiffness_ratio = 1.3;
    design.stiffness_exponent = 1.2;
    TentacleLayout layout = LayOut(design).value();
    for (Eigen::Index i = 0; i < layout.stiffness.size(); ++i) {
      layout.stiffness[i] *= std::exp(test::Normal(random, scatter));
    }
    for (const double pull : pulls) {
      const Eigen::VectorXd angle = SolveRisingFold(truth.law, design, layout, 0.95 * pull).value().angle;
      FoldObservation o;
      o.trial = "trial-" + std::to_string(trial);
      o.design = Short();
      o.time = 10 * pull;
      o.commanded_pull = pull;
      test::Observe(TendonCurveOf(layout, FoldChain(layout, angle), angle).holes, {noise, 0, 8, 0, 0}, random,
                    o);
      observations.push_back(o);
    }
  }
  return observations;
}

TEST(FitFoldModels, RecoversExactShapesOfEveryModel) {
  for (const FoldModel& model : ComparableFoldModels()) {
    const Truth truth{model.law, model.rest_angle ? 10 * kDegree : 0, model.friction ? 0.05 : 0};
    FoldFitOptions options;
    options.model = model;
    const auto fit = FitFold(Trials(2, truth, 0, 0), options);
    ASSERT_TRUE(fit.ok()) << NameOf(model) << ": " << fit.error().message;
    ASSERT_EQ(static_cast<int>(fit.value().parameters.size()), model.parameters());
    const std::map<std::string, double> wanted = {{"pull_scale", 0.95},
                                                  {"stiffness_ratio", 1.3},
                                                  {"stiffness_exponent", 1.2},
                                                  {"rest_angle_deg", 10},
                                                  {"friction", 0.05}};
    for (const FittedParameter& p : fit.value().parameters) {
      // Without a rest angle law exact leaves the short creases flat at these pulls: nothing tells of them.
      if (model == FoldModel{FoldLaw::kExact, false, false} && p.name == "stiffness_ratio") {
        EXPECT_FALSE(p.identified);
        EXPECT_FALSE(p.why.empty());
        continue;
      }
      EXPECT_TRUE(p.identified) << NameOf(model) << " " << p.name << ": " << p.why;
      EXPECT_NEAR(p.value, wanted.at(p.name), 0.01 * wanted.at(p.name)) << NameOf(model) << " " << p.name;
    }
    EXPECT_LT(fit.value().residual_rms, 2e-5) << NameOf(model);
  }
}

TEST(FitFoldModels, ExtremesNeverGiveAValueThatIsNotANumber) {
  for (const FoldModel& model : ComparableFoldModels()) {
    auto observations = Trials(3, {}, 0, 1e-4);
    std::erase_if(observations, [](const FoldObservation& o) { return o.commanded_pull > 0; });
    FoldFitOptions options;
    options.model = model;
    const auto flat = FitFold(observations, options);
    ASSERT_TRUE(flat.ok()) << flat.error().message;
    for (const FittedParameter& p : flat.value().parameters) {
      EXPECT_TRUE(std::isfinite(p.value)) << NameOf(model) << " " << p.name;
      if (p.name != "rest_angle_deg") {  // which the flat shapes do tell
        EXPECT_FALSE(p.identified) << NameOf(model) << " " << p.name;
        EXPECT_FALSE(p.why.empty());
      }
    }
    const auto one = FitFold(Trials(1, {}, 0.02, 1e-4), options);
    ASSERT_TRUE(one.ok());
    for (const FittedParameter& p : one.value().parameters) EXPECT_TRUE(std::isfinite(p.value)) << p.name;
  }
}

TEST(FitFoldModels, FrictionLeavesOutCurvesAfterARelease) {
  auto observations = Trials(2, {}, 0.02, 1e-4);
  observations[3].released = true;
  FoldFitOptions options;
  options.model = {FoldLaw::kPaper, false, true};
  const auto fit = FitFold(observations, options);
  ASSERT_TRUE(fit.ok());
  ASSERT_EQ(fit.value().left_out.size(), 1U);
  EXPECT_THAT(fit.value().left_out[0].reason, HasSubstr("gone back"));
}

TEST(CompareFoldModels, FindsTheTrueModelAndSaysSo) {
  FoldComparisonOptions options;
  options.models = {{FoldLaw::kPaper, false, false},
                    {FoldLaw::kExact, false, false},
                    {FoldLaw::kPaper, true, false},
                    {FoldLaw::kExact, true, false}};
  for (const Truth& truth : {Truth{}, Truth{FoldLaw::kExact, 12 * kDegree, 0}}) {
    const auto compared = CompareFoldModels(Trials(6, truth, 0.03, 2e-4), options);
    ASSERT_TRUE(compared.ok()) << compared.error().message;
    const FoldComparison& c = compared.value();
    ASSERT_GE(c.chosen, 0);
    const FoldModel& chosen = c.models[static_cast<std::size_t>(c.chosen)].model;
    EXPECT_EQ(NameOf(chosen), truth.law == FoldLaw::kPaper ? "paper" : "exact+rest_angle");
    ASSERT_FALSE(c.verdict.empty());
    EXPECT_THAT(c.verdict,
                ::testing::Contains(HasSubstr(truth.law == FoldLaw::kPaper ? "a rest angle is not needed"
                                                                           : "a rest angle is needed")));
  }
}

TEST(CompareFoldModels, WithOneTrialAicDoesNotDependOnTheUnitOfSigma) {
  FoldComparisonOptions options;
  options.models = {{FoldLaw::kPaper, false, false}, {FoldLaw::kExact, true, false}};
  std::vector<double> behind;
  for (const double factor : {2.0, 4.0}) {  // narrower ones do not identify the scatters, which is a choice
    auto observations = Trials(1, {}, 0.03, 2e-4);
    for (FoldObservation& o : observations) o.sigma *= factor;
    options.fit.residual.model_error = factor * 0.3e-3;
    const auto compared = CompareFoldModels(observations, options);
    ASSERT_TRUE(compared.ok()) << compared.error().message;
    EXPECT_EQ(compared.value().trials, 1);
    double most = 0;
    for (const ComparedModel& m : compared.value().models) most = std::max(most, m.aic_difference);
    behind.push_back(most);
  }
  EXPECT_GT(behind[0], 2);
  EXPECT_NEAR(behind[1], behind[0], 0.02 * behind[0]);
}

TEST(CompareFoldModels, WithOneTrialNothingIsSaidOfHeldOutOnes) {
  FoldComparisonOptions options;
  options.models = {
      {FoldLaw::kPaper, false, false}, {FoldLaw::kExact, true, false}, {FoldLaw::kPaper, false, true}};
  const auto compared = CompareFoldModels(Trials(1, {FoldLaw::kExact, 12 * kDegree, 0}, 0, 2e-4), options);
  ASSERT_TRUE(compared.ok()) << compared.error().message;
  EXPECT_TRUE(compared.value().models[2].fit.has_value()) << compared.value().models[2].why_not;
  for (const std::string& line : compared.value().verdict) EXPECT_EQ(line.find("on held-out"), line.npos);
  const auto& chosen = compared.value().models[static_cast<std::size_t>(compared.value().chosen)];
  EXPECT_TRUE(chosen.fit->hint.has_value());
}

// The last trial hangs on one curve, near the reach of one law: what the others say of the pull may put it
// out.
TEST(CompareFoldModels, ACurveThatOneModelCannotReachWhenHeldOutCountsForNone) {
  const TentacleLayout layout = LayOut(Short()).value();
  const double paper = LargestPullOf(FoldLaw::kPaper, layout, Short().closed_angle);
  const double exact = LargestPullOf(FoldLaw::kExact, layout, Short().closed_angle);
  FoldComparisonOptions options;
  options.fit.start_pull_scale = 0.95;
  options.models = {{FoldLaw::kPaper, false, false}, {FoldLaw::kExact, true, false}};
  int out_of_reach = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    auto observations = Trials(4, {}, 0.1, 2e-3, 10 * seed);
    for (FoldObservation o :
         Trials(1, {}, 0.1, 2e-3, 10 * seed + 9, {0.998 * std::min(paper, exact) / 0.95})) {
      o.trial = "near";
      observations.push_back(std::move(o));
    }
    const auto compared = CompareFoldModels(observations, options);
    ASSERT_TRUE(compared.ok()) << compared.error().message;
    const auto& models = compared.value().models;
    ASSERT_TRUE(models[0].fit && models[1].fit) << models[0].why_not << models[1].why_not;
    EXPECT_EQ(models[0].held_out_by_trial.size(), models[1].held_out_by_trial.size());
    out_of_reach += models[0].held_out_by_trial.size() == 4 ? 1 : 0;
  }
  EXPECT_GT(out_of_reach, 0);
}

// The other route: the fit made again without each trial.
TEST(HeldOut, FirstOrderParametersAgreeWithRefits) {
  const auto all = Trials(6, {}, 0.03, 2e-4);
  const FoldFitOptions options;
  const FitRun run = RunFit(all, options, {}).value();
  for (std::size_t trial = 0; trial < 6; ++trial) {
    auto others = all;
    std::erase_if(others, [&](const FoldObservation& o) { return o.trial == run.frames.trials[trial]; });
    const FitRun again = RunFit(others, options, {}).value();
    const SharedVector predicted = ParametersWithout(run, trial);
    for (int i = 0; i < 3; ++i) {
      const double error = std::sqrt(ClusteredCovariance(run.information, run.held)(i, i));
      EXPECT_NEAR(predicted[i], again.solution.parameters[i], 0.2 * error) << "trial " << trial << " " << i;
    }
  }
}

TEST(ProfileFold, AgreesWithTheStandardErrorWhereTheCostIsAParabola) {
  const auto profile = ProfileFold(Trials(6, {}, 0.03, 2e-4), {}, "stiffness_exponent");
  ASSERT_TRUE(profile.ok()) << profile.error().message;
  const FittedParameter& p = profile.value().fit.parameters[2];
  EXPECT_NEAR(profile.value().interval.low, p.interval.low, 0.15 * (p.value - p.interval.low));
  EXPECT_NEAR(profile.value().interval.high, p.interval.high, 0.15 * (p.interval.high - p.value));
}

TEST(ProfileFold, FrictionThatIsNotThereHasAnIntervalFromZero) {
  FoldFitOptions options;
  options.model = {FoldLaw::kPaper, false, true};
  const auto profile = ProfileFold(Trials(6, {}, 0.03, 2e-4), options, "friction");
  ASSERT_TRUE(profile.ok()) << profile.error().message;
  EXPECT_LE(profile.value().interval.low, 1e-3);
  EXPECT_GT(profile.value().interval.high, 0);
  const auto none = ProfileFold(Trials(6, {}, 0.03, 2e-4), options, "rest_angle_deg");
  ASSERT_FALSE(none.ok());
  EXPECT_THAT(none.error().message, HasSubstr("has no such parameter"));
}

TEST(ProfileFold, EndsWhereAFrameWouldBeOutOfReach) {
  const TentacleLayout layout = LayOut(Short()).value();
  const double reach = LargestPullOf(FoldLaw::kPaper, layout, Short().closed_angle);
  FoldFitOptions options;
  options.start_pull_scale = 0.95;
  const auto profile =
      ProfileFold(Trials(3, {}, 0.1, 2e-3, 1, {0.0, 0.1, 0.2, 0.985 * reach / 0.95}), options, "pull_scale");
  ASSERT_TRUE(profile.ok()) << profile.error().message;
  const FoldProfile& p = profile.value();
  EXPECT_LT(p.value.back(), 0.95 / 0.985);
  const auto estimate = std::find(p.deviance.begin(), p.deviance.end(), 0.0);
  ASSERT_NE(estimate, p.deviance.end());
  EXPECT_TRUE(std::is_sorted(estimate, p.deviance.end()));
}

TEST(PullHint, OneMoreTrialThereSharpensAsForetold) {
  const auto fit = FitFold(Trials(6, {}, 0.03, 2e-4));
  ASSERT_TRUE(fit.ok());
  ASSERT_TRUE(fit.value().hint.has_value());
  const PullHint& hint = *fit.value().hint;
  EXPECT_THAT(hint.sentence, HasSubstr(hint.parameter));
  for (const double ratio : hint.error_ratio) {
    EXPECT_GT(ratio, 0);
    EXPECT_LE(ratio, 1);
  }
  // The fold tells more the more it is pulled.
  EXPECT_LT(hint.error_ratio[5], hint.error_ratio[0]);

  // The other route: that trial made, and the fit made again. The hint is of rows as they are, not of their
  // scatter, which the new trial changes too.
  const auto more = Trials(1, {}, 0.03, 2e-4, 7, {hint.best_pull, hint.best_pull, hint.best_pull});
  auto with = Trials(6, {}, 0.03, 2e-4);
  for (FoldObservation o : more) {
    o.trial = "one more";
    with.push_back(std::move(o));
  }
  const FitRun before = RunFit(Trials(6, {}, 0.03, 2e-4), {}, {}).value();
  const FitRun after = RunFit(with, {}, {}).value();
  const auto& names = FoldParameterNames();
  const auto at = std::find(names.begin(), names.end(), hint.parameter) - names.begin();
  const auto error = [&](const FitRun& run) {
    return std::sqrt(NaiveCovariance(run.information, 1, run.held)(at, at));
  };
  const double foretold = *std::min_element(hint.error_ratio.begin(), hint.error_ratio.end());
  EXPECT_NEAR(1 - error(after) / error(before), 1 - foretold, 0.2 * (1 - foretold));
}

}  // namespace
}  // namespace tendril
