#pragma once
// The fold fit as Ceres sees it: one residual block per frame, the parameters that all share, and a lag or
// a free pull per tentacle or frame, eliminated first. Internal to calibrate/fold.

#include <string>
#include <vector>

#include "calibrate/fold/fit_frames.h"
#include "calibrate/fold/fit_information.h"
#include "model/progress.h"
#include "model/result.h"

namespace tendril {

// What a solve starts from and ends at.
struct Solution {
  SharedVector parameters = SharedVector::Zero();
  std::vector<double> nuisances;
  int iterations = 0;
  bool converged = false;
  std::string message;
};

struct Solving {
  const FoldFitOptions& options;
  const Progress& progress;
  double from = 0;  // share of all the work that is done before this solve, and after
  double to = 1;
  int most_iterations = 40;  // where the cost has kinks
};

// Moves the solution to the least cost. huber: as InformationAt.
//   errors  kStopped: progress said so; kIo: the solver threw
Status SolveFit(const FitFrames& frames, const HeldParameters& held, double huber, const Solving& how,
                Solution& solution);

}  // namespace tendril
