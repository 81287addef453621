#include "cli/stored_simulation.h"

#include <cmath>

#include "cli/command.h"

namespace tendril::cli {
namespace {

using Json = nlohmann::ordered_json;

Json JsonOf(const HoldingRow& holding) {
  return {{"test", holding.test},
          {"lifted", holding.lifted},
          {"held", holding.held},
          {"rise_m", NumberOrNull(holding.rise_m)},
          {"shift_m", NumberOrNull(holding.shift_m)},
          {"payload_kg", NumberOrNull(holding.payload_kg)},
          {"payload_is_least", holding.payload_is_least},
          {"payload_by_rods_mass", NumberOrNull(holding.payload_by_rods_mass)},
          {"strikes", holding.strikes ? Json(*holding.strikes) : Json(nullptr)},
          {"release_s", NumberOrNull(holding.release_s)},
          {"rule", holding.rule}};
}

void PrintHolding(const HoldingRow& holding, Output& out) {
  out.Print("  then {}: {}", holding.test,
            holding.test == "release" ? (holding.held ? "let go" : "not let go")
                                      : (holding.held ? "held" : "not held"));
  out.Print("    counts as a grasp if, {}: {}", holding.rule, holding.lifted ? "lifted" : "not lifted");
  if (std::isfinite(holding.rise_m)) out.Print("    rose by {:.1f} mm", 1e3 * holding.rise_m);
  if (std::isfinite(holding.shift_m)) out.Print("    then moved by up to {:.1f} mm", 1e3 * holding.shift_m);
  if (std::isfinite(holding.payload_kg)) {
    out.Print("    payload {:.0f} g{}, {:.1f} times the rods' mass", 1e3 * holding.payload_kg,
              holding.payload_is_least ? " or more" : "", holding.payload_by_rods_mass);
  }
  if (holding.strikes) out.Print("    withstood {} strikes", *holding.strikes);
  if (std::isfinite(holding.release_s)) out.Print("    let go after {:.2f} s", holding.release_s);
}

}  // namespace

nlohmann::ordered_json SimulationAsJson(const StoredSimulation& simulation) {
  const SimulationRow& row = simulation.row;
  return {{"scene", row.scene_name},
          {"level", row.level},
          {"seed", row.seed},
          {"trial_number", row.trial_number},
          {"friction", NumberOrNull(row.friction)},
          {"medium", row.medium.empty() ? Json(nullptr) : Json(row.medium)},
          {"time_step_s", row.time_step_s},
          {"steps", row.steps},
          {"simulated_s", row.simulated_s},
          {"wall_s", row.wall_s},
          {"trusted", simulation.trusted},
          {"doubts", row.doubts},
          {"nothing_passed", row.nothing_passed ? Json(*row.nothing_passed) : Json(nullptr)},
          {"least_axis_share", NumberOrNull(row.least_axis_share)},
          {"longest_stick_share", NumberOrNull(row.longest_stick_share)},
          {"divergence", row.divergence.empty() ? Json(nullptr) : Json(row.divergence)},
          {"holding", row.holding ? JsonOf(*row.holding) : Json(nullptr)}};
}

void PrintSimulation(const StoredSimulation& simulation, Output& out) {
  const SimulationRow& row = simulation.row;
  out.Print("simulation of scene {}, level {}, {:.6g} s in {:.3g} s{}{}", row.scene_name, row.level,
            row.simulated_s, row.wall_s,
            std::isfinite(row.friction) ? fmt::format(", friction {:.4g}", row.friction) : "",
            row.medium.empty() ? "" : ", in " + row.medium);
  out.Print("  {}", simulation.trusted ? "trusted: nothing speaks against the run"
                                       : "not trusted, and left out of rates unless asked:");
  for (const std::string& doubt : row.doubts) out.Print("    {}", doubt);
  if (row.holding) PrintHolding(*row.holding, out);
}

}  // namespace tendril::cli
