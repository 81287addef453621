#pragma once
// A symmetric block-tridiagonal system, one block per facet: what a chain's least squares lead to. Solved,
// and its inverse taken where it is needed, in time linear in the facets.

#include <vector>

#include "capture/track/chain_factors.h"

namespace tendril {

struct ChainMatrix {
  std::vector<FacetMatrix> diagonal;  // (facets)
  std::vector<FacetMatrix> below;     // below[i]: rows of facet i+1, columns of facet i (facets - 1)
};

struct NearCovariance {
  FacetMatrix own;
  FacetMatrix next = FacetMatrix::Zero();  // rows of this facet, columns of the next
};

class ChainCholesky {
 public:
  // Of matrix + damping * (its diagonal). ok() is false unless that is positive definite.
  explicit ChainCholesky(const ChainMatrix& matrix, double damping = 0);

  bool ok() const { return ok_; }

  // x with matrix * x = right.                                                        (facets)
  std::vector<FacetVector> Solve(const std::vector<FacetVector>& right) const;

  // Covariance of each facet's step, and with that of the facet after it.         (facets)
  std::vector<NearCovariance> NearCovariances() const;

  // Covariance of all facets' pose steps (w, v).                                    (6 facets, 6 facets)
  Eigen::MatrixXd PoseCovariance() const;

 private:
  bool ok_ = false;
  std::vector<Eigen::LLT<FacetMatrix>> factor_;
  std::vector<FacetMatrix> coupling_;  // L_{i+1,i}
};

}  // namespace tendril
