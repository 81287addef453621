#include "model/rods/contact_plain.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "model/rods/press.h"
#include "model/rods/roughness.h"

namespace tendril {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

PressSide SideOf(const Rod& rod, Index i) {
  return {rod.position.col(i), rod.position.col(i + 1), rod.radius[i], rod.rest_length[i]};
}

Vector3d SpinInLab(const Rod& rod, Index i) {
  return rod.directors[static_cast<std::size_t>(i)].transpose() * rod.spin.col(i);
}

Vector3d AxisPoint(const Eigen::Matrix3Xd& nodes, Index i, double share) {
  return (1 - share) * nodes.col(i) + share * nodes.col(i + 1);
}

void Put(const Vector3d& force, double share, Index i, RodLoads& loads) {
  loads.force.col(i) += (1 - share) * force;
  loads.force.col(i + 1) += share * force;
}

}  // namespace

void PlainContact::AddPair(std::span<const Rod> rods, const Key& key, double time_step,
                           std::span<RodLoads> loads) {
  const auto& [a, i, b, j] = key;
  const Rod &one = rods[a], &other = rods[b];
  const Press press = PressOf(contact_.stiffness, contact_.points, SideOf(one, i), SideOf(other, j));
  if (!press.presses) return;
  loads[a].force.col(i) += press.a_start;
  loads[a].force.col(i + 1) += press.a_end;
  loads[b].force.col(j) += press.b_start;
  loads[b].force.col(j + 1) += press.b_end;
  const double size = press.normal_force.norm();
  const Roughness roughness = RoughnessOf(contact_);
  if (!(size > 0) || (contact_.damping == 0 && roughness.at_rest == 0)) return;
  const Vector3d normal = press.normal_force / size;
  const double radii = one.radius[i] + other.radius[j];
  const Vector3d apart =
      AxisPoint(one.position, i, press.a_share) - AxisPoint(other.position, j, press.b_share);
  // The point where both surfaces meet, from either axis.
  const Vector3d one_arm = -one.radius[i] / radii * apart, other_arm = other.radius[j] / radii * apart;
  const Vector3d one_spin = SpinInLab(one, i), other_spin = SpinInLab(other, j);
  const Vector3d velocity = AxisPoint(one.velocity, i, press.a_share) + one_spin.cross(one_arm) -
                            AxisPoint(other.velocity, j, press.b_share) - other_spin.cross(other_arm);
  const double damping = contact_.damping * press.stiffness / ReferenceStiffness(contact_.stiffness, radii);
  const double damped = std::max(-size, -damping * velocity.dot(normal));
  Vector3d force = damped * normal;
  if (roughness.at_rest > 0) {
    Spring& spring = springs_[key];
    spring.touched = true;
    spring.stiffness = contact_.tangential_ratio * press.stick_stiffness;
    const FrictionOf friction{roughness.kinetic, roughness.at_rest, spring.stiffness, damping};
    force += FrictionForce(spring.stick, friction, normal, size + damped, velocity,
                           0.5 * (one_spin + other_spin), time_step);
  }
  Put(force, press.a_share, i, loads[a]);
  Put(-force, press.b_share, j, loads[b]);
  loads[a].couple.col(i) += one_arm.cross(force);
  loads[b].couple.col(j) -= other_arm.cross(force);
}

