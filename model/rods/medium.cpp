#include "model/rods/medium.h"

#include <cmath>
#include <numbers>
#include <string>

namespace tendril {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

Status NotBelowZero(const char* name, double value) {
  if (std::isfinite(value) && value >= 0) return Ok{};
  return Error{ErrorKind::kBadInput, std::string(name) + " is " + std::to_string(value) +
                                         ": expected a number that is not below 0"};
}

}  // namespace

Medium Air() { return {.density = 1.204}; }
Medium Water() { return {.density = 998.2}; }

Status CheckMedium(const Medium& medium) {
  if (!medium.flow.allFinite()) return Error{ErrorKind::kBadInput, "the medium's flow is not finite"};
  const std::pair<const char*, double> values[] = {{"the medium's density", medium.density},
                                                   {"its drag across", medium.cross_drag},
                                                   {"its drag along", medium.along_drag},
                                                   {"its added mass", medium.added_mass}};
  for (const auto& [name, value] : values) {
    if (auto status = NotBelowZero(name, value); !status.ok()) return status;
  }
  return Ok{};
}

Status CheckWetted(const Wetted& wetted) {
  if (auto status = NotBelowZero("the drag diameter's scale", wetted.drag_diameter_scale); !status.ok()) {
    return status;
  }
  return NotBelowZero("the displaced volume's share", wetted.displaced);
}

WettedNodes WettedNodesOf(const Rod& rod, const Medium& medium, const Wetted& wetted) {
  using std::numbers::pi;
  const Index nodes = rod.mass.size();
  WettedNodes of;
  of.weighed = rod.mass;
  of.inverse_across = rod.mass;  // m + m_a as they are summed
  of.across_drag.setZero(nodes);
  of.along_drag.setZero(nodes);
  for (Index i = 0; i < rod.elements(); ++i) {
    const double half = 0.5 * rod.rest_length[i], radius = rod.radius[i];
    const double diameter = 2 * radius * wetted.drag_diameter_scale;
    for (const Index node : {i, i + 1}) {
      of.weighed[node] -= medium.density * wetted.displaced * pi * radius * radius * half;
      of.inverse_across[node] += medium.added_mass * medium.density * pi / 4 * diameter * diameter * half;
      of.across_drag[node] += 0.5 * medium.density * medium.cross_drag * diameter * half;
      of.along_drag[node] += 0.5 * medium.density * medium.along_drag * pi * diameter * half;
    }
  }
  of.inverse_across = of.inverse_across.cwiseInverse().eval();
  of.across_drag.array() *= of.inverse_across.array();
  of.along_drag.array() /= rod.mass.array();
  return of;
}

Vector3d KickInMedium(const WettedNodes& nodes, Index node, const Vector3d& flow, double keep, double gain,
                      const Vector3d& edge, const Vector3d& velocity, const Vector3d& force,
                      const Vector3d& gravity, double inverse_mass) {
  // Where a node's neighbours are in one place there is no tangent: then all is across.
  const double length = edge.norm();
  const Vector3d tangent = length > 0 ? Vector3d(edge / length) : Vector3d::Zero();
  const auto along = [&](const Vector3d& v) -> Vector3d { return tangent.dot(v) * tangent; };

  const Vector3d load = force + nodes.weighed[node] * gravity;
  const Vector3d before = velocity - flow, damped = keep * velocity - flow;
  const double along_speed = along(before).norm(), across_speed = (before - along(before)).norm();
  const Vector3d kicked_along = along(damped + gain * inverse_mass * load);
  const Vector3d freely = damped + gain * nodes.inverse_across[node] * load;
  const Vector3d kicked_across = freely - along(freely);
  return flow + kicked_along / (1 + gain * nodes.along_drag[node] * along_speed) +
         kicked_across / (1 + gain * nodes.across_drag[node] * across_speed);
}

}  // namespace tendril
