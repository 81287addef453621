#pragma once
// What `tendril simulate` writes of a run: curves, film, picture, and the trial in a lab.

#include <optional>
#include <string>

#include "cli/command.h"
#include "cli/simulate_call.h"
#include "cli/simulate_verdict.h"
#include "model/scene/simulate.h"

namespace tendril::cli {

// A run with all that is to be told of it.
struct FinishedRun {
  const Scene* scene = nullptr;
  std::string scene_text{};
  const SimulationPlan* plan = nullptr;
  const Simulated* run = nullptr;  // with a frame or more
  std::optional<HoldingVerdict> holding{};
  double wall_s = 0;
  std::string run_key{};  // as RunKey; of a run that is to be kept in a lab
};

// Curves, links, film, picture and trial, as far as they were asked for; says what it wrote.
//   errors  as WriteCurves, TellLink, StoreSimulatedTrial, WriteSceneVideo
Status WriteOutputs(const SimulateCall& call, const FinishedRun& finished, Output& out);

}  // namespace tendril::cli
