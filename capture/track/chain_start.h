#pragma once
// Where the chain's solver starts: a first guess of every facet's pose that lies in the right valley.
//
// A square tag seen by one camera has two poses that look nearly alike, and some tags are misread. So each
// facet gets several candidate poses, each refined on all views of the facet, and the chain from the base
// chooses among them, or passes over a facet, by how well neighbours meet at their crease.

#include <span>
#include <vector>

#include "capture/track/chain_solve.h"

namespace tendril {

// One pose that a facet might have, by its own tags alone.
struct FacetCandidate {
  FacetState state;
  Eigen::Matrix<double, 6, 6> covariance;  // of a step (w, v) of the facet
  double cost = 0;                         // misfit of the facet's views, each view's bounded
};

// Candidates of each facet, best first, at most `most` of them.                                     (facets)
std::vector<std::vector<FacetCandidate>> CandidatesOfFacets(const ChainModel& model,
                                                            std::span<const Camera> cameras,
                                                            std::span<const TagView> views,
                                                            const ChainOptions& options, int most = 4);

// The fold law's shape at the gripper.
std::vector<FacetState> NominalChain(const ChainModel& model);

// The chosen candidates, joined by the fold law's angles where nothing was chosen.
//   doubt  how far a crease may be off the fold law's angle, rad: large where creases are seen, smaller
//          where the law has to tell which of two poses is meant beyond a long gap
std::vector<FacetState> StartOfChain(const ChainModel& model,
                                     const std::vector<std::vector<FacetCandidate>>& candidates,
                                     const ChainOptions& options, double doubt);

}  // namespace tendril
