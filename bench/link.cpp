// What a segment pair costs: the scalar form, the vector kernel, and the paper's whole measurement.
#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "analysis/link/link.h"
#include "analysis/link/link_kernel.h"
#include "analysis/link/link_tree.h"

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

// All pairs against the tree, on two random walks through each other: which is faster from where on.
void AllPairs(benchmark::State& state) {
  const int segments = static_cast<int>(state.range(0));
  const Strand a = CloseCurve(Walk(1, segments + 1), {ClosureKind::kNone, 0}).value();
  const Strand b = CloseCurve(Walk(2, segments + 1), {ClosureKind::kNone, 0}).value();
  const NodeArrays x{a.x.data(), a.y.data(), a.z.data(), a.nodes()},
      y{b.x.data(), b.y.data(), b.z.data(), b.nodes()};
  for (auto _ : state) benchmark::DoNotOptimize(SumSegmentAngles(x, y));
}
BENCHMARK(AllPairs)->Arg(100)->Arg(200)->Arg(400)->Arg(1000)->Arg(5000)->Unit(benchmark::kMicrosecond);

void Tree(benchmark::State& state) {
  const int segments = static_cast<int>(state.range(0));
  const Strand a = CloseCurve(Walk(1, segments + 1), {ClosureKind::kNone, 0}).value();
  const Strand b = CloseCurve(Walk(2, segments + 1), {ClosureKind::kNone, 0}).value();
  for (auto _ : state) benchmark::DoNotOptimize(SumByTree(a, b));
  const NodeArrays x{a.x.data(), a.y.data(), a.z.data(), a.nodes()},
      y{b.x.data(), b.y.data(), b.z.data(), b.nodes()};
  state.counters["off_turns"] =
      std::abs(SumByTree(a, b).angle - SumSegmentAngles(x, y).angle) / (4 * std::numbers::pi);
}
BENCHMARK(Tree)->Arg(100)->Arg(200)->Arg(400)->Arg(1000)->Arg(5000)->Unit(benchmark::kMicrosecond);

// 64 tentacles of 5,000 segments, each a helix of 6 turns, all in one bundle 60 mm wide: 5e10 segment pairs.
std::vector<FramedCurve> Bundle(int curves, int segments) {
  std::mt19937_64 random(64);
  std::uniform_real_distribution<double> even(0, 1);
  std::vector<FramedCurve> bundle;
  for (int k = 0; k < curves; ++k) {
    const double x = 0.06 * even(random), y = 0.06 * even(random), phase = 6.28 * even(random);
    const double hand = k % 2 == 0 ? 1 : -1, radius = 0.01 + 0.02 * even(random);
    Eigen::Matrix3Xd points(3, segments + 1);
    for (int i = 0; i <= segments; ++i) {
      const double s = static_cast<double>(i) / segments;
      const double turn = phase + hand * 6 * 2 * std::numbers::pi * s;
      points.col(i) << x + radius * std::cos(turn), y + radius * std::sin(turn), -0.75 * s;
    }
    bundle.push_back({points, {}});
  }
  return bundle;
}

void BundleOfLongCurves(benchmark::State& state) {
  const int curves = static_cast<int>(state.range(0));
  std::vector<Strand> strands;
  for (const FramedCurve& curve : Bundle(curves, 5000))
    strands.push_back(CloseCurve(curve.points, {}).value());
  for (auto _ : state) {
    for (size_t i = 0; i < strands.size(); ++i) {
      for (size_t j = i + 1; j < strands.size(); ++j) {
        benchmark::DoNotOptimize(StrandLink(strands[i], strands[j]));
      }
    }
  }
  double off = 0;
  for (size_t j = 1; j < 4; ++j) {
    const NodeArrays x{strands[0].x.data(), strands[0].y.data(), strands[0].z.data(), strands[0].nodes()},
        y{strands[j].x.data(), strands[j].y.data(), strands[j].z.data(), strands[j].nodes()};
    off = std::max(off, std::abs(SumByTree(strands[0], strands[j]).angle - SumSegmentAngles(x, y).angle) /
                            (4 * std::numbers::pi));
  }
  state.counters["off_turns"] = off;  // from all pairs, the worst of three
}
BENCHMARK(BundleOfLongCurves)->Arg(8)->Arg(64)->Unit(benchmark::kSecond)->Iterations(1);

// What single precision would do to a sum: its error against double, and its cost.
void ScalarSinglePrecision(benchmark::State& state) {
  const Eigen::Matrix3Xd a = Walk(1, 101), b = Walk(2, 101);
  const auto node = [](const Eigen::Matrix3Xd& p, int i) {
    return Vec3<float>{static_cast<float>(p(0, i)), static_cast<float>(p(1, i)), static_cast<float>(p(2, i))};
  };
  float sum = 0;
  for (auto _ : state) {
    sum = 0;
    for (int i = 0; i < 100; ++i) {
      for (int j = 0; j < 100; ++j) {
        sum += SegmentSegmentAngle(node(a, i), node(a, i + 1), node(b, j), node(b, j + 1)).angle;
      }
    }
    benchmark::DoNotOptimize(sum);
  }
  const Strand x = CloseCurve(a, {ClosureKind::kNone, 0}).value(),
               y = CloseCurve(b, {ClosureKind::kNone, 0}).value();
  state.counters["off_turns"] =
      std::abs(sum / (4 * std::numbers::pi) - StrandLink(x, y, LinkMethod::kExact).value);
  state.counters["per_pair"] =
      benchmark::Counter(1e4, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(ScalarSinglePrecision);

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
