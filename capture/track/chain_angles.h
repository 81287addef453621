#pragma once
// How well each fold angle is known, and how much of that the pictures tell. What they leave open, what is
// expected of the creases fills, and nobody could tell from the angles alone (docs/tracking.md, "Which fold
// angles are known"). Internal to SolveChain (chain_solve.h).

#include "capture/track/chain_descent.h"

namespace tendril {

struct AngleKnowledge {
  Eigen::VectorXd sigma;        // of phi_i, rad                                                   (creases)
  Eigen::VectorXd by_pictures;  // share of what is known of phi_i that pictures tell, 0 to 1      (creases)
};

// At a fit's end.
//   cholesky   of the fit's matrix
//   inflation  by which covariances grow where the misfit is larger than the sigmas explain
AngleKnowledge KnowledgeOfAngles(const ChainProblem& problem, const Descent& run,
                                 const ChainCholesky& cholesky, double inflation);

}  // namespace tendril
