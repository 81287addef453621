#pragma once
// The demo's figures.

#include <filesystem>
#include <string>
#include <vector>

#include "cli/demo_study.h"
#include "db/trial_query.h"
#include "model/result.h"

namespace tendril::cli {

// Success rate over distance, one series per design, with Wilson intervals. `groups` by design, distance.
Status PlotRates(const std::vector<RateGroup>& groups, const std::filesystem::path& file);

// A trial's centerlines at the end, tracked (seen nodes) over true, from the side and from below.
Status PlotCenterlines(const std::filesystem::path& trial_folder, const std::string& title,
                       const std::filesystem::path& file);

// A trial's object link and self-link over time, as tracked.
Status PlotLinks(const std::filesystem::path& trial_folder, const std::string& title,
                 const std::filesystem::path& file);

}  // namespace tendril::cli
