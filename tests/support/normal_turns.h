#pragma once
// By how much a curve's normals are turned about it against another's.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "model/geometry/framed_curve.h"

namespace tendril::testing_support {

inline Eigen::Vector3d TangentAt(const Eigen::Matrix3Xd& points, Eigen::Index node) {
  const auto piece = [&](Eigen::Index from) {
    return Eigen::Vector3d(points.col(from + 1) - points.col(from)).normalized();
  };
  return (piece(std::max<Eigen::Index>(node - 1, 0)) + piece(std::min(node, points.cols() - 2))).normalized();
}

// From the first curve's normals, made perpendicular to the second curve, to the second's, rad.
inline Eigen::VectorXd TurnsBetween(const FramedCurve& first, const FramedCurve& second) {
  Eigen::VectorXd turns(first.points.cols());
  for (Eigen::Index i = 0; i < turns.size(); ++i) {
    const Eigen::Vector3d t = TangentAt(second.points, i);
    const Eigen::Vector3d a = first.normals.col(i) - t * t.dot(first.normals.col(i));
    turns[i] = std::atan2(t.dot(a.cross(second.normals.col(i))), a.dot(second.normals.col(i)));
  }
  return turns;
}

}  // namespace tendril::testing_support
