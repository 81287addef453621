#pragma once
// What `tendril calibrate fold` says about models: the table of a comparison, a parameter's profile.

#include <optional>
#include <span>
#include <string>

#include "calibrate/fold/fold_fit.h"
#include "capture/rig/virtual_truth.h"
#include "cli/command.h"

namespace tendril::cli {

// Compares all models that are worth it, prints table and verdict; JSON: `comparisons`.
//   returns  the fit of the model that the data ask for, with its hint
//   errors   as CompareFoldModels
Result<FoldFit> CompareModels(std::span<const FoldObservation> observations, const FoldFitOptions& options,
                              const std::string& design, const std::optional<TrueFold>& truth, Output& out);

// Draws a parameter's profile as text; JSON: `profiles`.
//   errors  as ProfileFold
Status ShowProfile(std::span<const FoldObservation> observations, const FoldFitOptions& options,
                   const std::string& parameter, const std::string& design, Output& out);

}  // namespace tendril::cli
