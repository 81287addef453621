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
  TendonCurve tendon;
  tendon.holes = curve.points;
  tendon.segment_length.resize(holes - 1);
  for (int i = 0; i + 1 < holes; ++i) {
    const CreaseGeometry crease = GeometryOfCrease(layout, i);
    const double angle = FoldAngleBetween(crease, facets[i].rotation, facets[i + 1].rotation);
    const Eigen::Matrix3d half_way = facets[i].rotation * RotationOf(crease.turn * angle * crease.along);
    const Eigen::Vector3d chord = facets[i + 1].hole - facets[i].hole;
    tendon.segment_length[i] = chord.norm();
    // A closed segment's chord is shorter than its own error: the sheet's direction stands in.
    const double flat = layout.hole_z[i + 1] - layout.hole_z[i];
    const Eigen::Vector3d tangent =
        chord.norm() > 0.02 * flat ? Eigen::Vector3d(chord.normalized()) : Eigen::Vector3d(half_way.col(2));
    const Eigen::Vector3d normal = half_way.col(0);
    Eigen::Vector3d square = normal - tangent * tangent.dot(normal);
    if (square.norm() < 1e-6) square = tangent.unitOrthogonal();
    square.normalize();
    Eigen::Matrix3d frame;
    frame << square.transpose(), tangent.cross(square).transpose(), tangent.transpose();
    tendon.frames.push_back(frame);
  }
  return NodesAtHoles(tendon);
}

namespace {

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

}  // namespace

Eigen::MatrixXd FactorOfCovariance(const Eigen::MatrixXd& covariance, int rank) {
  const int size = static_cast<int>(covariance.rows());
  TENDRIL_CHECK(covariance.cols() == size && size % 3 == 0 && rank >= 12);
  const int shared = std::min(12, size);  // columns for the rest
  const int largest = std::clamp(rank - shared, 0, size);
  Eigen::MatrixXd rest = covariance;
  Eigen::MatrixXd factor = Eigen::MatrixXd::Zero(size, largest + shared);
  for (int c = 0; c < largest; ++c) {
    int pivot = 0;
    const double most = rest.diagonal().maxCoeff(&pivot);
    if (!(most > 0)) break;
    const Eigen::VectorXd column = rest.col(pivot) / std::sqrt(most);
    factor.col(c) = column;
    rest.noalias() -= column * column.transpose();
  }
  std::mt19937_64 random(1);
  for (int node = 0; node < size / 3; ++node) {
    const Eigen::Matrix3d own = rest.block<3, 3>(3 * node, 3 * node);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(own);  // tiny negative values come of rounding
    const Eigen::Matrix3d root =
        eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
    factor.block(3 * node, largest, 3, shared) = root * AnyOrthonormalRows(shared, random);
  }
  return factor;
}

}  // namespace tendril
