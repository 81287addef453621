#pragma once
// A simulated trial kept in a lab: its scene, curves, links and what the run says of itself.

#include <string>

#include "analysis/link/link_series.h"
#include "db/lab.h"
#include "model/scene/simulate.h"

namespace tendril::cli {

struct SimulatedTrial {
  std::string scene_file{};
  std::string scene_text{};  // as it was run
  std::string label{};       // empty: made up
  const Scene* scene = nullptr;
  const SimulationPlan* plan = nullptr;
  const Simulated* run = nullptr;
  const LinkSeries* links = nullptr;
  std::uint64_t trial_number = 0;
  double wall_s = 0;
};

// What a trial of that scene is called by in the lab.
//   errors  kBadInput  a scene without a gripper: a trial has one
Status CheckIsTrial(const Scene& scene);

// A trial of kind `simulated`; one that diverged is in state `failed`, with what it reached.
//   returns  its label
//   errors   as CheckIsTrial, BeginTrial, WriteCurves
Result<std::string> StoreSimulatedTrial(Lab& lab, const SimulatedTrial& trial);

}  // namespace tendril::cli
