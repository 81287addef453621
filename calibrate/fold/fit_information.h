#pragma once
// What the frames say about the parameters: information and score per trial, the covariances that
// follow, and which parameters no data here can pin down. Internal to calibrate/fold.

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "calibrate/fold/fit_frames.h"

namespace tendril {

using HeldParameters = std::array<bool, kShared>;

// One trial's share at the given parameters, after its lags and free pulls have been eliminated.
struct TrialInformation {
  SharedMatrix information = SharedMatrix::Zero();  // sum of psi' J^T J
  SharedVector score = SharedVector::Zero();        // sum of J^T psi(r)
};

struct Information {
  std::vector<TrialInformation> trials;
  SharedMatrix total = SharedMatrix::Zero();
  double row_variance = 0;  // mean psi^2 per row, in sigmas^2
  double repeats = 1;       // times that a node's error enters the rows
};

// huber: length of a group of residuals beyond which it counts linearly; infinity: never.
Information InformationAt(const FitFrames& frames, const SharedVector& parameters,
                          const std::vector<double>& nuisances, const ShapeResidualOptions& options,
                          double huber);

// Inverse of the information of the free parameters, times the variance of a row; NaN for held ones.
SharedMatrix NaiveCovariance(const Information& information, double row_variance, const HeldParameters& held);

// Linearised delete-one-trial jackknife: (G - 1) / G sum_g D_g D_g^T, D_g = (H - H_g)^-1 s_g. For trials that
// weigh alike it is the sandwich H^-1 (sum s_g s_g^T) H^-1 times G / (G - 1); for others it is larger.
// Needs two trials or more; NaN where a parameter hangs on one trial alone.
// at_bound: parameters that rest at their bound: their scores do not sum to 0, so they are taken from their
// mean.
SharedMatrix ClusteredCovariance(const Information& information, const HeldParameters& held,
                                 const HeldParameters& at_bound = {});

// How the estimate moves when a trial is left out, to first order: D_g, 0 for held parameters.
SharedVector ChangeWithout(const Information& information, std::size_t trial, const HeldParameters& held,
                           const SharedVector& mean_score = SharedVector::Zero());

struct Unidentified {
  int parameter = 0;
  double standard_error = 0;  // that it would have, infinity if the data say nothing
  int twin = -1;              // the parameter it cannot be told from; -1: none
};

// Parameters to hold, worst first: as long as some direction in parameter space would have a standard
// error above half of what is plausible beforehand (pull_scale 0.2, ln ratio 1, exponent 1, rest angle 0.34
// rad, friction 0.5), the parameter that has most of that direction goes.
std::vector<Unidentified> FindUnidentified(const Information& information, double row_variance,
                                           HeldParameters held);

// Largest standard error with which a parameter still counts as identified (pull_scale, ln ratio, exponent,
// rest angle in rad, friction).
const std::array<double, kShared>& LargestStandardErrors();

}  // namespace tendril
