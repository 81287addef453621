// What a segment pair costs: the scalar form, the vector kernel, and the paper's whole measurement.
#include <benchmark/benchmark.h>

#include <random>

#include "analysis/link/link.h"
#include "analysis/link/link_kernel.h"

namespace tendril {
namespace {

Eigen::Matrix3Xd Walk(unsigned seed, int nodes) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0, 0.05);
  Eigen::Matrix3Xd points =
      Eigen::Vector3d(0.1, 0.02, 0.03).replicate(1, nodes) * seed;  // apart at the start
  for (int i = 1; i < nodes; ++i) {
    points.col(i) = points.col(i - 1) + Eigen::Vector3d(normal(random), normal(random), normal(random));
  }
  return points;
}

void PerPair(benchmark::State& state, LinkMethod method) {
  const int segments = static_cast<int>(state.range(0));
  const Strand a = CloseCurve(Walk(1, segments + 1), {ClosureKind::kNone, 0}).value();
  const Strand b = CloseCurve(Walk(2, segments + 1), {ClosureKind::kNone, 0}).value();
  for (auto _ : state) benchmark::DoNotOptimize(StrandLink(a, b, method));
  state.counters["per_pair"] =
      benchmark::Counter(static_cast<double>(segments) * segments,
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.SetLabel("vector width " + std::to_string(method == LinkMethod::kFast ? LinkKernelWidth() : 1));
}
BENCHMARK_CAPTURE(PerPair, scalar_with_error_bound, LinkMethod::kExact)->Arg(100)->Arg(1000);
BENCHMARK_CAPTURE(PerPair, vector, LinkMethod::kFast)->Arg(100)->Arg(1000)->Arg(5000);

void PerPairByWidth(benchmark::State& state) {
  const int width = static_cast<int>(state.range(0));
  if (width > LinkKernelWidth()) return state.SkipWithError("not on this machine");
  const Strand a = CloseCurve(Walk(1, 101), {ClosureKind::kNone, 0}).value();
  const Strand b = CloseCurve(Walk(2, 101), {ClosureKind::kNone, 0}).value();
  const NodeArrays x{a.x.data(), a.y.data(), a.z.data(), a.nodes()},
      y{b.x.data(), b.y.data(), b.z.data(), b.nodes()};
  for (auto _ : state) benchmark::DoNotOptimize(SumSegmentAngles(x, y, width));
  state.counters["per_pair"] =
      benchmark::Counter(1e4, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(PerPairByWidth)->Arg(2)->Arg(4)->Arg(8);

// The bare formula, as a loop over pairs would call it.
void OneScalarPair(benchmark::State& state) {
  const Eigen::Matrix3Xd p = Walk(3, 4);
  const auto node = [&](int i) { return Vec3<double>{p(0, i), p(1, i), p(2, i)}; };
  Vec3<double> moving = node(0);
  double sum = 0;
  for (auto _ : state) {
    moving.x += 1e-9;
    sum += SegmentSegmentAngle(moving, node(1), node(2), node(3)).angle;
  }
  benchmark::DoNotOptimize(sum);
}
BENCHMARK(OneScalarPair);

// Eight tentacles of 100 segments, all pairs, closed by rays, with their Gauss integrals.
void EightTentaclesAllPairs(benchmark::State& state) {
  std::vector<Strand> strands;
  for (unsigned k = 0; k < 8; ++k) strands.push_back(CloseCurve(Walk(k, 101), {}).value());
  for (auto _ : state) {
    for (size_t i = 0; i < 8; ++i) {
      for (size_t j = i + 1; j < 8; ++j) benchmark::DoNotOptimize(StrandLink(strands[i], strands[j]));
    }
  }
}
BENCHMARK(EightTentaclesAllPairs)->Unit(benchmark::kMillisecond);

void MeasureEightTentacles(benchmark::State& state) {
  std::vector<FramedCurve> curves;
  for (unsigned k = 0; k < 8; ++k) {
    curves.push_back({Walk(k, 101), Eigen::Vector3d(0.1, 0.2, 1).normalized().replicate(1, 101)});
  }
  LinkOptions options;
  options.axis = Axis{{0, 0, 0}, {1, 0, 0}};
  for (auto _ : state) benchmark::DoNotOptimize(MeasureLink(curves, options));
}
BENCHMARK(MeasureEightTentacles)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace tendril
