#include "model/rods/solid_contact.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "model/rods/roughness.h"

namespace tendril {
namespace {

using Eigen::Vector3d;

constexpr double kDampingRatio = 0.2;

}  // namespace

double SolidContact::StiffnessOf(const Contact& contact) { return contact.stiffness * std::sqrt(1e-3); }

double SolidContact::DampingOf(const Contact& contact, double mass) {
  return 2 * kDampingRatio * std::sqrt(StiffnessOf(contact) * mass);
}

SolidContact::SolidContact(const Contact& contact, std::span<const Solid> solids,
                           std::span<const double> masses)
    : contact_(contact), solids_(solids.size()) {
  std::size_t parts = 0;
  for (const Solid& solid : solids) {
    first_part_.push_back(parts);
    parts += solid.shape.size();
    reach_.push_back(ReachOf(solid.shape));
  }
  for (std::size_t s = 0; s < solids.size(); ++s) {
    if (!(masses[s] > 0)) continue;
    const double damping = DampingOf(contact, masses[s]);
    for (const SurfaceSphere& at : SurfaceSpheres(solids[s].shape)) {
      spheres_.push_back({s, at, damping, sticks_.size()});
      sticks_.resize(sticks_.size() + parts);
    }
  }
}

void SolidContact::Touch(const Sphere& sphere, std::span<const Solid> solids, std::size_t other,
                         std::size_t part, Stick& stick, double time_step, std::span<Wrench> wrenches) const {
  const Solid &mine = solids[sphere.solid], &its = solids[other];
  const Vector3d centre = mine.pose * sphere.at.centre;
  const SurfaceDistance surface = DistanceTo(its.shape[part], its.pose.inverse() * centre);
  const double depth = sphere.at.radius - surface.distance;
  if (!(depth > 0)) {
    stick = {};
    return;
  }
  const Vector3d normal = its.pose.linear() * surface.normal;
  const Vector3d point = centre - 0.5 * (sphere.at.radius + surface.distance) * normal;
  const Vector3d mine_arm = point - mine.pose.translation(), its_arm = point - its.pose.translation();
  const Vector3d velocity =
      mine.velocity + mine.spin.cross(mine_arm) - its.velocity - its.spin.cross(its_arm);
  const double stiffness = StiffnessOf(contact_);
  const double size = std::max(0.0, stiffness * depth - sphere.damping * velocity.dot(normal));
  const Roughness roughness = RoughnessOf(contact_, mine, its);
  const FrictionOf friction{roughness.kinetic, roughness.at_rest, contact_.tangential_ratio * stiffness,
                            sphere.damping};
  Vector3d force = size * normal;
  if (friction.at_rest > 0) {
    force += FrictionForce(stick, friction, normal, size, velocity, 0.5 * (mine.spin + its.spin), time_step);
  }
  wrenches[sphere.solid].force += force;
  wrenches[sphere.solid].torque += mine_arm.cross(force);
  wrenches[other].force -= force;
  wrenches[other].torque -= its_arm.cross(force);
}

void SolidContact::Add(std::span<const Solid> solids, double time_step, std::span<Wrench> wrenches) {
  std::size_t first = 0;
  while (first < spheres_.size()) {
    const std::size_t mine = spheres_[first].solid;
    std::size_t last = first;
    while (last < spheres_.size() && spheres_[last].solid == mine) ++last;
    for (std::size_t other = 0; other < solids.size(); ++other) {
      if (other == mine) continue;
      const Vector3d middle = solids[mine].pose.translation();
      for (std::size_t part = 0; part < solids[other].shape.size(); ++part) {
        const std::size_t spring = first_part_[other] + part;
        const SurfaceDistance near =
            DistanceTo(solids[other].shape[part], solids[other].pose.inverse() * middle);
        if (near.distance > reach_[mine]) {
          for (std::size_t k = first; k < last; ++k) sticks_[spheres_[k].first + spring] = {};
          continue;
        }
        for (std::size_t k = first; k < last; ++k) {
          Touch(spheres_[k], solids, other, part, sticks_[spheres_[k].first + spring], time_step, wrenches);
        }
      }
    }
    first = last;
  }
}

std::vector<double> SolidContact::Save() const {
  std::vector<double> saved;
  for (const Stick& stick : sticks_) {
    saved.insert(saved.end(),
                 {stick.stretch.x(), stick.stretch.y(), stick.stretch.z(), stick.slides ? 1.0 : 0.0});
  }
  return saved;
}

bool SolidContact::Restore(std::span<const double> saved) {
  if (saved.size() != 4 * sticks_.size()) return false;
  for (std::size_t k = 0; k < sticks_.size(); ++k) {
    sticks_[k] = {Vector3d(saved[4 * k], saved[4 * k + 1], saved[4 * k + 2]), saved[4 * k + 3] != 0};
  }
  return true;
}

}  // namespace tendril
