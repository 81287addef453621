#pragma once
// A scene, stepped: rods that bend to their rest shapes, touch each other and a fixed object.

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "model/geometry/framed_curve.h"
#include "model/progress.h"
#include "model/result.h"
#include "model/scene/scene.h"

namespace tendril {

// A part of the physics, whether this scene requires it, and the estimate by which that was told.
struct PlanTerm {
  std::string name;
  bool on = false;
  std::string why;
};

struct SimulationPlan {
  double time_step = 0;  // s, the largest taken
  std::string step_why;
  bool rod_contact = false, self_contact = false, object_contact = false;
  bool plain = false;  // step in the plain form, hundreds of times slower: to check the fast one
  std::vector<PlanTerm> terms;
};

// What the scene requires. Contact is left out only where nothing can meet: rods farther apart than they are
// long.
//   full    everything on
//   errors  as MakeRod, LayOut, SolveFold
Result<SimulationPlan> PlanScene(const Scene& scene, bool full = false);

struct Simulated {
  std::vector<CurveSeries> curves;  // a rod each, at the times asked for and reached
  std::int64_t steps = 0;
  bool stopped = false;  // the progress said so; curves up to there
  std::string diverged;  // why, when and which rods; empty: it did not. Curves up to there
  // Of elements that touched, over all steps: the least distance of their axes, m, and as a share of their
  // radii's sum (infinite: nothing touched); the farthest that a node went in a step, m; whether these show
  // that no body passed through another (contact_list.h).
  double least_axis_distance = std::numeric_limits<double>::infinity();
  double least_axis_share = std::numeric_limits<double>::infinity();
  double longest_move = 0;
  std::optional<bool> nothing_passed;
};

// Steps from 0 to the last of `times` (s, ascending), which are met exactly: steps between two of them are
// equal and at most the plan's.
//   trial   counts in the random draws
//   errors  as PlanScene; kBadInput  times that do not ascend from 0 or above
Result<Simulated> Simulate(const Scene& scene, const SimulationPlan& plan, const std::vector<double>& times,
                           std::uint64_t trial = 0, const Progress& progress = {});

}  // namespace tendril
