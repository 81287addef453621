#pragma once
// How sure is the direction of a curve's normals? A normal is square to the curve, so that of its error only
// a turn about the tangent is its own; the rest is the centerline's. Internal to SolveChain (chain_solve.h).
//
// SI units, rad; facets, holes and nodes are numbered from the base.

#include <Eigen/SparseCore>
#include <vector>

#include "capture/track/chain_factors.h"

namespace tendril {

// From the facets' pose steps (w, v: chain_factors.h) to what they do to the curve of CurveOfFacets: the
// points in the lab, m, and then the turn of each normal about the curve, right-handed about the tangent from
// base to tip, rad. First order, within 3 % up to a pull of 0.4; rough (30 %) at nodes whose creases close.
//                                                                              (3 holes + holes, 6 facets)
Eigen::SparseMatrix<double> CurveOfSteps(const TentacleLayout& layout, const std::vector<FacetState>& facets);

}  // namespace tendril
