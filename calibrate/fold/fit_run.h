#pragma once
// A fit together with what it was made from, for those who go on from it: comparison, profile, hint.
// Internal to calibrate/fold.

#include <array>
#include <optional>
#include <span>

#include "calibrate/fold/fit_frames.h"
#include "calibrate/fold/fit_information.h"
#include "calibrate/fold/fit_solver.h"
#include "calibrate/fold/fold_fit.h"

namespace tendril {

struct FitRun {
  FoldFit fit;
  FitFrames frames;  // points into the caller's observations
  Solution solution;
  HeldParameters held{};
  HeldParameters at_bound{};
  Information information;
  double huber = 0;
};

//   errors  as FitFold
Result<FitRun> RunFit(std::span<const FoldObservation> observations, const FoldFitOptions& options,
                      const Progress& progress);

// A parameter as people read it (ratio, degrees) and as it is fitted (ln ratio, rad).
double ShownValue(int parameter, double fitted);
double FittedValue(int parameter, double shown);

}  // namespace tendril
