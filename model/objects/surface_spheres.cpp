#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "model/objects/shape.h"

namespace tendril {
namespace {

constexpr int kMostAlongAxis = 32;  // gaps between spheres
constexpr int kMostOnBox = 100;
constexpr int kOnRim = 64;
constexpr int kOnEnd = 8;  // around the middle of a flat end

void AddSpheresAlong(const Primitive& part, double half_length, std::vector<SurfaceSphere>& spheres) {
  // Half a radius apart, the surface between two spheres lies 1/32 of the radius above them.
  const double wanted = std::ceil(4 * half_length / part.radius);
  const int gaps = static_cast<int>(std::clamp(wanted, 0.0, double{kMostAlongAxis}));
  for (int i = 0; i <= gaps; ++i) {
    const double z = gaps == 0 ? 0 : half_length * (2.0 * i - gaps) / gaps;
    spheres.push_back({part.object_from_primitive * Eigen::Vector3d(0, 0, z), part.radius});
  }
}

void AddCircle(const Primitive& part, double radius, double z, int points,
               std::vector<SurfaceSphere>& spheres) {
  for (int i = 0; i < points; ++i) {
    const double angle = 2 * std::numbers::pi * i / points;
    const Eigen::Vector3d at(radius * std::cos(angle), radius * std::sin(angle), z);
    spheres.push_back({part.object_from_primitive * at, 0});
  }
}

void AddCylinder(const Primitive& part, std::vector<SurfaceSphere>& spheres) {
  for (const double z : {-part.half.z(), part.half.z()}) {
    AddCircle(part, part.radius, z, kOnRim, spheres);
    AddCircle(part, part.radius / 2, z, kOnEnd, spheres);
    AddCircle(part, 0, z, 1, spheres);
  }
  if (part.half.z() >= part.radius) AddSpheresAlong(part, part.half.z() - part.radius, spheres);
}

int OnSurface(const std::array<int, 3>& gaps) {
  return (gaps[0] + 1) * (gaps[1] + 1) * (gaps[2] + 1) - (gaps[0] - 1) * (gaps[1] - 1) * (gaps[2] - 1);
}

std::array<int, 3> GapsOf(const Eigen::Vector3d& half) {
  std::array<int, 3> gaps;
  double spacing = half.minCoeff() / 2;
  do {
    for (int i = 0; i < 3; ++i) {
      // A cube's edges are four gaps, whatever the division's last digit.
      const double wanted = std::ceil(2 * half[i] / spacing * (1 - 1e-9));
      gaps[i] = static_cast<int>(std::clamp(wanted, 1.0, double{kMostOnBox}));
    }
    spacing *= 1.05;
  } while (OnSurface(gaps) > kMostOnBox);
  return gaps;
}

void AddBox(const Primitive& part, std::vector<SurfaceSphere>& spheres) {
  const std::array<int, 3> gaps = GapsOf(part.half);
  const auto along = [&](int axis, int i) { return part.half[axis] * (2.0 * i - gaps[axis]) / gaps[axis]; };
  const auto on_face = [&](int axis, int i) { return i == 0 || i == gaps[axis]; };
  for (int i = 0; i <= gaps[0]; ++i) {
    for (int j = 0; j <= gaps[1]; ++j) {
      for (int k = 0; k <= gaps[2]; ++k) {
        if (!on_face(0, i) && !on_face(1, j) && !on_face(2, k)) continue;
        const Eigen::Vector3d at(along(0, i), along(1, j), along(2, k));
        spheres.push_back({part.object_from_primitive * at, 0});
      }
    }
  }
}

}  // namespace

std::vector<SurfaceSphere> SurfaceSpheres(const Shape& shape) {
  std::vector<SurfaceSphere> spheres;
  for (const Primitive& part : shape) {
    switch (part.kind) {
      case PrimitiveKind::kSphere:
        spheres.push_back({part.object_from_primitive.translation(), part.radius});
        break;
      case PrimitiveKind::kCapsule:
        AddSpheresAlong(part, part.half.z(), spheres);
        break;
      case PrimitiveKind::kCylinder:
        AddCylinder(part, spheres);
        break;
      case PrimitiveKind::kBox:
        AddBox(part, spheres);
        break;
      case PrimitiveKind::kHalfSpace:
        break;
    }
  }
  return spheres;
}

}  // namespace tendril
