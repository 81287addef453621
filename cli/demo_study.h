#pragma once
// The demo's experiment: two designs, three object distances, several repeats each, on the virtual rig. What
// is tried, how each trial goes from recording to outcome, and how the results compare with the hidden truth.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "capture/rig/virtual_truth.h"
#include "db/files/trial_toml.h"
#include "db/lab.h"
#include "model/progress.h"
#include "model/result.h"

namespace tendril::cli {

struct DemoOptions {
  std::filesystem::path folder = "demo-lab";
  int repeats = 4;  // per design and distance
  int frames = 6;   // per trial and camera
  std::uint64_t seed = 1;
  int threads = 2;  // trials worked on at once
};

// A trial succeeds if the mean |object link| of its true final shapes reaches this; turns.
inline constexpr double kGraspedLink = 0.5;

struct DemoDesign {
  std::string name;
  TentacleDesign design;  // as drawn: what tracker and fit start from
  std::string rig_toml;
};

struct DemoTrial {
  int design = 0;  // index into DemoPlan::designs
  TrialSpec spec;
  std::uint64_t seed = 0;
};

struct DemoPlan {
  std::vector<DemoDesign> designs;
  std::vector<DemoTrial> trials;
  TrueFold truth;  // the hidden fold parameters, drawn from the seed
};

// Errors of centerlines against the truth: sums over nodes, so that trials add up.
struct CenterlineError {
  double squares = 0;  // of distances, m^2, nodes whose facet was seen
  std::int64_t nodes = 0;
  double all_squares = 0;  // of all nodes, bridged and not seen ones included
  std::int64_t all_nodes = 0;

  void Add(const CenterlineError& other);
  double Rms() const;     // m; NaN without a node
  double AllRms() const;  // m
};

struct DemoTrialResult {
  std::string id;
  bool grasped = false;
  double true_object_link = 0;  // mean |object link| of the true final shapes, turns
  CenterlineError error;
};

//   errors  as LayOut and VirtualRig
Result<DemoPlan> PlanDemo(const DemoOptions& options);

// Makes the lab's folder anew. A folder that is there is replaced only if a demo made it.
//   errors  kBadInput: the folder holds something else (it is left as it is); kIo
Status PrepareDemoFolder(const std::filesystem::path& folder);

// Records, tracks, scores and judges all trials, `threads` at a time; results in the plan's order.
//   errors  the first trial's that failed; kStopped
Result<std::vector<DemoTrialResult>> RunDemoTrials(const std::filesystem::path& lab, const DemoPlan& plan,
                                                   const DemoOptions& options, const Progress& progress);

}  // namespace tendril::cli
