#pragma once
// What `tendril simulate` says of a plan and of a run, to people and programs.

#include <optional>

#include "analysis/link/link_series.h"
#include "cli/command.h"
#include "model/scene/simulate.h"

namespace tendril::cli {

void TellPlan(const Scene& scene, const SimulationPlan& plan, Output& out);
nlohmann::ordered_json TermsOf(const SimulationPlan& plan);

// The axis of the first object that has one.
std::optional<Axis> AxisOf(const Scene& scene);

// Links over time.
//   errors  as MeasureLinkSeries
Result<LinkSeries> TellLink(const Scene& scene, const std::vector<CurveSeries>& curves, Output& out);

// Whether every step of the run shows that no body went through another; null: it was not looked at.
void TellPassages(const Simulated& done, Output& out);

}  // namespace tendril::cli
