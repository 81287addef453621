// What a step costs with contact, against the number of rods and of elements: rods hang in a square
// grid, each touching its neighbours along its whole length.
#include <benchmark/benchmark.h>

#include <cmath>
#include <string>

#include "model/scene/simulate.h"

namespace tendril {
namespace {

Scene Grid(int rods, int elements) {
  Scene scene;
  scene.gravity.setZero();
  scene.contact.law = ContactLaw::kHertzSegments;
  const int side = static_cast<int>(std::ceil(std::sqrt(rods)));
  for (int r = 0; r < rods; ++r) {
    SceneRod rod;
    rod.name = std::to_string(r);
    rod.design.elements = elements;
    rod.design.taper = 0.95;
    const int row = r / side;
    rod.design.start = {0.0385 * (r - row * side), 0.0385 * row, 0};
    rod.damping = 50;
    rod.rest_curvature = {0.2 * r, 5, 0};
    scene.rods.push_back(rod);
  }
  return scene;
}

void Step(benchmark::State& state) {
  const int rods = static_cast<int>(state.range(0)), elements = static_cast<int>(state.range(1));
  const Scene scene = Grid(rods, elements);
  const SimulationPlan plan = PlanScene(scene, true).value();
  constexpr int kSteps = 200;
  for (auto _ : state) {
    const Simulated run = Simulate(scene, plan, {kSteps * plan.time_step}).value();
    if (run.diverged.has_value() || !(run.least_axis_share < 1)) state.SkipWithError("not what it should be");
  }
  const double steps = kSteps * static_cast<double>(state.iterations());
  state.counters["per_step"] =
      benchmark::Counter(steps, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  state.counters["per_element_step"] =
      benchmark::Counter(steps * rods * elements, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(Step)
    ->ArgsProduct({{2, 4, 8, 16, 32, 64}, {100}})
    ->ArgsProduct({{8}, {25, 50, 200, 400, 800, 1600}})
    ->ArgNames({"rods", "elements"})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace tendril
