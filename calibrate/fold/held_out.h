#pragma once
// How far a model is from trials that its parameters were not fitted to. Internal to calibrate/fold.

#include <optional>
#include <vector>

#include "calibrate/fold/fit_run.h"

namespace tendril {

// |r| of every group of rows of one trial, sigmas, by the curve that they belong to.
struct TrialMisfit {
  std::vector<std::size_t> observation;       // the curves                     (curves)
  std::vector<std::vector<double>> residual;  //                                (curves, rows)
};

// Of each trial at the parameters of the fit to all of them, and at those which the others alone would give.
struct Misfits {
  std::vector<TrialMisfit> fitted, held_out;  // (trials)
};

Misfits MisfitsOf(const FitRun& run, const FoldFitOptions& options);

// The parameters that the other trials alone would give, to first order.
SharedVector ParametersWithout(const FitRun& run, std::size_t trial);

// Fits a trial's lags and free pulls to its own frames at given parameters.
std::vector<double> NuisancesAt(const FitRun& run, std::size_t trial, const SharedVector& parameters,
                                const FoldFitOptions& options);

// Mean square of a row, sigmas^2, under Huber's loss: 2 rho.
double HuberLoss(double residual, double huber);

}  // namespace tendril
