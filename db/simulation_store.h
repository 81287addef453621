#pragma once
// What a simulated trial's run says of itself, beside the scene it was run from.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "db/lab.h"
#include "db/provenance.h"
#include "db/trial_store.h"
#include "model/result.h"

namespace tendril {

// How the grasp that a simulation made was tested (model/scene/holding.h).
struct HoldingRow {
  std::string test{};   // lift, load, strike, release
  bool lifted = false;  // rose with the carrier and stayed
  bool held = false;    // what the test asks; of release: let go
  double rise_m = kNotKnown;
  double shift_m = kNotKnown;
  double payload_kg = kNotKnown;  // of load
  bool payload_is_least = false;  // the largest load did not slip it
  double payload_by_rods_mass = kNotKnown;
  std::optional<std::int64_t> strikes{};  // of strike: that it withstood
  double release_s = kNotKnown;           // of release
  std::string rule{};                     // what counts as success, in words
  double begins_s = kNotKnown;            // when the lift begins; what is before is the grasp alone
};

struct SimulationRow {
  std::string scene_name{};
  std::string scene_toml{};
  std::string level{};
  std::int64_t seed = 1;
  std::int64_t trial_number = 0;
  double time_step_s = 0;  // 0: no steps, equilibria
  std::int64_t steps = 0;
  double simulated_s = 0;
  double wall_s = 0;
  std::string terms_json = "[]";
  double least_axis_distance_m = kNotKnown;
  double least_axis_share = kNotKnown;
  double longest_move_m = kNotKnown;
  std::optional<bool> nothing_passed{};
  std::string divergence{};           // empty: it did not diverge
  std::vector<std::string> doubts{};  // why it is not trusted, a line each; none: it is
  double longest_stick_share = kNotKnown;
  double friction = kNotKnown;  // of the scene's contact
  std::string medium{};         // as the trial's; empty: not known
  std::string run_key{};        // runs of one key are one run; empty: not known
  std::optional<HoldingRow> holding{};
};

// Replaces the trial's row and that of its test of holding; the scene is found by its text or added.
//   errors  kNotFound no such trial; kBadInput provenance or terms that are no JSON; kIo
Status StoreSimulation(Lab& lab, const std::string& id, const SimulationRow& row,
                       const Provenance& provenance);

// Of a trial, with what was read of its scene; none: it is no simulation.
struct StoredSimulation {
  SimulationRow row;
  bool trusted = true;
};
Result<std::optional<StoredSimulation>> LoadSimulation(Lab& lab, const std::string& id);

// The label of the newest trial that is that run by that program, through to its end and not void; none: it
// is not in the lab.
Result<std::optional<std::string>> FindRun(Lab& lab, const std::string& run_key,
                                           const std::string& program_version);

}  // namespace tendril
