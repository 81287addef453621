#include "capture/track/chain_curve.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <random>

#include "capture/rig/portable_random.h"
#include "model/check.h"
#include "model/fold/facet_chain.h"

namespace tendril {

FramedCurve CurveOfFacets(const TentacleLayout& layout, const std::vector<FacetState>& facets) {
  const int holes = static_cast<int>(facets.size());
  FramedCurve curve;
  curve.points.resize(3, holes);
  for (int i = 0; i < holes; ++i) curve.points.col(i) = facets[i].hole;
  if (holes == 1) {
    curve.normals = facets.front().rotation.col(0);
    return curve;
  }
  return NodesAtHoles(SegmentsOfFacets(layout, facets));
}

TendonCurve SegmentsOfFacets(const TentacleLayout& layout, const std::vector<FacetState>& facets) {
  const int holes = static_cast<int>(facets.size());
  TENDRIL_CHECK(holes >= 2);
  TendonCurve tendon;
  tendon.holes.resize(3, holes);
  for (int i = 0; i < holes; ++i) tendon.holes.col(i) = facets[i].hole;
  tendon.segment_length.resize(holes - 1);
  tendon.turning = Eigen::Matrix3Xd::Zero(3, std::max(0, holes - 2));
  for (int i = 0; i + 1 < holes; ++i) {
    const CreaseGeometry crease = GeometryOfCrease(layout, i);
    const double angle = FoldAngleBetween(crease, facets[i].rotation, facets[i + 1].rotation);
    const Eigen::Vector3d half = crease.turn * angle * crease.along;
    const Eigen::Matrix3d half_way = facets[i].rotation * RotationOf(half);
    const Eigen::Matrix3d from_tip = facets[i + 1].rotation * RotationOf(-half);
    const Eigen::Vector3d chord = facets[i + 1].hole - facets[i].hole;
    tendon.segment_length[i] = chord.norm();
    // A closed segment's chord is shorter than its own error: the sheet's direction stands in.
    const double flat = layout.hole_z[i + 1] - layout.hole_z[i];
    const Eigen::Vector3d tangent =
        chord.norm() > 0.02 * flat ? Eigen::Vector3d(chord.normalized()) : Eigen::Vector3d(half_way.col(2));
    const Eigen::Vector3d normal = 0.5 * (half_way.col(0) + from_tip.col(0));
    Eigen::Vector3d square = normal - tangent * tangent.dot(normal);
    if (square.norm() < 1e-6) square = tangent.unitOrthogonal();
    square.normalize();
    Eigen::Matrix3d frame;
    frame << square.transpose(), tangent.cross(square).transpose(), tangent.transpose();
    tendon.frames.push_back(frame);
  }
  return tendon;
}

namespace {

constexpr int kTurnColumns = 8;     // of turns that the points do not know: their largest part
constexpr int kOwnTurnColumns = 4;  // and the rest, of each node for itself

// Three orthonormal rows of so many columns, in no particular direction.
Eigen::Matrix3Xd AnyOrthonormalRows(int columns, std::mt19937_64& random) {
  Eigen::Matrix3Xd rows(3, columns);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < columns; ++c) rows(r, c) = DrawUniform(random, -1, 1);
    for (int before = 0; before < r; ++before) {
      rows.row(r) -= rows.row(r).dot(rows.row(before)) * rows.row(before);
    }
    rows.row(r).normalize();
  }
  return rows;
}

// The largest part of a covariance by pivoted Cholesky, pivots among the first rows only: columns, and what
// is left in `rest`.
Eigen::MatrixXd LargestPart(Eigen::MatrixXd& rest, Eigen::Index pivots, int columns) {
  Eigen::MatrixXd part = Eigen::MatrixXd::Zero(rest.rows(), columns);
  for (int c = 0; c < columns; ++c) {
    Eigen::Index pivot = 0;
    const double most = rest.diagonal().head(pivots).maxCoeff(&pivot);
    if (!(most > 0)) break;
    part.col(c) = rest.col(pivot) / std::sqrt(most);
    rest.noalias() -= part.col(c) * part.col(c).transpose();
  }
  return part;
}

// An error of each node for itself, in columns that all nodes share.
Eigen::MatrixXd OwnPart(const Eigen::MatrixXd& rest, int shared) {
  Eigen::MatrixXd part(rest.rows(), shared);
  std::mt19937_64 random(1);
  for (Eigen::Index node = 0; node < rest.rows() / 3; ++node) {
    const Eigen::Matrix3d own = rest.block<3, 3>(3 * node, 3 * node);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(own);  // tiny negative values come of rounding
    const Eigen::Matrix3d root =
        eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
    part.middleRows<3>(3 * node) = root * AnyOrthonormalRows(shared, random);
  }
  return part;
}

}  // namespace

CurveFactors FactorsOfCurve(const Eigen::MatrixXd& covariance, int rank) {
  const int nodes = static_cast<int>(covariance.rows()) / 4;
  const int points = 3 * nodes;
  TENDRIL_CHECK(covariance.cols() == 4 * nodes && covariance.rows() == 4 * nodes && rank >= 12);
  const int shared = std::min(12, points);
  const int largest = std::clamp(rank - shared, 0, points);
  Eigen::MatrixXd rest = covariance;
  const Eigen::MatrixXd part = LargestPart(rest, points, largest);
  CurveFactors factors{Eigen::MatrixXd(points, largest + shared), {}};
  factors.points << part.topRows(points), OwnPart(rest.topLeftCorner(points, points), shared);

  // Turns go with the points' largest part; the points' rest is each node's for itself and tells nothing.
  Eigen::MatrixXd turn_rest = rest.bottomRightCorner(nodes, nodes);
  const int more = std::min(kTurnColumns, nodes);
  const Eigen::MatrixXd turn_part = LargestPart(turn_rest, nodes, more);
  factors.turns = Eigen::MatrixXd::Zero(nodes, largest + shared + more + kOwnTurnColumns);
  factors.turns.leftCols(largest) = part.bottomRows(nodes);
  factors.turns.middleCols(largest + shared, more) = turn_part;
  std::mt19937_64 random(2);
  for (int node = 0; node < nodes; ++node) {
    const double own = std::sqrt(std::max(turn_rest(node, node), 0.0));
    factors.turns.block<1, kOwnTurnColumns>(node, largest + shared + more) =
        own * AnyOrthonormalRows(kOwnTurnColumns, random).row(0);
  }
  return factors;
}

}  // namespace tendril
