#pragma once
// What `calibrate fold` says about a fit: parameters, intervals, hint; and the design file that it writes.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calibrate/fold/fold_fit.h"
#include "calibrate/fold/view_places.h"
#include "capture/rig/virtual_truth.h"
#include "cli/command.h"
#include "model/fold/design.h"

namespace tendril::cli {

inline constexpr std::string_view kFittedDesign = "# Design ";  // how its file begins

// Of FoldParameterNames(); NaN: not known.
double TrueValue(const std::optional<TrueFold>& truth, const std::string& parameter);

// Prints the fit and adds it to the field `fits`. truth: of virtual trials.
void ShowFit(const std::string& design, const FoldFit& fit, const std::optional<TrueFold>& truth,
             double confidence, const ViewPlaces& places, Output& out);

// The design with what was fitted in place of what was drawn, for scenes and sweeps.
Status WriteFittedDesign(const std::string& file, TentacleDesign design, const FoldFit& fit,
                         const std::string& name, const std::vector<std::string>& trials, double confidence);

}  // namespace tendril::cli
