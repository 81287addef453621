// The fold fit's intervals on 20 held-out studies of the virtual rig's true shapes with a tracker's noise:
// how many hold the truth, and is the bias small beside the standard error? bench/fold_fit_coverage.cpp
// prints more.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "calibrate/fold/fold_fit.h"
#include "capture/rig/virtual_truth.h"
#include "tests/support/perturbed_tentacle.h"

namespace tendril {
namespace {

constexpr int kStudies = 20;
constexpr int kTrials = 8;
constexpr std::array<double, 3> kTruth = {0.95, 0.8, 1.2};

void AddRigTrial(int trial, test::Random& random, std::vector<FoldObservation>& observations) {
  Gripper gripper;
  gripper.tentacles = 2;
  const auto truth = DrawTruth({}, gripper, {kTruth[0], kTruth[1], kTruth[2]}, {0.3, 0.03}, {}, {}, random);
  ASSERT_TRUE(truth.ok()) << truth.error().message;
  for (int frame = 0; frame < 12; ++frame) {
    FoldObservation o;
    o.trial = std::to_string(trial);
    o.time = 1.2 * frame;
    o.commanded_pull = std::min(0.03 * o.time, 0.3);
    o.settled_for = frame == 0 ? std::numeric_limits<double>::infinity() : std::max(0.0, o.time - 10);
    o.steady_for = frame == 0 ? o.settled_for : o.time > 10 ? o.time - 10 : o.time;
    const auto shape = TrueShapeAt(truth.value(), o.time);
    ASSERT_TRUE(shape.ok()) << shape.error().message;
    for (int tentacle = 0; tentacle < gripper.tentacles; ++tentacle) {
      o.tentacle = tentacle;
      o.design = DesignOfTentacle(gripper, {}, tentacle);
      test::Observe(shape.value().tentacles[static_cast<std::size_t>(tentacle)].centerline.points, {}, random,
                    o);
      observations.push_back(o);
    }
  }
}

TEST(FoldFitCoverage, IntervalsHoldTheTruthOfHeldOutStudies) {
  std::array<int, 3> hits{};
  std::array<double, 3> bias{};
  std::array<double, 3> error{};
  for (int study = 0; study < kStudies; ++study) {
    std::vector<FoldObservation> observations;
    for (int trial = 0; trial < kTrials; ++trial) {
      test::Random random(900'000 + static_cast<std::uint64_t>(100 * study + trial));
      AddRigTrial(trial, random, observations);
    }
    FoldFitOptions options;
    options.longest_lag = 1.5;  // delays and rates are not logged here
    const auto fit = FitFold(observations, options);
    ASSERT_TRUE(fit.ok()) << "study " << study << ": " << fit.error().message;
    EXPECT_EQ(fit.value().degrees_of_freedom, kTrials - 1);
    for (std::size_t i = 0; i < 3; ++i) {
      const FittedParameter& p = fit.value().parameters[i];
      ASSERT_TRUE(p.identified) << "study " << study << ": " << p.name << ": " << p.why;
      hits[i] += p.interval.low <= kTruth[i] && kTruth[i] <= p.interval.high ? 1 : 0;
      bias[i] += (p.value - kTruth[i]) / kStudies;
      error[i] += p.standard_error / kStudies;
    }
  }
  for (std::size_t i = 0; i < 3; ++i) {
    RecordProperty("hits_" + std::to_string(i), hits[i]);
    // Of 20 intervals at 95 %, 16 or fewer hold the truth once in 60 studies of studies.
    EXPECT_GE(hits[i], 17) << "parameter " << i;
    EXPECT_LT(std::abs(bias[i]), 0.75 * error[i]) << "parameter " << i;
  }
}

}  // namespace
}  // namespace tendril
