#pragma once
// What `report --json` says: the figures that the page shows.

#include <nlohmann/json.hpp>

#include "cli/report_facts.h"

namespace tendril::cli {

nlohmann::ordered_json FactsAsJson(const TrialFacts& facts);

}  // namespace tendril::cli
