#pragma once
// The link metrics of a tracked trial, measured on its curves and kept in the lab.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "analysis/link/link_series.h"
#include "db/files/trial_toml.h"
#include "db/lab.h"
#include "model/progress.h"
#include "model/result.h"

namespace tendril::cli {

// The curves of a trial's folder as they are to be measured against the axis that trial.toml states: where
// curves.h5 says that the object moved, as that sees them.
//   errors  as ReadCurves, ReadObjectsOverTime
Result<std::vector<CurveSeries>> CurvesAboutObject(const std::filesystem::path& folder,
                                                   const TrialSpec& trial);

// The axis of the object as trial.toml states it; none of a sphere, nor of what a simulation knows as a box
// or a union of parts.
std::optional<Axis> AxisOf(const TrialSpec& trial);

// Measures every frame of the trial's curves.h5 and stores the rows with what they were made from.
// `options.axis` is replaced by the object's. The end is the last frame; of a simulation that tested the
// grasp, the last before the test.
//   errors  kNotFound the trial has no curves yet (says to track it first); as MeasureLinkSeries
Result<LinkSeries> ScoreTrial(Lab& lab, const std::string& trial_id, LinkOptions options = {},
                              const Progress& progress = {});

}  // namespace tendril::cli
