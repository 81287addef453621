// How many pulls per second: solve, fold and trace the 49-hole tentacle on one core.
#include <benchmark/benchmark.h>

#include "model/fold/design.h"
#include "model/fold/exact_law.h"
#include "model/fold/facet_chain.h"
#include "model/fold/fold.h"

namespace tendril {
namespace {

// Pulls differ from call to call, over the reachable range: nothing is learnt by the branch predictor alone.
double NextPull(double pull) { return pull > 0.9 ? 0.05 : pull + 0.0137; }

void SolveOnly(benchmark::State& state) {
  TentacleDesign design;
  design.holes = static_cast<int>(state.range(0));
  design.length = 0.015 * (design.holes + 1);
  const TentacleLayout layout = LayOut(design).value();
  double pull = 0.05;
  for (auto _ : state) {
    pull = NextPull(pull);
    benchmark::DoNotOptimize(SolveFold(layout, design.base_width, design.closed_angle, pull));
  }
  state.SetItemsProcessed(state.iterations());
  state.SetComplexityN(state.range(0));
}
BENCHMARK(SolveOnly)->Arg(49)->Arg(1000)->Arg(10000)->Arg(100000)->Complexity(benchmark::oN);

void SolveExactOnly(benchmark::State& state) {
  TentacleDesign design;
  design.holes = static_cast<int>(state.range(0));
  design.length = 0.015 * (design.holes + 1);
  const TentacleLayout layout = LayOut(design).value();
  const Eigen::VectorXd stiffness = HingeStiffness(design, layout);
  double pull = 0.05;
  for (auto _ : state) {
    pull = NextPull(pull);
    benchmark::DoNotOptimize(SolveExactFold(layout, stiffness, 0, design.closed_angle, pull));
  }
  state.SetItemsProcessed(state.iterations());
  state.SetComplexityN(state.range(0));
}
BENCHMARK(SolveExactOnly)->Arg(49)->Arg(1000)->Arg(10000)->Arg(100000)->Complexity(benchmark::oN);

void SolveFoldTrace(benchmark::State& state) {
  TentacleDesign design;
  design.holes = static_cast<int>(state.range(0));
  design.length = 0.015 * (design.holes + 1);
  const TentacleLayout layout = LayOut(design).value();
  double pull = 0.05;
  for (auto _ : state) {
    pull = NextPull(pull);
    const Result<Fold> fold = SolveFold(layout, design.base_width, design.closed_angle, pull);
    const FacetChain chain = FoldChain(layout, fold.value().angle);
    benchmark::DoNotOptimize(TendonCurveOf(layout, chain, fold.value().angle));
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(SolveFoldTrace)->Arg(49)->Arg(2000)->Arg(100000);

// The same at the paper's pull, where no crease has closed yet.
void SolveFoldTraceAtPull(benchmark::State& state) {
  const TentacleDesign design;
  const TentacleLayout layout = LayOut(design).value();
  const double pull = 1e-2 * static_cast<double>(state.range(0));
  FacetChain chain;
  TendonCurve curve;
  for (auto _ : state) {
    const Result<Fold> fold = SolveFold(layout, design.base_width, design.closed_angle, pull);
    FoldChain(layout, fold.value().angle, chain);
    TendonCurveOf(layout, chain, fold.value().angle, curve);
    benchmark::DoNotOptimize(curve.holes.data());
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(SolveFoldTraceAtPull)->Arg(30)->Arg(60)->ArgName("pull_percent");

}  // namespace
}  // namespace tendril
