#pragma once
// Which fold model do the observed shapes ask for? (docs/calibration.md, "Which model")

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calibrate/fold/fold_fit.h"

namespace tendril {

struct ComparedModel {
  FoldModel model;
  std::optional<FoldFit> fit;  // none: `why_not`; the chosen one's has its hint
  std::string why_not;
  // Of hole distances of trials that the parameters were not fitted to, leave-one-trial-out: root mean square
  // under Huber's loss, m. NaN with one trial.
  double held_out = kUnknownError;
  std::vector<double> held_out_by_trial;  // mean loss per row, sigmas^2; by the trials' names (trials)
  // Mean of the trials' differences of loss from the best model's, and its standard error, as shares of the
  // best model's loss. 0 and 0 for the best.
  double behind = kUnknownError;
  double behind_error = kUnknownError;
  // Of the fitted shapes: (loss / inflation + 2 parameters) less the least of all models'; the loss is the
  // sum of HuberLoss over the rows, sigmas^2.
  double aic_difference = kUnknownError;

  static constexpr double kUnknownError = std::numeric_limits<double>::quiet_NaN();
};

struct FoldComparison {
  std::vector<ComparedModel> models;  // as they were asked for
  int best = -1;                      // least held-out error (with one trial: least AIC); -1: none was fitted
  int chosen = -1;                    // the fewest parameters not clearly behind the best
  std::vector<std::string> verdict;   // plain sentences
  // Rows of one trial err together: so much loss counts as that of one independent row of sigma 1.
  double inflation = 1;
  int trials = 0;
  long rows = 0;
  double seconds = 0;
};

struct FoldComparisonOptions {
  FoldFitOptions fit;  // its model does not count
  std::vector<FoldModel> models = ComparableFoldModels();
  // A model is clearly behind if the trials' mean difference of held-out loss is so many standard errors from
  // 0.
  double clear = 2;
  // Friction is not tried with a law whose loss is this share above the other law's, and clearly so: it would
  // take most of the time and win nothing.
  double hopeless = 0.25;
};

// Fits each model to all trials, then asks each trial of the parameters that the other trials alone would
// have given: those are taken to first order from the fit to all (exact for a linear model; a test compares
// them with real refits). The trial's own lags and free pulls are fitted to it, since nothing else can tell
// them. Models are compared on the same curves, with one Huber length for all.
//   errors  as FitFold, if every model fails so; kStopped
Result<FoldComparison> CompareFoldModels(std::span<const FoldObservation> observations,
                                         const FoldComparisonOptions& options, const Progress& progress = {});

}  // namespace tendril