void PlainContact::AddSolid(std::span<const Rod> rods, std::span<const Solid> solids, const Key& key,
                            double time_step, std::span<RodLoads> loads, std::span<Wrench> wrenches) {
  const auto& [a, i, b, part] = key;
  const Rod& rod = rods[a];
  const std::size_t s = b - rods.size();
  const Solid& solid = solids[s];
  const double radius = rod.radius[i];
  const double stiffness =
      SurfaceStiffness(contact_.stiffness, radius) * rod.rest_length[i] / contact_.points;
  Vector3d sum = Vector3d::Zero();
  double total = 0, at = 0, gap = 0, pressing = 0;
  for (int k = 0; k < contact_.points; ++k) {
    const double share = (k + 0.5) / contact_.points;
    const Vector3d point = AxisPoint(rod.position, i, share);
    const SurfaceDistance surface =
        DistanceTo(solid.shape[static_cast<std::size_t>(part)], solid.pose.inverse() * point);
    const double depth = radius - surface.distance;
    if (!(depth > 0)) continue;
    const double size = stiffness * depth;
    const Vector3d push = size * (solid.pose.linear() * surface.normal);
    Put(push, share, i, loads[a]);
    wrenches[s].force -= push;
    wrenches[s].torque -= (point - solid.pose.translation()).cross(push);
    sum += push;
    total += size;
    at += size * share;
    gap += size * surface.distance;
    pressing += stiffness;
  }
  const Roughness roughness = RoughnessOf(contact_, solid);
  const double size = sum.norm();
  if (!(size > 0) || (contact_.damping == 0 && roughness.at_rest == 0)) return;
  const Vector3d normal = sum / size;
  const double share = at / total;
  const Vector3d point = AxisPoint(rod.position, i, share);
  // Between the rod's surface and the object's.
  const Vector3d arm = -0.5 * (radius + gap / total) * normal;
  const Vector3d from_origin = point + arm - solid.pose.translation();
  const Vector3d spin = SpinInLab(rod, i);
  const Vector3d velocity =
      AxisPoint(rod.velocity, i, share) + spin.cross(arm) - solid.velocity - solid.spin.cross(from_origin);
  const double damping = contact_.damping * pressing / ReferenceStiffness(contact_.stiffness, 2 * radius);
  const double damped = std::max(-size, -damping * velocity.dot(normal));
  Vector3d force = damped * normal;
  if (roughness.at_rest > 0) {
    Spring& spring = springs_[key];
    spring.touched = true;
    spring.stiffness = contact_.tangential_ratio * stiffness * contact_.points;
    force += FrictionForce(spring.stick, {roughness.kinetic, roughness.at_rest, spring.stiffness, damping},
                           normal, size + damped, velocity, 0.5 * (spin + solid.spin), time_step);
  }
  Put(force, share, i, loads[a]);
  loads[a].couple.col(i) += arm.cross(force);
  wrenches[s].force -= force;
  wrenches[s].torque -= from_origin.cross(force);
}

void PlainContact::Add(std::span<const Rod> rods, std::span<const Solid> solids, double time_step,
                       std::span<RodLoads> loads, std::span<Wrench> wrenches) {
  for (auto& [key, spring] : springs_) spring.touched = false;
  for (std::size_t a = 0; a < rods.size(); ++a) {
    for (Index i = 0; i < rods[a].elements(); ++i) {
      for (std::size_t b = 0; pairs_.rods && b < a; ++b) {
        for (Index j = 0; j < rods[b].elements(); ++j) AddPair(rods, {a, i, b, j}, time_step, loads);
      }
      const Index first = FirstThatMayTouch(rods[a], i, contact_.law);
      for (Index j = first; pairs_.selves && j < rods[a].elements(); ++j) {
        AddPair(rods, {a, i, a, j}, time_step, loads);
      }
      for (std::size_t s = 0; pairs_.bodies && s < solids.size(); ++s) {
        for (std::size_t part = 0; part < solids[s].shape.size(); ++part) {
          AddSolid(rods, solids, {a, i, rods.size() + s, static_cast<Index>(part)}, time_step, loads,
                   wrenches);
        }
      }
    }
  }
  std::erase_if(springs_, [](const auto& entry) { return !entry.second.touched; });
}

double PlainContact::StoredBySprings() const {
  double stored = 0;
  for (const auto& [key, spring] : springs_) {
    stored += 0.5 * spring.stiffness * spring.stick.stretch.squaredNorm();
  }
  return stored;
}

}  // namespace tendril
