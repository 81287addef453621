// What a rod's element costs per step: the plain stepper, and eight rods in vector registers.
#include <benchmark/benchmark.h>

#include <string>
#include <vector>

#include "model/machine.h"
#include "model/rods/rod_lanes.h"
#include "model/rods/rod_plain.h"

namespace tendril {
namespace {

// The paper's rods, bending to a rest curvature under gravity.
std::vector<Rod> Rods(int count, int elements) {
  std::vector<Rod> rods;
  for (int k = 0; k < count; ++k) {
    RodDesign design;
    design.elements = elements;
    design.taper = 0.5;
    design.start = {0.1 * k, 0, 0};
    rods.push_back(MakeRod(design).value());
    for (auto kappa : rods.back().rest_curvature.colwise()) kappa << 0, 3 + 0.1 * k, 2;
  }
  return rods;
}

// The step falls with the elements' length: at 2e-5 s 1,600 of them are beyond the stable limit.
PlainOptions Options(RodForm form, int elements = 100) {
  return {.form = form, .time_step = elements > 400 ? 2e-6 : 2e-5, .damping = 1, .gravity = {0, 0, -9.80665}};
}

void Report(benchmark::State& state, double per_iteration) {
  state.counters["per_element_step"] = benchmark::Counter(
      per_iteration, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void Plain(benchmark::State& state, RodForm form) {
  std::vector<Rod> rods = Rods(1, 100);
  for (auto _ : state) StepPlain(rods, 0, Options(form));
  Report(state, 100);
}
BENCHMARK_CAPTURE(Plain, paper, RodForm::kPaper);
BENCHMARK_CAPTURE(Plain, energy, RodForm::kEnergy);

template <class S>
void Lanes(benchmark::State& state, RodForm form, const Medium& medium = {}, bool couples = false) {
  const int width = static_cast<int>(state.range(0)), elements = static_cast<int>(state.range(1));
  if (width > MachineDoubles()) return state.SkipWithError("not on this machine");
  UseRodKernel(width);
  const std::vector<Rod> start = Rods(8, elements);
  LaneRods<S> rods = LaneRods<S>::Make(start, form).value();
  rods.SetMedium(medium, start, std::vector<Wetted>(8));
  rods.UseCouples(couples);
  const PlainOptions options = Options(form, elements);
  // Couples count only with a middle of the step; it clears forces too.
  const typename LaneRods<S>::Middle middle = [](double, LaneRods<S>&) {};
  for (auto _ : state) rods.Advance(100, 0, options, couples ? middle : typename LaneRods<S>::Middle());
  if (rods.trouble().any()) state.SkipWithError("rods in trouble");
  UseRodKernel(0);
  Report(state, 800.0 * elements);
}
void LanesInDouble(benchmark::State& state, RodForm form) { Lanes<double>(state, form); }
void LanesInSingle(benchmark::State& state, RodForm form) { Lanes<float>(state, form); }
void LanesInWater(benchmark::State& state, RodForm form) { Lanes<double>(state, form, Water()); }
void LanesWithCouples(benchmark::State& state, RodForm form) { Lanes<double>(state, form, {}, true); }
BENCHMARK_CAPTURE(LanesInDouble, paper, RodForm::kPaper)
    ->ArgsProduct({{2, 4, 8}, {100}})
    ->ArgsProduct({{8}, {25, 400, 1600}})
    ->ArgNames({"width", "elements"});
BENCHMARK_CAPTURE(LanesInSingle, paper, RodForm::kPaper)
    ->ArgsProduct({{2, 4, 8}, {100}})
    ->ArgNames({"width", "elements"});
BENCHMARK_CAPTURE(LanesInDouble, energy, RodForm::kEnergy)
    ->ArgsProduct({{2, 4, 8}, {100}})
    ->ArgNames({"width", "elements"});
BENCHMARK_CAPTURE(LanesInSingle, energy, RodForm::kEnergy)
    ->ArgsProduct({{2, 4, 8}, {100}})
    ->ArgNames({"width", "elements"});
BENCHMARK_CAPTURE(LanesInWater, paper, RodForm::kPaper)
    ->ArgsProduct({{2, 4, 8}, {100}})
    ->ArgNames({"width", "elements"});
BENCHMARK_CAPTURE(LanesInWater, energy, RodForm::kEnergy)
    ->ArgsProduct({{2, 4, 8}, {100}})
    ->ArgNames({"width", "elements"});
BENCHMARK_CAPTURE(LanesWithCouples, energy, RodForm::kEnergy)
    ->ArgsProduct({{2, 4, 8}, {100}})
    ->ArgNames({"width", "elements"});

}  // namespace
}  // namespace tendril
