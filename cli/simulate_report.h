#pragma once
// What `tendril simulate` says of a plan and of a run, to people and programs.

#include <optional>

#include "analysis/link/link_series.h"
#include "cli/command.h"
#include "model/scene/simulate.h"

namespace tendril::cli {

// Level, step and terms; to people in a few lines.
//   reasons  a line for each term, with its estimate
void TellPlan(const Scene& scene, const SimulationPlan& plan, bool reasons, Output& out);
nlohmann::ordered_json TermsOf(const SimulationPlan& plan);

// How far it came and how fast.
void TellRun(const Scene& scene, const Simulated& done, double wall_s, Output& out);

// Of each object where it began and ended, and whether rods touch it at the end.
void TellObjects(const Scene& scene, const Simulated& done, Output& out);

// Where the object that is to be grasped has its axis at the start: of a cylinder or a capsule. None: links
// with it are not measured, for a sphere, a box or a union has no axis.
std::optional<Axis> AxisOf(const SceneObject& object);

// Links over time; with an object that moves, as that sees the rods.
//   grasped_until  s: when a test of holding begins, which may undo the grasp; links are told of the last
//                  frame before. None: of the last
//   errors  as MeasureLinkSeries
Result<LinkSeries> TellLink(const Scene& scene, const Simulated& done, std::optional<double> grasped_until,
                            Output& out);

// Whether every step of the run shows that no body went through another; null: it was not looked at.
void TellPassages(const Simulated& done, Output& out);

// Why the run cannot be trusted, if so.
void TellDoubts(const Simulated& done, Output& out);

}  // namespace tendril::cli
