#pragma once
// What an error of the cameras' calibration does to a chain. Internal to SolveChain (chain_solve.h).

#include "capture/track/chain_descent.h"

namespace tendril {

// How the facets' poses (w, v: chain_factors.h) move with each of the cameras' errors at one standard
// deviation, rad and m. A camera's error is a smooth field of pixel shifts over its picture that all of its
// views share: in x and in y each a constant and a slope along either side, together
// options.sigma_calibration_px per coordinate on the average over the picture. The chain's answer is kept;
// only what it owes to the cameras is told.
//                                                                                     (6 facets, 6 cameras)
Eigen::MatrixXd PosesByCalibration(const ChainProblem& problem, const Descent& run,
                                   const ChainCholesky& cholesky);

}  // namespace tendril
