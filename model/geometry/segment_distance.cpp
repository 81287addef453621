#include "model/geometry/segment_distance.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace tendril {
namespace {

using Eigen::Vector3d;

// Where on a segment (from the origin along u, its squared length uu) is nearest to p; 0 for a point.
double NearestOn(const Vector3d& u, double uu, const Vector3d& p) {
  return uu > 0 ? std::clamp(u.dot(p) / uu, 0.0, 1.0) : 0.0;
}

// sin^2 of the angle below which segments count as parallel: rounding leaves about 1e-16 of it.
constexpr double kParallel = 1e-14;

}  // namespace

ClosestPoints ClosestOfSegments(const Vector3d& a0, const Vector3d& a1, const Vector3d& b0,
                                const Vector3d& b1) {
  const Vector3d u = a1 - a0;
  const Vector3d v = b1 - b0;
  const Vector3d between = b0 - a0;
  const double uu = u.squaredNorm();
  const double vv = v.squaredNorm();
  const Vector3d normal = u.cross(v);
  const double cross = normal.squaredNorm();
  ClosestPoints closest;
  if (cross > kParallel * uu * vv) {
    // Unclamped on the lines, then one clamp after the other; each is the best given the one before.
    closest.s = std::clamp(between.cross(v).dot(normal) / cross, 0.0, 1.0);
    closest.t = NearestOn(v, vv, closest.s * u - between);
    closest.s = NearestOn(u, uu, between + closest.t * v);
  } else if (uu > 0) {
    const double from = std::clamp(u.dot(between) / uu, 0.0, 1.0);
    const double to = std::clamp(u.dot(between + v) / uu, 0.0, 1.0);
    closest.s = 0.5 * (from + to);
    closest.t = NearestOn(v, vv, closest.s * u - between);
    closest.s = NearestOn(u, uu, between + closest.t * v);
  } else {
    closest.t = NearestOn(v, vv, -between);
  }
  closest.apart = between + closest.t * v - closest.s * u;
  return closest;
}

}  // namespace tendril
