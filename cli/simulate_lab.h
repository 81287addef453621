#pragma once
// A simulated trial kept in a lab: its scene, curves, links, what the run says of itself, and how the grasp
// was tested.

#include <optional>
#include <string>

#include "analysis/link/link_series.h"
#include "cli/simulate_call.h"
#include "cli/simulate_outputs.h"
#include "db/lab.h"

namespace tendril::cli {

struct SimulatedTrial {
  const SimulateCall* call = nullptr;
  const FinishedRun* finished = nullptr;
  const LinkSeries* links = nullptr;
  std::string run_key{};
};

// What a trial of that scene is called by in the lab.
//   errors  kBadInput  a scene without a gripper: a trial has one
Status CheckIsTrial(const Scene& scene);

// What makes a run that run: what of its scene counts, design, level, trial's number, test and --full. Runs
// of one key, by one version of the program, come to the same.
//   scene_text  TOML; its comments, layout and name do not count
//   errors      as BareToml
Result<std::string> RunKey(const SimulateCall& call, const Scene& scene, const std::string& scene_text);

// The label of the trial that is that run already, by this version of the program; none: it is not in the
// lab.
Result<std::optional<std::string>> TrialOfRun(Lab& lab, const std::string& run_key);

// A trial of kind `simulated`; one that diverged is in state `failed`, with what it reached. A test of
// holding becomes an outcome by the program (HoldingResult::Grasped), which any person's overrules.
//   returns  its label
//   errors   as CheckIsTrial, BeginTrial, WriteCurves
Result<std::string> StoreSimulatedTrial(Lab& lab, const SimulatedTrial& trial);

}  // namespace tendril::cli
