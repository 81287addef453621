// Volume, centre and inertia of a union of primitives, and its principal frame.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "model/objects/shape.h"

namespace tendril {
namespace {

constexpr double kBalanced = 1e-12;  // of the size: below it, a centre or a product of inertia is rounding

struct PartMass {
  double volume = 0;                                  // m^3
  Eigen::Vector3d inertia = Eigen::Vector3d::Zero();  // about the primitive's axes, for 1 kg, m^2
};

PartMass MassOfPart(const Primitive& part) {
  const double r = part.radius;
  const double h = part.half.z();
  const double ball = 4 * std::numbers::pi / 3 * r * r * r;
  const double tube = 2 * std::numbers::pi * r * r * h;
  switch (part.kind) {
    case PrimitiveKind::kSphere:
      return {ball, Eigen::Vector3d::Constant(0.4 * r * r)};
    case PrimitiveKind::kCapsule: {
      // Half balls, whose centres of mass lie 3/8 r beyond the tube's ends.
      const double tube_share = tube / (tube + ball);
      const double ball_share = ball / (tube + ball);
      const double across =
          tube_share * (r * r / 4 + h * h / 3) + ball_share * (0.4 * r * r + h * h + 0.75 * h * r);
      return {tube + ball, {across, across, tube_share * r * r / 2 + ball_share * 0.4 * r * r}};
    }
    case PrimitiveKind::kCylinder: {
      const double across = r * r / 4 + h * h / 3;
      return {tube, {across, across, r * r / 2}};
    }
    case PrimitiveKind::kBox: {
      const Eigen::Vector3d square = part.half.cwiseAbs2();
      return {8 * part.half.prod(), (Eigen::Vector3d::Constant(square.sum()) - square) / 3};
    }
    case PrimitiveKind::kHalfSpace:
      break;
  }
  return {};
}

bool AboveZero(double size) { return size > 0 && std::isfinite(size); }

Status CheckPart(const Primitive& part) {
  const auto bad = [](const std::string& what) { return Error{ErrorKind::kBadInput, what}; };
  if (part.kind == PrimitiveKind::kHalfSpace) return bad("a half space has no mass: it can only be fixed");
  if (part.kind != PrimitiveKind::kBox && !AboveZero(part.radius)) {
    return bad("radius " + std::to_string(part.radius) + " m must be above 0");
  }
  if (part.kind == PrimitiveKind::kCapsule && !(part.half.z() == 0 || AboveZero(part.half.z()))) {
    return bad("half length " + std::to_string(part.half.z()) + " m must not be below 0");
  }
  if (part.kind == PrimitiveKind::kCylinder && !AboveZero(part.half.z())) {
    return bad("half length " + std::to_string(part.half.z()) + " m must be above 0");
  }
  for (int i = 0; part.kind == PrimitiveKind::kBox && i < 3; ++i) {
    if (!AboveZero(part.half[i])) {
      return bad("half edge " + std::to_string(part.half[i]) + " m must be above 0");
    }
  }
  if (!part.object_from_primitive.matrix().allFinite()) return bad("a position or axis is not a number");
  return Ok{};
}

// Inertia of a point of 1 kg, m^2.
Eigen::Matrix3d PointInertia(const Eigen::Vector3d& at) {
  return at.squaredNorm() * Eigen::Matrix3d::Identity() - at * at.transpose();
}

bool IsDiagonal(const Eigen::Matrix3d& inertia) {
  const Eigen::Matrix3d products = inertia - Eigen::Matrix3d(inertia.diagonal().asDiagonal());
  return products.cwiseAbs().maxCoeff() <= kBalanced * inertia.diagonal().maxCoeff();
}

// Principal axes as columns, right-handed, each as near to its given axis as an order and signs can make it.
Eigen::Matrix3d PrincipalAxes(const Eigen::Matrix3d& inertia) {
  const Eigen::Matrix3d found = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertia).eigenvectors();
  std::array<int, 3> order = {0, 1, 2};
  std::array<int, 3> best = order;
  double nearest = -1;
  do {
    const double near =
        std::abs(found(0, order[0])) + std::abs(found(1, order[1])) + std::abs(found(2, order[2]));
    if (near > nearest) {
      nearest = near;
      best = order;
    }
  } while (std::ranges::next_permutation(order).found);
  Eigen::Matrix3d axes;
  for (int i = 0; i < 3; ++i) {
    axes.col(i) = std::copysign(1.0, found(i, best[i])) * found.col(best[i]);
  }
  if (axes.determinant() < 0) {
    int farthest = 0;
    axes.diagonal().minCoeff(&farthest);
    axes.col(farthest) *= -1;
  }
  return axes;
}

}  // namespace

Result<MassProperties> MassOf(const Shape& shape) {
  if (shape.empty()) return Error{ErrorKind::kBadInput, "a shape needs at least one part"};
  MassProperties whole;
  for (std::size_t i = 0; i < shape.size(); ++i) {
    if (Status status = CheckPart(shape[i]); !status.ok()) {
      return std::move(status).error().Within("part " + std::to_string(i));
    }
    const double volume = MassOfPart(shape[i]).volume;
    whole.volume += volume;
    whole.centre += volume * shape[i].object_from_primitive.translation();
  }
  if (!AboveZero(whole.volume)) {
    return Error{ErrorKind::kBadInput,
                 "a volume of " + std::to_string(whole.volume) + " m^3 is beyond numbers"};
  }
  whole.centre /= whole.volume;
  for (const Primitive& part : shape) {
    const PartMass mass = MassOfPart(part);
    const auto& pose = part.object_from_primitive;
    const Eigen::Matrix3d own = pose.linear() * mass.inertia.asDiagonal() * pose.linear().transpose();
    whole.inertia += mass.volume / whole.volume * (own + PointInertia(pose.translation() - whole.centre));
  }
  return whole;
}

Result<BalancedShape> Balanced(const Shape& shape) {
  const auto mass = MassOf(shape);
  if (!mass.ok()) return mass.error();
  BalancedShape balanced;
  balanced.shape = shape;
  balanced.volume = mass.value().volume;
  const Eigen::Matrix3d& inertia = mass.value().inertia;
  const double size = std::sqrt(inertia.diagonal().maxCoeff());
  const bool centred = mass.value().centre.norm() <= kBalanced * size;
  const bool straight = IsDiagonal(inertia);
  if (!centred) balanced.given_from_object.translation() = mass.value().centre;
  if (!straight) balanced.given_from_object.linear() = PrincipalAxes(inertia);
  const Eigen::Matrix3d axes = balanced.given_from_object.linear();
  balanced.inertia = straight ? Eigen::Vector3d(inertia.diagonal())
                              : Eigen::Vector3d((axes.transpose() * inertia * axes).diagonal());
  if (centred && straight) return balanced;
  for (Primitive& part : balanced.shape) {
    part.object_from_primitive = balanced.given_from_object.inverse() * part.object_from_primitive;
  }
  return balanced;
}

}  // namespace tendril
