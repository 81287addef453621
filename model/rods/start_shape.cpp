#include "model/rods/start_shape.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "model/geometry/rotation.h"

namespace tendril {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

namespace {

constexpr int kPieces = 64;  // of a span, as straight as its arc length is reckoned

// Catmull and Rom 1974; at the ends, where a parabola through three points leads.
Matrix3Xd Fine(const Eigen::Ref<const Matrix3Xd>& points) {
  const Index spans = points.cols() - 1;
  const auto slope = [&](Index i) {
    if (i == 0) return Vector3d(-1.5 * points.col(0) + 2 * points.col(1) - 0.5 * points.col(2));
    if (i == spans) return Vector3d(1.5 * points.col(i) - 2 * points.col(i - 1) + 0.5 * points.col(i - 2));
    return Vector3d(0.5 * (points.col(i + 1) - points.col(i - 1)));
  };
  Matrix3Xd fine(3, spans * kPieces + 1);
  for (Index i = 0; i < spans; ++i) {
    const Vector3d from = points.col(i), to = points.col(i + 1), out = slope(i), in = slope(i + 1);
    for (int k = 0; k <= kPieces; ++k) {
      const double t = static_cast<double>(k) / kPieces, u = 1 - t;
      fine.col(i * kPieces + k) =
          u * u * (1 + 2 * t) * from + t * t * (3 - 2 * t) * to + t * u * u * out - t * t * u * in;
    }
  }
  return fine;
}

}  // namespace

Status LayThrough(const Eigen::Ref<const Matrix3Xd>& points, RodDesign& design) {
  bool apart = points.allFinite();
  for (Index i = 1; i < points.cols(); ++i) apart = apart && points.col(i) != points.col(i - 1);
  if (points.cols() < 4 || !apart || design.elements < 2) {
    return Error{ErrorKind::kBadInput,
                 "start points: expected four or more, finite, each elsewhere than the one before"};
  }
  const Matrix3Xd fine = Fine(points);
  std::vector<double> along(static_cast<std::size_t>(fine.cols()), 0.0);
  for (Index i = 1; i < fine.cols(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    along[k] = along[k - 1] + (fine.col(i) - fine.col(i - 1)).norm();
  }
  const auto at = [&](double length) {
    const auto past = std::upper_bound(along.begin() + 1, along.end() - 1, length);
    const Index i = past - along.begin();
    const double from = along[static_cast<std::size_t>(i - 1)], to = along[static_cast<std::size_t>(i)];
    return Vector3d(fine.col(i - 1) + (length - from) / (to - from) * (fine.col(i) - fine.col(i - 1)));
  };
  design.start = points.col(0);
  design.direction = (fine.col(1) - fine.col(0)).normalized();
  design.length = along.back();
  const double element = design.length / design.elements;
  const Vector3d d1 = (design.normal - design.normal.dot(design.direction) * design.direction).normalized();
  if (!d1.allFinite())
    return Error{ErrorKind::kBadInput, "normal along the direction in which the rod starts"};
  Eigen::Matrix3d q;
  q << d1.transpose(), design.direction.cross(d1).transpose(), design.direction.transpose();
  design.start_curvatures.resize(3, design.elements);
  for (int i = 0; i < design.elements; ++i) {
    // The chord of where the element will lie.
    const Vector3d chord = (at((i + 1) * element) - at(i * element)).normalized();
    const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Vector3d(q.row(2).transpose()), chord);
    design.start_curvatures.col(i) = q * LogSo3(turn) / (i == 0 ? 0.5 * element : element);
    q = q * turn.toRotationMatrix().transpose();
  }
  return Ok{};
}

Vector3d StrongestStartCurvature(const RodDesign& design) {
  if (design.start_curvatures.cols() == 0) return design.start_curvature.cwiseAbs();
  return design.start_curvatures.cwiseAbs().rowwise().maxCoeff();
}

}  // namespace tendril
