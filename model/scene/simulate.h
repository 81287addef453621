#pragma once
// A scene, stepped: rods that bend to their rest shapes, touch and hold each other and objects.

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "model/geometry/framed_curve.h"
#include "model/objects/object_series.h"
#include "model/progress.h"
#include "model/result.h"
#include "model/scene/plan.h"
#include "model/scene/scene.h"
#include "model/scene/watchdog.h"

namespace tendril {

struct Simulated {
  std::vector<CurveSeries> curves;     // a rod each, at the times asked for and reached
  std::vector<ObjectSeries> objects;   // of the scene, one each, at the same times
  std::int64_t steps = 0;              // made in all; of kStatic: equilibria found
  double time_step = 0;                // s, taken; 0 of kStatic
  double resumed_at = 0;               // s, where the run went on from; 0: it began
  bool stopped = false;                // the progress said so; curves up to there
  std::optional<Divergence> diverged;  // curves up to there
  // Of elements that touched, over all steps: the least distance of their axes, m, and as a share of their
  // radii's sum (infinite: nothing touched); the farthest that a node went in a step, m; whether these show
  // that no body passed through another (contact_list.h).
  double least_axis_distance = std::numeric_limits<double>::infinity();
  double least_axis_share = std::numeric_limits<double>::infinity();
  double longest_move = 0;
  std::optional<bool> nothing_passed;
  // The most that the spring of what sticks was drawn, as a share of the radii's sum.
  double longest_stick = 0;
  // Why the run cannot be trusted, in words; empty: nothing speaks against it.
  std::vector<std::string> doubts;
};

// Overlaps deeper than this share of a radius, and springs of what sticks drawn farther than this share of
// the radii's sum, make a run doubtful: contact is softer than what it stands for. A scene that begins with
// such an overlap is not run; one that begins with a shallower one is, with a warning.
inline constexpr double kDeepestTrusted = 0.25, kLongestStickTrusted = 0.1;
// Shares of a radius below this, in which bodies overlap at the start, are not worth a word.
inline constexpr double kOverlapToTell = 0.02;

// A run that was interrupted, whole: from it the same scene goes on to the same bytes.
struct SimulationState {
  std::vector<double> numbers;      // the stepper's, then the objects' frames
  std::vector<CurveSeries> curves;  // up to there
};

struct SimulateHooks {
  int threads = 1;  // to share the rods, eight to each; the bytes do not depend on it
  Progress progress{};
  // Called at once with what may spoil the run, a sentence: bodies that start inside each other.
  std::function<void(const std::string&)> warn{};
  // Called after each kBlock steps, also after a stop was asked for, with a function that makes the state.
  std::function<void(const std::function<SimulationState()>&)> keep{};
  const SimulationState* resume_from = nullptr;
};

// Steps after which a run looks at its energy and forgets its contact lists, so that a resumed run goes on to
// the same bytes.
inline constexpr std::int64_t kBlock = 1000;

// Steps from 0 to the scene's duration in equal steps, at most the plan's, whatever is asked for.
//   times   s, ascending, from 0 to the duration: where curves are wanted. Between two kicks the scheme's
//   path
//           is straight, so these are the scheme's own
//   trial   counts in the random draws
//   errors  as PlanScene; kBadInput  times that do not ascend from 0 or go beyond the duration, a state of
//           another scene; kUnreachable  kStatic found no equilibrium (statics.h)
Result<Simulated> Simulate(const Scene& scene, const SimulationPlan& plan, const std::vector<double>& times,
                           std::uint64_t trial = 0, const SimulateHooks& hooks = {});

}  // namespace tendril
