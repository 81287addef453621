#pragma once
// At which pull would one more trial tell most about the least known parameter, and would another view tell
// more? Internal to calibrate/fold.

#include <optional>

#include "calibrate/fold/fit_run.h"

namespace tendril {

// From the expected information of one more trial like those made, held at each candidate pull. None: no
// trial has a settled curve at a pull above 0, or nothing is identified.
std::optional<PullHint> HintOf(const FitRun& run, const FoldFitOptions& options);

}  // namespace tendril
