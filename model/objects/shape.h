#pragma once
// What an object is made of: a union of primitives, how far a point is from its surface, its mass and
// inertia.
//
// SI units. A primitive is centred at its own origin with its axis along its z; an object's frame has its
// origin at the centre of mass and its axes along the principal axes of inertia (see Balanced).

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "model/result.h"

namespace tendril {

enum class PrimitiveKind {
  kSphere,
  kCapsule,    // all that is nearer than the radius to a segment of 2 half.z
  kCylinder,   // flat ends, 2 half.z apart
  kBox,        // edges of 2 half
  kHalfSpace,  // all below z = 0: a table
};

struct Primitive {
  PrimitiveKind kind = PrimitiveKind::kSphere;
  double radius = 0;                               // m
  Eigen::Vector3d half = Eigen::Vector3d::Zero();  // m
  Eigen::Isometry3d object_from_primitive = Eigen::Isometry3d::Identity();
};

using Shape = std::vector<Primitive>;

// Where a point is against a surface: the distance, below 0 inside, and the outward normal at the nearest
// point (the distance's gradient; where that is not unique, one of them, of unit length). Exact to rounding.
struct SurfaceDistance {
  double distance = 0;  // m
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
};
SurfaceDistance DistanceTo(const Primitive& primitive, const Eigen::Vector3d& point_in_object);

// Of uniform density; where parts of a union overlap, both count.
struct MassProperties {
  double volume = 0;                                  // m^3
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();   // m
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  // about the centre, for a mass of 1 kg, m^2
};
//   errors  kBadInput  no part, a half space, a size that is not above 0 (a capsule's half.z may be 0)
Result<MassProperties> MassOf(const Shape& shape);

// The same shape in its own frame: origin at the centre of mass, axes along the principal axes, each the one
// nearest to the given axis. What is balanced already (to 1e-12 of its size) stays as it is, to the bit.
//   errors  those of MassOf
struct BalancedShape {
  Shape shape;
  Eigen::Isometry3d given_from_object = Eigen::Isometry3d::Identity();
  Eigen::Vector3d inertia = Eigen::Vector3d::Zero();  // principal, for a mass of 1 kg, m^2
  double volume = 0;                                  // m^3
};
Result<BalancedShape> Balanced(const Shape& shape);

// What stands for an object's surface where it meets a table or another object: spheres inside it, of radius
// 0 at edges and corners. A sphere is one; a capsule, spheres along its axis at most half a radius apart, 33
// at most; a box, a grid over its faces, edges and corners of at most a quarter of its shortest edge, as much
// wider as keeps it at 100 points; a cylinder, 64 points on either rim, 9 on either end and, where it is
// longer than wide, spheres along its axis like a capsule's. A half space has none.
struct SurfaceSphere {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // in the object, m
  double radius = 0;
};
std::vector<SurfaceSphere> SurfaceSpheres(const Shape& shape);

// The farthest that a point of the shape lies from the object's origin, m; infinite with a half space.
double ReachOf(const Shape& shape);

}  // namespace tendril
