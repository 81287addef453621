#pragma once
// How much worse do the shapes fit as one parameter is moved away from its estimate and all others follow?
// The honest interval where the estimate rests at a bound or the cost is lopsided (docs/calibration.md,
// "Profiles").

#include <span>
#include <string>
#include <vector>

#include "calibrate/fold/fold_fit.h"

namespace tendril {

struct FoldProfile {
  std::string name;
  FoldFit fit;
  std::vector<double> value;     // ascending, of the parameter as FittedParameter shows it
  std::vector<double> deviance;  // rise of the cost in squared standard errors: 0 at the estimate
  double threshold = 0;          // deviance at the ends of the interval: Student's t, squared
  // NaN: the profile does not reach the threshold on that side, or a frame's pull would be out of reach
  // first.
  FittedParameter::Interval interval;
  bool from_bound = false;  // the interval begins at the parameter's least value, 0
};

// The cost's rise is divided by what the clustering adds to this parameter's variance, so that near the
// estimate the deviance is (value - estimate)^2 / SE^2.
//   name    of FoldParameterNames(), and one of the model's
//   errors  kBadInput: not the model's parameter, or one that the data do not identify;
//           as FitFold
Result<FoldProfile> ProfileFold(std::span<const FoldObservation> observations, const FoldFitOptions& options,
                                const std::string& name, const Progress& progress = {});

}  // namespace tendril
