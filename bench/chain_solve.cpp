// Time of one tentacle in one frame (capture/track/chain_solve.h), from synthetic views of two, one and four
// cameras. 49 holes, pull 0.3; a new draw of noise per iteration.
#include "capture/track/chain_solve.h"

#include <benchmark/benchmark.h>

#include <random>
#include <vector>

#include "tests/support/synthetic_view.h"

namespace tendril {
namespace {

using testing_support::CamerasAround;
using testing_support::MakeTruth;
using testing_support::Truth;
using testing_support::Visibility;

void SolveOneFrame(benchmark::State& state, const Visibility& picture, bool follows) {
  const std::vector<Camera> rig = CamerasAround(static_cast<int>(state.range(0)));
  std::vector<Truth> truths;
  for (int draw = 0; draw < 16; ++draw) {
    std::mt19937_64 random(draw);
    truths.push_back(MakeTruth({}, 0.3, rig, picture, {}, random));
  }
  // What the frame before found, when the tendon was pulled a little less.
  std::vector<ChainSolution> before(truths.size());
  for (int draw = 0; follows && draw < 16; ++draw) {
    std::mt19937_64 random(draw);
    const Truth truth = MakeTruth({}, 0.297, rig, picture, {}, random);
    before[static_cast<std::size_t>(draw)] = SolveChain(truth.model, rig, truth.views);
  }
  double views = 0;
  double iterations = 0;
  std::size_t next = 0;
  for (auto _ : state) {
    const std::size_t draw = next++ % truths.size();
    const Truth& truth = truths[draw];
    const ChainSolution solution =
        SolveChain(truth.model, rig, truth.views, {}, follows ? &before[draw] : nullptr);
    benchmark::DoNotOptimize(solution.curve.points.data());
    views += static_cast<double>(truth.views.size());
    iterations += solution.iterations;
  }
  state.counters["views"] = benchmark::Counter(views, benchmark::Counter::kAvgIterations);
  state.counters["steps"] = benchmark::Counter(iterations, benchmark::Counter::kAvgIterations);
}

BENCHMARK_CAPTURE(SolveOneFrame, all_tags, Visibility{}, false)
    ->Arg(1)
    ->Arg(2)
    ->Arg(4)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(SolveOneFrame, few_tags, Visibility{.kept = 0.3}, false)
    ->Arg(2)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(SolveOneFrame, outliers, Visibility{.outliers = 0.05}, false)
    ->Arg(2)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(SolveOneFrame, following, Visibility{}, true)
    ->Arg(1)
    ->Arg(2)
    ->Arg(4)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(SolveOneFrame, following_outliers, Visibility{.outliers = 0.05}, true)
    ->Arg(2)
    ->Arg(4)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace tendril
