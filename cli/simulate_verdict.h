#pragma once
// What a run is told by first: how its test of holding ended or, without one, what became of each object that
// moves.

#include <string>

#include "cli/command.h"
#include "model/scene/holding.h"
#include "model/scene/simulate.h"

namespace tendril::cli {

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
  double begins = 0;       // s, when the lift begins
};

//   errors  as JudgeHolding, MakeRods
Result<HoldingVerdict> TellHolding(const Scene& scene, const HoldingPlan& plan, const Simulated& done,
                                   Output& out);

// A line for each object that moves: whether rods bear it, touch it, or it fell. No test was made: what is
// borne may be borne for a moment only.
//   run  with a frame or more
void TellWithoutTest(const Scene& scene, const Simulated& run, Output& out);

// What such a line says of an object: from its last half second.
std::string FateOf(const Scene& scene, const Simulated& run, std::size_t object);

}  // namespace tendril::cli
