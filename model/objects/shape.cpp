#include "model/objects/shape.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tendril {
namespace {

// Below this a length's square has lost digits, and no force is worth its direction.
constexpr double kNoLength = 1e-150;

SurfaceDistance FromPoint(const Eigen::Vector3d& offset, double radius, const Eigen::Vector3d& otherwise) {
  const double length = offset.norm();
  if (length < kNoLength) return {length - radius, otherwise};
  return {length - radius, offset / length};
}

SurfaceDistance FromCylinder(const Eigen::Vector3d& p, double radius, double half_length) {
  const double across = std::hypot(p.x(), p.y());
  const Eigen::Vector3d outward = across < kNoLength ? Eigen::Vector3d(Eigen::Vector3d::UnitX())
                                                     : Eigen::Vector3d(p.x() / across, p.y() / across, 0);
  const Eigen::Vector3d along(0, 0, p.z() < 0 ? -1 : 1);
  const double past_side = across - radius;
  const double past_end = std::abs(p.z()) - half_length;
  if (past_side > 0 && past_end > 0) {
    const double distance = std::hypot(past_side, past_end);
    return {distance, past_side / distance * outward + past_end / distance * along};
  }
  if (past_side > past_end) return {past_side, outward};
  return {past_end, along};
}

SurfaceDistance FromBox(const Eigen::Vector3d& p, const Eigen::Vector3d& half) {
  const Eigen::Vector3d past = p.cwiseAbs() - half;
  const Eigen::Vector3d side(p.x() < 0 ? -1 : 1, p.y() < 0 ? -1 : 1, p.z() < 0 ? -1 : 1);
  const Eigen::Vector3d outside = past.cwiseMax(0.0);
  const double distance = outside.norm();
  if (distance > kNoLength) return {distance, outside.cwiseProduct(side) / distance};
  int face = 0;
  const double nearest = past.maxCoeff(&face);
  return {nearest, side[face] * Eigen::Vector3d::Unit(face)};
}

SurfaceDistance InPrimitive(const Primitive& primitive, const Eigen::Vector3d& p) {
  switch (primitive.kind) {
    case PrimitiveKind::kSphere:
      return FromPoint(p, primitive.radius, Eigen::Vector3d::UnitZ());
    case PrimitiveKind::kCapsule: {
      const double nearest = std::clamp(p.z(), -primitive.half.z(), primitive.half.z());
      return FromPoint({p.x(), p.y(), p.z() - nearest}, primitive.radius, Eigen::Vector3d::UnitX());
    }
    case PrimitiveKind::kCylinder:
      return FromCylinder(p, primitive.radius, primitive.half.z());
    case PrimitiveKind::kBox:
      return FromBox(p, primitive.half);
    case PrimitiveKind::kHalfSpace:
      break;
  }
  return {p.z(), Eigen::Vector3d::UnitZ()};
}

double PrimitiveReach(const Primitive& primitive) {
  const auto& pose = primitive.object_from_primitive;
  // The origin as the primitive sees it, mirrored into the octant away from the farthest point.
  const Eigen::Vector3d away = (pose.linear().transpose() * pose.translation()).cwiseAbs();
  switch (primitive.kind) {
    case PrimitiveKind::kSphere:
      return away.norm() + primitive.radius;
    case PrimitiveKind::kCapsule:
      return (away + Eigen::Vector3d(0, 0, primitive.half.z())).norm() + primitive.radius;
    case PrimitiveKind::kCylinder:
      return std::hypot(std::hypot(away.x(), away.y()) + primitive.radius, away.z() + primitive.half.z());
    case PrimitiveKind::kBox:
      return (away + primitive.half).norm();
    case PrimitiveKind::kHalfSpace:
      break;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace

SurfaceDistance DistanceTo(const Primitive& primitive, const Eigen::Vector3d& point_in_object) {
  const auto& pose = primitive.object_from_primitive;
  const Eigen::Vector3d p = pose.linear().transpose() * (point_in_object - pose.translation());
  SurfaceDistance found = InPrimitive(primitive, p);
  found.normal = pose.linear() * found.normal;
  return found;
}

double ReachOf(const Shape& shape) {
  double reach = 0;
  for (const Primitive& primitive : shape) reach = std::max(reach, PrimitiveReach(primitive));
  return reach;
}

}  // namespace tendril
