#pragma once
// What `tendril simulate` says of a plan and of a run, to people and programs.

#include <optional>
#include <string>

#include "analysis/link/link_series.h"
#include "cli/command.h"
#include "model/scene/holding.h"
#include "model/scene/simulate.h"

namespace tendril::cli {

void TellPlan(const Scene& scene, const SimulationPlan& plan, Output& out);
nlohmann::ordered_json TermsOf(const SimulationPlan& plan);

// How far it came and how fast.
//   resumed_at  where it went on from, s
void TellRun(const Scene& scene, const Simulated& done, double wall_s, double resumed_at, Output& out);

// Of each object where it began and ended, and whether rods touch it at the end.
void TellObjects(const Scene& scene, const Simulated& done, Output& out);

// The first object that has an axis; none: links with an object are not measured.
std::optional<std::size_t> AxialObject(const Scene& scene);

// Links over time; with an object that moves, as that sees the rods.
//   errors  as MeasureLinkSeries
Result<LinkSeries> TellLink(const Scene& scene, const Simulated& done, Output& out);

// Whether every step of the run shows that no body went through another; null: it was not looked at.
void TellPassages(const Simulated& done, Output& out);

// Why the run cannot be trusted, if so.
void TellDoubts(const Simulated& done, Output& out);

// A test of holding that the run ends with.
struct HoldingPlan {
  HoldingTest test = HoldingTest::kLift;
  HoldingOptions options;
  HoldingTimes times;
};

HoldingTest HoldingTestNamed(const std::string& name);

struct HoldingVerdict {
  HoldingResult result;
  std::string rule;        // what counts as a grasp, in words
  double object_mass = 0;  // kg
};

//   errors  as JudgeHolding, MakeRods
Result<HoldingVerdict> TellHolding(const Scene& scene, const HoldingPlan& plan, const Simulated& done,
                                   Output& out);

}  // namespace tendril::cli
