#include "model/objects/object_drag.h"

#include <cmath>
#include <numbers>
#include <string>

namespace tendril {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

constexpr double kSphere = 0.47, kAcross = 1.1, kEnd = 0.82, kBox = 1.05, kSkin = 0.01;

struct Figures {
  DragPart part;
  double volume = 0;
};

// Slides along itself: rho/2 C_f (w r sin)^2 r sin over the surface.
double SphereSkin(double r) { return kSkin * 0.75 * pi * pi * std::pow(r, 5); }

Figures SphereFigures(double r) {
  const double volume = 4 * pi / 3 * r * r * r;
  Figures f;
  f.part.area.setConstant(kSphere * pi * r * r);
  f.part.turning.setConstant(SphereSkin(r));
  f.part.added.setConstant(0.5 * volume);
  f.volume = volume;
  return f;
}

// Without its ends.
Figures TubeFigures(double r, double half) {
  Figures f;
  f.volume = 2 * pi * r * r * half;
  const double across = kAcross * 4 * r * half;
  // A strip at s has the speed w s: the integral of C 2 r |s|^3.
  const double over = kAcross * r * std::pow(half, 4);
  f.part.area = {across, across, 0};
  f.part.turning = {over, over, kSkin * 4 * pi * std::pow(r, 4) * half};
  f.part.added = {f.volume, f.volume, 0};
  return f;
}

Figures CylinderFigures(double r, double half) {
  Figures f = TubeFigures(r, half);
  f.part.area.z() = kEnd * pi * r * r;
  f.part.added.z() = 8.0 / 3 * r * r * r;
  // The ends: strips of a disc, and their skin.
  const double disc = kEnd * 8 / 15 * std::pow(r, 5);
  f.part.turning += Vector3d(disc, disc, kSkin * 0.8 * pi * std::pow(r, 5));
  return f;
}

Figures CapsuleFigures(double r, double half) {
  Figures f = TubeFigures(r, half);
  const Figures ends = SphereFigures(r);
  f.part.area += ends.part.area;
  f.part.added += ends.part.added;
  f.volume += ends.volume;
  const double far = ends.part.area.x() * std::pow(half, 3);
  f.part.turning += ends.part.turning + Vector3d(far, far, 0);
  return f;
}

Figures BoxFigures(const Vector3d& half) {
  Figures f;
  f.volume = 8 * half.prod();
  for (int k = 0; k < 3; ++k) {
    const double a = half[(k + 1) % 3], b = half[(k + 2) % 3];
    f.part.area[k] = kBox * 4 * a * b;
    f.part.turning[k] = kBox * half[k] * (std::pow(a, 4) + std::pow(b, 4));
    f.part.added[k] = 0.68 * f.volume;
  }
  return f;
}

Error Wrong(const std::string& what, double value) {
  return {ErrorKind::kBadInput, what + " is " + std::to_string(value) + " m: expected a length above 0"};
}
bool IsLength(double value) { return std::isfinite(value) && value > 0; }

Result<Figures> FiguresOf(const Primitive& primitive) {
  const bool is_box = primitive.kind == PrimitiveKind::kBox;
  if (!is_box && primitive.kind != PrimitiveKind::kHalfSpace && !IsLength(primitive.radius)) {
    return Wrong("a part's radius", primitive.radius);
  }
  const double half = primitive.half.z();
  switch (primitive.kind) {
    case PrimitiveKind::kSphere:
      return SphereFigures(primitive.radius);
    case PrimitiveKind::kCapsule:
    case PrimitiveKind::kCylinder:
      if (primitive.kind == PrimitiveKind::kCapsule && half == 0) return SphereFigures(primitive.radius);
      if (!IsLength(half)) return Wrong("half a part's length", half);
      return primitive.kind == PrimitiveKind::kCapsule ? CapsuleFigures(primitive.radius, half)
                                                       : CylinderFigures(primitive.radius, half);
    case PrimitiveKind::kBox:
      for (const double edge : primitive.half) {
        if (!IsLength(edge)) return Wrong("half a box's edge", edge);
      }
      return BoxFigures(primitive.half);
    case PrimitiveKind::kHalfSpace:
      break;
  }
  return Error{ErrorKind::kBadInput, "a half space does not move in a medium: expected parts of finite size"};
}

// The speed that drag along each axis goes with: round bodies separate across and along.
Vector3d SpeedsOf(PrimitiveKind kind, const Vector3d& v) {
  if (kind == PrimitiveKind::kSphere || kind == PrimitiveKind::kBox) return Vector3d::Constant(v.norm());
  const double across = std::hypot(v.x(), v.y());
  return {across, across, std::abs(v.z())};
}

}  // namespace

Result<ObjectDrag> DragOf(const Shape& shape) {
  if (shape.empty()) return Error{ErrorKind::kBadInput, "an object without parts: expected one or more"};
  ObjectDrag drag;
  for (const Primitive& primitive : shape) {
    const auto figures = FiguresOf(primitive);
    if (!figures.ok()) return figures.error();
    drag.parts.push_back(figures.value().part);
    drag.parts.back().kind = primitive.kind;
    drag.parts.back().object_from_part = primitive.object_from_primitive;
    drag.volume += figures.value().volume;
  }
  return drag;
}

BodyLoad ForceOnBody(const ObjectDrag& drag, const RigidBody& body, const Medium& medium,
                     const Vector3d& gravity, double time) {
  BodyLoad load;
  if (medium.density == 0) return load;
  const Matrix3d lab_from_body = body.lab_from_body.toRotationMatrix();
  const Vector3d spin = body.angular_momentum_in_body.cwiseQuotient(body.inertia);      // in the body
  const Vector3d velocity = lab_from_body.transpose() * (body.velocity - medium.flow);  // likewise
  const double mobility = 1 / body.mass, turning_mobility = 1 / body.inertia.minCoeff();
  const double pressure = 0.5 * medium.density;
  double rate = 0;
  Vector3d force = Vector3d::Zero(), torque = Vector3d::Zero();
  for (const DragPart& part : drag.parts) {
    const Matrix3d body_from_part = part.object_from_part.linear();
    const Vector3d arm = part.object_from_part.translation();
    const Vector3d at_part = body_from_part.transpose() * (velocity + spin.cross(arm));
    const Vector3d turning = body_from_part.transpose() * spin;
    const Vector3d slows = pressure * part.area.cwiseProduct(SpeedsOf(part.kind, at_part));
    const Vector3d turns = pressure * part.turning.cwiseProduct(SpeedsOf(part.kind, turning));
    const Vector3d push = body_from_part * Vector3d(-slows.cwiseProduct(at_part));
    force += push;
    torque += arm.cross(push) + body_from_part * Vector3d(-turns.cwiseProduct(turning));
    rate += slows.maxCoeff() * (mobility + arm.squaredNorm() * turning_mobility) +
            turns.maxCoeff() * turning_mobility;
  }
  const double share = 1 / (1 + time * rate);
  load.force = share * (lab_from_body * force) - medium.density * drag.volume * gravity;
  load.torque = share * (lab_from_body * torque);
  return load;
}

Matrix3d AddedMass(const ObjectDrag& drag, const Medium& medium) {
  Matrix3d mass = Matrix3d::Zero();
  for (const DragPart& part : drag.parts) {
    const Matrix3d r = part.object_from_part.linear();
    mass += medium.density * r * part.added.asDiagonal() * r.transpose();
  }
  return mass;
}

}  // namespace tendril
