#pragma once
// What a simulated trial's run says of itself, beside the scene it was run from.

#include <cstdint>
#include <optional>
#include <string>

#include "db/lab.h"
#include "db/provenance.h"
#include "db/trial_store.h"
#include "model/result.h"

namespace tendril {

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
  std::string divergence{};  // empty: it did not diverge
};

// Replaces the trial's row; the scene is found by its text or added.
//   errors  kNotFound no such trial; kBadInput provenance or terms that are no JSON; kIo
Status StoreSimulation(Lab& lab, const std::string& id, const SimulationRow& row,
                       const Provenance& provenance);

}  // namespace tendril
