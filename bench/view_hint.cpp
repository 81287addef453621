// Is a further view worth what the hint of `calibrate fold` says? Draws campaigns (own shapes of the tests,
// no video) in which each node is seen by some of the cameras, asks the hint what one more camera would do,
// then gives each trial that camera and fits anew. Prints the standard error foretold, with the further
// camera over without, beside the mean standard error that comes out and the spread of the estimates over the
// campaigns.
//
//   bench_view_hint [campaigns] [first seed] [part of a study's name]
//
// Seeds: tuning used 5'000'000 and up; the table of docs/calibration.md uses 6'000'000 and up.

#include <fmt/core.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "calibrate/fold/view_hint.h"
#include "tests/support/seen_by_cameras.h"

namespace tendril::test {
namespace {

struct Tally {
  double foretold = 0, share = 0, before = 0, after = 0;
  double off_before = 0, off_after = 0, square_before = 0, square_after = 0;
  int count = 0;
};

double Spread(double sum, double squares, double n) {
  return std::sqrt(std::max(0.0, squares - sum * sum / n) / std::max(n - 1, 1.0));
}

void Run(const CameraStudy& study, int campaigns, std::uint64_t first_seed) {
  const FoldTruth truth{0.93, 1.4, 1.3};
  const std::array<double, 3> wanted = {truth.pull_scale, truth.stiffness_ratio, truth.stiffness_exponent};
  std::array<Tally, 3> tallies;
  FoldFitOptions options;
  options.places = {"one more"};
  for (int campaign = 0; campaign < campaigns; ++campaign) {
    const CameraCampaign drawn =
        DrawCampaign(study, {}, truth, first_seed + 1000 * static_cast<std::uint64_t>(campaign));
    const Result<FitRun> before = RunFit(drawn.before, options, {});
    const Result<FitRun> after = RunFit(drawn.after, options, {});
    if (!before.ok() || !after.ok()) {
      fmt::print(stderr, "campaign {}: {}\n", campaign, (before.ok() ? after : before).error().message);
      continue;
    }
    for (std::size_t i = 0; i < 3; ++i) {
      const FittedParameter& p = before.value().fit.parameters[i];
      const FittedParameter& q = after.value().fit.parameters[i];
      if (!p.identified || !q.identified) continue;
      const std::optional<ViewHint> hint = ViewHintOf(before.value(), options, static_cast<int>(i));
      if (!hint || hint->best < 0) continue;
      Tally& tally = tallies[i];
      ++tally.count;
      tally.foretold += hint->error_ratio[0];
      tally.share += hint->picture_share;
      tally.before += p.standard_error;
      tally.after += q.standard_error;
      const double off = p.value - wanted[i];
      const double off_after = q.value - wanted[i];
      tally.off_before += off;
      tally.off_after += off_after;
      tally.square_before += off * off;
      tally.square_after += off_after * off_after;
    }
  }
  const char* const names[] = {"pull_scale", "stiffness_ratio", "stiffness_exponent"};
  for (std::size_t i = 0; i < 3; ++i) {
    const Tally& t = tallies[i];
    const double n = std::max(t.count, 1);
    fmt::print("| {:40} | {:18} | {:3.0f} % | {:.3f} | {:.3f} | {:.3f} | {} |\n", study.name, names[i],
               100 * t.share / n, t.foretold / n, t.after / t.before,
               Spread(t.off_after, t.square_after, n) / Spread(t.off_before, t.square_before, n), t.count);
  }
  std::fflush(stdout);
}

}  // namespace
}  // namespace tendril::test

int main(int argc, char** argv) {
  using namespace tendril::test;
  const int campaigns = argc > 1 ? std::atoi(argv[1]) : 50;
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 6'000'000;
  const std::string only = argc > 3 ? argv[3] : "";
  fmt::print("| study | parameter | of pictures | foretold | standard error | spread | campaigns |\n");
  fmt::print("|---|---|---|---|---|---|---|\n");
  for (const CameraStudy& study : CameraStudies()) {
    if (study.name.find(only) != std::string::npos) Run(study, campaigns, seed);
  }
  return 0;
}
