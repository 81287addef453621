#pragma once
// What a lab keeps of a simulated trial's run, for `tendril trials show`.

#include "cli/command.h"
#include "db/simulation_store.h"

namespace tendril::cli {

nlohmann::ordered_json SimulationAsJson(const StoredSimulation& simulation);
void PrintSimulation(const StoredSimulation& simulation, Output& out);

}  // namespace tendril::cli
