#pragma once
// Curves whose links are known, and links of them by both methods.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "analysis/link/link.h"

namespace tendril::test {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;
inline constexpr double kPi = std::numbers::pi;
inline constexpr Closure kNone{ClosureKind::kNone, 0};
inline constexpr Closure kRays{ClosureKind::kRays, 0};

// A closed polygon on a periodic curve: the last node is the first one, to the bit.
inline Matrix3Xd Closed(int n, const std::function<Vector3d(double)>& at) {
  Matrix3Xd points(3, n + 1);
  for (int i = 0; i < n; ++i) points.col(i) = at(2 * kPi * i / n);
  points.col(n) = points.col(0);
  return points;
}

inline Matrix3Xd Line(const Vector3d& from, const Vector3d& to, int segments) {
  Matrix3Xd points(3, segments + 1);
  for (int i = 0; i <= segments; ++i) points.col(i) = from + (to - from) * i / segments;
  return points;
}

inline Matrix3Xd RandomWalk(std::mt19937_64& random, int n, double step = 0.1) {
  std::normal_distribution<double> normal(0, step);
  Matrix3Xd points(3, n);
  points.col(0) = Vector3d(normal(random), normal(random), normal(random));
  for (int i = 1; i < n; ++i) {
    points.col(i) = points.col(i - 1) + Vector3d(normal(random), normal(random), normal(random));
  }
  return points;
}

inline Strand Close(const Matrix3Xd& points, const Closure& closure) {
  auto strand = CloseCurve(points, closure);
  EXPECT_TRUE(strand.ok()) << (strand.ok() ? "" : strand.error().message);
  return std::move(strand).value();
}

inline double Link(const Matrix3Xd& a, const Matrix3Xd& b, const Closure& closure = kNone) {
  const LinkValue fast = StrandLink(Close(a, closure), Close(b, closure), LinkMethod::kFast);
  const LinkValue exact = StrandLink(Close(a, closure), Close(b, closure), LinkMethod::kExact);
  EXPECT_NEAR(fast.value, exact.value, 1e-12) << "the two methods part";
  EXPECT_EQ(fast.flags, exact.flags);
  return exact.value;
}

inline Matrix3Xd Circle(int n, double scale = 1) {
  return Closed(n, [=](double t) { return Vector3d(scale * std::cos(t), scale * std::sin(t), 0); });
}

// Strand k of the torus link T(2, 2n), each winding once the long way and n times the short way.
inline Matrix3Xd TorusStrand(int n, int k, int nodes, double scale) {
  return Closed(nodes, [=](double t) {
    const double small = n * t + kPi * k;
    const double radius = scale * (2 + 0.7 * std::cos(small));
    return Vector3d(radius * std::cos(t), radius * std::sin(t), -0.7 * scale * std::sin(small));
  });
}

}  // namespace tendril::test
