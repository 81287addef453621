// How often do the fold fit's intervals hold the truth? Draws studies (trials of one design through a fast
// model of the tracker's noise, no video), fits each, and prints bias, spread, mean standard error and
// coverage for each parameter, with and without each way in which a tentacle differs from the model.
//
//   bench_fold_fit_coverage [studies=20] [trials=12] [first seed=1000]

#include <fmt/core.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "calibrate/fold/fold_fit.h"
#include "tests/support/perturbed_tentacle.h"

namespace tendril::test {
namespace {

struct Case {
  std::string name;
  Perturbation perturbation;
  TrackerNoise noise;
  TrialPlan plan;
};

std::vector<Case> Cases() {
  const Perturbation all;
  std::vector<Case> cases;
  cases.push_back({"everything", all, {}, {}});
  cases.push_back({"no perturbation, tracker noise", kExactly, {}, {}});
  cases.push_back({"no tracker noise", all, kNoiseless, {}});
  Perturbation p = all;
  p.sag = 0;
  cases.push_back({"no sag", p, {}, {}});
  p = all;
  p.bend = p.wander = 0;
  cases.push_back({"no bending", p, {}, {}});
  p = all;
  p.delay = p.rate = 0;
  cases.push_back({"no delays", p, {}, {}});
  p = all;
  p.place = p.crease_angle = p.stiffness = 0;
  cases.push_back({"holes, creases, stiffness exact", p, {}, {}});
  TrialPlan ramp;
  ramp.duration = 9.9;
  cases.push_back({"frames of the ramp only", all, {}, ramp});
  TrackerNoise loud;
  loud.alone *= 2;
  loud.along *= 2;
  cases.push_back({"twice the tracker noise", all, loud, {}});
  return cases;
}

struct Residual {
  std::string name;
  ShapeResidualOptions options;
};

void Run(const Case& one, const Residual& residual, const FoldTruth& truth, int studies, int trials,
         std::uint64_t first_seed) {
  const std::array<double, 3> wanted = {truth.pull_scale, truth.stiffness_ratio, truth.stiffness_exponent};
  std::array<double, 3> sum{}, squares{}, errors{};
  std::array<int, 3> hits{};
  std::array<int, 3> count{};
  double seconds = 0;
  double rms = 0;
  for (int study = 0; study < studies; ++study) {
    std::vector<FoldObservation> observations;
    for (int trial = 0; trial < trials; ++trial) {
      Random random(first_seed + static_cast<std::uint64_t>(1000 * study + trial));
      AddTrial(fmt::format("t{}", trial), TentacleDesign{}, truth, one.plan, one.perturbation, one.noise,
               random, observations);
    }
    FoldFitOptions options;
    options.residual = residual.options;
    const Result<FoldFit> fit = FitFold(observations, options);
    if (!fit.ok()) {
      fmt::print("  study {}: {}\n", study, fit.error().message);
      continue;
    }
    seconds += fit.value().seconds;
    rms += fit.value().residual_rms;
    for (std::size_t i = 0; i < 3; ++i) {
      const FittedParameter& p = fit.value().parameters[i];
      if (!p.identified) continue;
      ++count[i];
      sum[i] += p.value - wanted[i];
      squares[i] += (p.value - wanted[i]) * (p.value - wanted[i]);
      errors[i] += p.standard_error;
      hits[i] += p.interval.low <= wanted[i] && wanted[i] <= p.interval.high ? 1 : 0;
    }
  }
  const char* names[] = {"pull_scale", "stiffness_ratio", "stiffness_exponent"};
  for (std::size_t i = 0; i < 3; ++i) {
    const double n = std::max(count[i], 1);
    const double bias = sum[i] / n;
    const double sd = count[i] > 1 ? std::sqrt((squares[i] - n * bias * bias) / (n - 1)) : 0;
    fmt::print(
        "| {:31} | {:14} | {:18} | {:+.5f} | {:.5f} | {:.5f} | {:+6.2f} | {:3}/{:3} | {:5.2f} | {:4.2f} |\n",
        one.name, residual.name, names[i], bias, sd, errors[i] / n, bias / std::max(errors[i] / n, 1e-300),
        hits[i], count[i], 1e3 * rms / studies, seconds / studies);
  }
  std::fflush(stdout);
}

}  // namespace
}  // namespace tendril::test

int main(int argc, char** argv) {
  using namespace tendril;
  const int studies = argc > 1 ? std::atoi(argv[1]) : 20;
  const int trials = argc > 2 ? std::atoi(argv[2]) : 12;
  const std::uint64_t seed = argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1000;
  const std::string only_case = argc > 4 ? argv[4] : "";
  const std::string only_residual = argc > 5 ? argv[5] : "";
  test::FoldTruth truth{0.93, 1.4, 1.3};
  std::vector<test::Residual> residuals;
  for (const int window : {5, 9, 17, 49}) {
    test::Residual r{fmt::format("{} nodes", window), {}};
    r.options.window = window;
    residuals.push_back(r);
  }
  test::Residual distances{"distances", {}};
  distances.options.kind = ShapeResidualKind::kLocalDistances;
  residuals.push_back(distances);
  fmt::print(
      "| truth | residual | parameter | bias | SD | mean SE | bias/SE | in 95 % | RMS mm | s per fit "
      "|\n|{0}{0}{0}{0}{0}\n",
      "---|---|");
  for (const test::Case& one : test::Cases()) {
    if (one.name.find(only_case) == std::string::npos) continue;
    for (const test::Residual& residual : residuals) {
      if (residual.name.find(only_residual) == std::string::npos) continue;
      test::Run(one, residual, truth, studies, trials, seed);
    }
  }
  return 0;
}
