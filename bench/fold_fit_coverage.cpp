// How often do the fold fit's intervals hold the truth? Draws studies (trials of one design, true shapes from
// the virtual rig, a fast model of the tracker's noise, no video), fits each, and prints bias, spread, mean
// standard error and coverage of each parameter, with and without each way in which a tentacle differs from
// the model, and for several residuals.
//
//   bench_fold_fit_coverage [studies] [trials] [first seed] [part of a case's name] [part of a residual's
//   name]

#include <fmt/core.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "calibrate/fold/fold_fit.h"
#include "capture/rig/virtual_truth.h"
#include "tests/support/perturbed_tentacle.h"

namespace tendril::test {
namespace {

struct Case {
  std::string name;
  TruthRanges ranges;
  TrackerNoise noise;
  TrialPlan plan;
  TentacleDesign design;
  bool own_shapes = false;  // the tests' generator in place of the virtual rig's
};

std::vector<Case> Cases() {
  const Case all{"everything", {}, {}, {}, {}};
  std::vector<Case> cases{all};
  const auto add = [&](const char* name, const auto& change) {
    cases.push_back(all);
    cases.back().name = name;
    change(cases.back());
  };
  add("shapes exact, tracker noise", [](Case& c) {
    c.ranges.position_sd = c.ranges.crease_angle_sd = c.ranges.stiffness_sd = 0;
    c.ranges.facet_bend_sd = c.ranges.largest_sag_compliance = 0;
    c.ranges.largest_delay = c.ranges.rate_perturbation = 0;
  });
  add("no tracker noise", [](Case& c) { c.noise = kNoiseless; });
  add("no sag", [](Case& c) { c.ranges.largest_sag_compliance = 0; });
  add("no bending", [](Case& c) { c.ranges.facet_bend_sd = 0; });
  add("no delays", [](Case& c) { c.ranges.largest_delay = c.ranges.rate_perturbation = 0; });
  add("holes and creases in place", [](Case& c) { c.ranges.position_sd = c.ranges.crease_angle_sd = 0; });
  add("no stiffness noise", [](Case& c) { c.ranges.stiffness_sd = 0; });
  add("frames of the ramp only", [](Case& c) { c.plan.duration = 9.9; });
  add("half the pull", [](Case& c) { c.plan.pull = 0.15; });
  add("twice the tracker noise", [](Case& c) {
    c.noise.alone *= 2;
    c.noise.along *= 2;
  });
  add("creases at 90 deg", [](Case& c) { c.design.beta = c.design.alpha; });
  add("the tests' own shapes", [](Case& c) { c.own_shapes = true; });
  return cases;
}

void AddRigTrial(const std::string& name, const FoldTruth& truth, const Case& one, Random& random,
                 std::vector<FoldObservation>& observations) {
  Gripper gripper;
  gripper.tentacles = one.plan.tentacles;
  const VirtualTruth drawn =
      DrawTruth(one.design, gripper, {truth.pull_scale, truth.stiffness_ratio, truth.stiffness_exponent},
                {one.plan.pull, one.plan.pull_rate}, {}, one.ranges, random)
          .value();
  const double ramp_end = one.plan.pull / one.plan.pull_rate;
  for (int frame = 0; frame * one.plan.frame_step <= one.plan.duration + 1e-9; ++frame) {
    FoldObservation o;
    o.trial = name;
    o.time = frame * one.plan.frame_step;
    o.commanded_pull = std::min(one.plan.pull_rate * o.time, one.plan.pull);
    o.steady_for = o.time > ramp_end ? o.time - ramp_end : frame == 0 ? 1e9 : o.time;
    o.settled_for = o.time > ramp_end ? o.time - ramp_end : frame == 0 ? 1e9 : 0;
    const TrueShape shape = TrueShapeAt(drawn, o.time).value();
    for (int tentacle = 0; tentacle < one.plan.tentacles; ++tentacle) {
      o.tentacle = tentacle;
      o.design = DesignOfTentacle(gripper, one.design, tentacle);
      Observe(shape.tentacles[static_cast<std::size_t>(tentacle)].centerline.points, one.noise, random, o);
      observations.push_back(o);
    }
  }
}

struct Residual {
  std::string name;
  ShapeResidualOptions options;
};

struct Tally {
  double sum = 0;
  double squares = 0;
  double errors = 0;
  int hits = 0;
  int count = 0;
};

void Run(const Case& one, const Residual& residual, const FoldTruth& truth, int studies, int trials,
         std::uint64_t first_seed) {
  const std::array<double, 3> wanted = {truth.pull_scale, truth.stiffness_ratio, truth.stiffness_exponent};
  std::array<Tally, 3> tallies;
  double seconds = 0;
  double rms = 0;
  for (int study = 0; study < studies; ++study) {
    std::vector<FoldObservation> observations;
    for (int trial = 0; trial < trials; ++trial) {
      Random random(first_seed + static_cast<std::uint64_t>(1000 * study + trial));
      const std::string name = fmt::format("t{}", trial);
      if (one.own_shapes) {
        AddTrial(name, one.design, truth, one.plan, {}, one.noise, random, observations);
      } else {
        AddRigTrial(name, truth, one, random, observations);
      }
    }
    FoldFitOptions options;
    options.residual = residual.options;
    options.longest_lag = 1.5;  // delays and rates are not logged here
    const Result<FoldFit> fit = FitFold(observations, options);
    if (!fit.ok()) {
      fmt::print("study {}: {}\n", study, fit.error().message);
      continue;
    }
    seconds += fit.value().seconds;
    rms += fit.value().residual_rms;
    for (std::size_t i = 0; i < 3; ++i) {
      const FittedParameter& p = fit.value().parameters[i];
      if (!p.identified) continue;
      Tally& tally = tallies[i];
      const double off = p.value - wanted[i];
      ++tally.count;
      tally.sum += off;
      tally.squares += off * off;
      tally.errors += p.standard_error;
      tally.hits += p.interval.low <= wanted[i] && wanted[i] <= p.interval.high ? 1 : 0;
    }
  }
  const char* const names[] = {"pull_scale", "stiffness_ratio", "stiffness_exponent"};
  for (std::size_t i = 0; i < 3; ++i) {
    const Tally& tally = tallies[i];
    const double n = std::max(tally.count, 1);
    const double bias = tally.sum / n;
    const double error = tally.errors / n;
    const double spread = n > 1 ? std::sqrt((tally.squares - n * bias * bias) / (n - 1)) : 0;
    fmt::print("| {:27} | {:11} | {:18} | {:+.5f} | {:.5f} | {:.5f} | {:+5.2f} | {}/{} | {:.2f} | {:.2f} |\n",
               one.name, residual.name, names[i], bias, spread, error, bias / std::max(error, 1e-300),
               tally.hits, tally.count, 1e3 * rms / studies, seconds / studies);
  }
  std::fflush(stdout);
}

std::vector<Residual> Residuals() {
  std::vector<Residual> all;
  for (const int creases : {1, 2, 3, 5}) {
    all.push_back({fmt::format("distances {}", creases), {}});
    all.back().options.kind = ShapeResidualKind::kLocalDistances;
    all.back().options.creases = creases;
  }
  for (const int window : {9, 49}) {
    all.push_back({fmt::format("aligned {}", window), {}});
    all.back().options.kind = ShapeResidualKind::kAlignedWindows;
    all.back().options.window = window;
  }
  return all;
}

}  // namespace
}  // namespace tendril::test

int main(int argc, char** argv) {
  using namespace tendril::test;
  const int studies = argc > 1 ? std::atoi(argv[1]) : 20;
  const int trials = argc > 2 ? std::atoi(argv[2]) : 12;
  const std::uint64_t seed = argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1000;
  const std::string only_case = argc > 4 ? argv[4] : "";
  const std::string only_residual = argc > 5 ? argv[5] : "distances 1";
  const FoldTruth truth{0.93, 1.4, 1.3};
  fmt::print(
      "| shapes | residual | parameter | bias | SD | mean SE | bias/SE | in 95 % | RMS, mm | s per fit |\n");
  fmt::print("|---|---|---|---|---|---|---|---|---|---|\n");
  for (const Case& one : Cases()) {
    if (one.name.find(only_case) == std::string::npos) continue;
    for (const Residual& residual : Residuals()) {
      if (residual.name.find(only_residual) == std::string::npos) continue;
      Run(one, residual, truth, studies, trials, seed);
    }
  }
  return 0;
}
