#pragma once
// What the rest of the program wants of a chain of facets: its framed curve, and a factor of the holes'
// covariance that is small enough to keep with every frame.

#include <vector>

#include "capture/track/chain_factors.h"
#include "model/fold/facet_chain.h"
#include "model/geometry/framed_curve.h"

namespace tendril {

// Nodes are the holes; normals as NodesAtHoles defines them (model/fold/facet_chain.h): the mean of the two
// neighbouring segments' d1, each the mean of its two facets' normals, turned by half the fold about the
// crease.
FramedCurve CurveOfFacets(const TentacleLayout& layout, const std::vector<FacetState>& facets);

// The same curve's segments: lengths and frames (no turning). Two facets or more.
TendonCurve SegmentsOfFacets(const TentacleLayout& layout, const std::vector<FacetState>& facets);

// Points and the turns of their normals are drawn together: points move by F z, normals turn by G z.
// F F^T is close to the points' covariance: the largest part by pivoted Cholesky, the rest as an error of
// each node for itself. A node's own 3 x 3 block is exact. All nodes share 12 columns for that rest, each
// turned its own way, which adds correlations of either sign between nodes, of 0.3 of the rest. G has more
// columns than F (z goes on). A turn's own variance is exact, as is what it has in common with the largest
// part of F.
struct CurveFactors {
  Eigen::MatrixXd
      points;  // F, m                                                              (3 nodes, rank)
  Eigen::MatrixXd
      turns;  // G, rad                                                        (nodes, rank + more)
};

//   covariance  of the points and then of the turns, as CurveOfSteps has them                (4 nodes square)
//   rank        columns of F, at least 12; no more than 3 nodes are made
CurveFactors FactorsOfCurve(const Eigen::MatrixXd& covariance, int rank);

}  // namespace tendril
