#pragma once
// Which views of a chain to believe. Internal to SolveChain (chain_solve.h); docs/tracking.md, "Judgement".

#include "capture/track/chain_descent.h"

namespace tendril {

// Views are in or out: once the robust fit has settled, the final fit and its covariance use the good ones in
// full. The worst go first, one in a neighbourhood at a time, because a bad view spoils what its neighbours
// predict; one that was blamed wrongly comes back.
void DecideViews(const ChainProblem& problem, Descent& run);

}  // namespace tendril
