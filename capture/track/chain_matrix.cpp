#include "capture/track/chain_matrix.h"

#include "model/check.h"

namespace tendril {

ChainCholesky::ChainCholesky(const ChainMatrix& matrix, double damping) {
  const std::size_t facets = matrix.diagonal.size();
  TENDRIL_CHECK(facets >= 1 && matrix.below.size() == facets - 1);
  factor_.reserve(facets);
  coupling_.reserve(facets - 1);
  for (std::size_t i = 0; i < facets; ++i) {
    FacetMatrix pivot = matrix.diagonal[i];
    pivot.diagonal() *= 1 + damping;
    if (i > 0) pivot -= coupling_[i - 1].lazyProduct(coupling_[i - 1].transpose());
    factor_.emplace_back(pivot);
    if (factor_.back().info() != Eigen::Success) return;
    if (i + 1 < facets) {
      const FacetMatrix coupling = factor_.back().matrixL().solve(matrix.below[i].transpose()).transpose();
      coupling_.push_back(coupling);
    }
  }
  ok_ = true;
}

std::vector<FacetVector> ChainCholesky::Solve(const std::vector<FacetVector>& right) const {
  TENDRIL_CHECK(ok_ && right.size() == factor_.size());
  const std::size_t facets = factor_.size();
  std::vector<FacetVector> x = right;
  for (std::size_t i = 0; i < facets; ++i) {
    if (i > 0) x[i] -= coupling_[i - 1] * x[i - 1];
    factor_[i].matrixL().solveInPlace(x[i]);
  }
  for (std::size_t i = facets; i-- > 0;) {
    if (i + 1 < facets) x[i] -= coupling_[i].transpose() * x[i + 1];
    factor_[i].matrixU().solveInPlace(x[i]);
  }
  return x;
}

std::vector<NearCovariance> ChainCholesky::NearCovariances() const {
  TENDRIL_CHECK(ok_);
  std::vector<NearCovariance> near(factor_.size());
  for (std::size_t i = factor_.size(); i-- > 0;) {  // as in PoseCovariance
    NearCovariance& here = near[i];
    here.own = factor_[i].solve(FacetMatrix::Identity());
    if (i + 1 == factor_.size()) continue;
    const FacetMatrix transposed = factor_[i].matrixU().solve(coupling_[i].transpose());
    here.next = -transposed.lazyProduct(near[i + 1].own);
    here.own -= here.next.lazyProduct(transposed.transpose());
    here.own = 0.5 * (here.own + here.own.transpose()).eval();
  }
  return near;
}

Eigen::MatrixXd ChainCholesky::PoseCovariance() const {
  constexpr int kPose = 6;
  TENDRIL_CHECK(ok_);
  const int facets = static_cast<int>(factor_.size());
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(kPose * facets, kPose * facets);
  // From the last facet up. With K_i = L_{i+1,i} L_i^{-1}, the inverse C obeys C_{i,j} = -K_i^T C_{i+1,j} for
  // j > i and C_{i,i} = (L_i L_i^T)^{-1} + K_i^T C_{i+1,i+1} K_i. `row` holds C_{i,j} for all j >= i, of
  // which only some columns are needed.
  Eigen::MatrixXd row = Eigen::MatrixXd::Zero(kFacetSize, kPose * facets);
  FacetMatrix diagonal = factor_[facets - 1].solve(FacetMatrix::Identity());
  row.middleCols<kPose>(kPose * (facets - 1)) = diagonal.leftCols<kPose>();
  for (int i = facets - 1;; --i) {
    all.block(kPose * i, kPose * i, kPose, kPose * (facets - i)) =
        row.block(0, kPose * i, kPose, kPose * (facets - i));
    if (i == 0) break;
    const FacetMatrix transposed = factor_[i - 1].matrixU().solve(coupling_[i - 1].transpose());  // K^T
    const FacetMatrix above =
        factor_[i - 1].solve(FacetMatrix::Identity()) + transposed * diagonal * transposed.transpose();
    diagonal = 0.5 * (above + above.transpose());
    const Eigen::MatrixXd next = -transposed * row.rightCols(kPose * (facets - i));
    row.rightCols(kPose * (facets - i)) = next;
    row.middleCols<kPose>(kPose * (i - 1)) = diagonal.leftCols<kPose>();
  }
  all.triangularView<Eigen::StrictlyLower>() = all.transpose();
  return all;
}

}  // namespace tendril
