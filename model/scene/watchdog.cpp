#include "model/scene/watchdog.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/geometry/segment_distance.h"
#include "model/rods/start_shape.h"
#include "model/scene/plan.h"
#include "model/scene/schedule.h"

namespace tendril {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

Divergence At(const Driven& driven, Index element, std::string why) {
  Divergence found;
  found.rod = driven.name;
  found.element = element;
  found.why = std::move(why);
  return found;
}

// Half of E A sigma0^2 and B kappa0^2 over the length, J.
double StoredAtMost(const Scene& scene, const Driven& d) {
  double energy = 0;
  const double strain = scene.gripper && scene.gripper->shortening == Shortening::kTrue && d.actuation
                            ? StrongestPull(*scene.gripper, scene.phases)
                            : 0;
  for (Index i = 0; i < d.rod.elements(); ++i) {
    energy += 0.5 * d.rod.shear_stiffness(2, i) * strain * strain * d.rod.rest_length[i];
  }
  for (Index i = 0; i + 1 < d.rod.elements(); ++i) {
    double square = 0;
    if (d.actuation) {
      square = d.rod.bend_stiffness.col(i).maxCoeff() * std::pow(d.actuation->strongest()[i + 1], 2);
    } else {
      const Vector3d start = StrongestStartCurvature(d.plain->design);
      const Vector3d curvature = d.plain->rest_curvature.cwiseAbs() + start;
      square = d.rod.bend_stiffness.col(i).dot(curvature.cwiseAbs2());
    }
    energy += 0.5 * RestVoronoi(d.rod, i) * square;
  }
  return energy;
}

// What leading both ends of a rod can store: bending to the tightest coil that half its elements allow.
double StoredByMotion(const Driven& d) {
  if (d.plain == nullptr) return 0;
  double energy = 0;
  const double length = d.rod.rest_length.sum();
  for (const EndMotion* motion : {&d.plain->base_motion, &d.plain->tip_motion}) {
    const double time = std::max(0.0, motion->until - motion->from);
    const double turned = motion->spin.norm() * time;
    const double stiff = d.rod.bend_stiffness.maxCoeff();
    energy +=
        0.5 * stiff * turned * turned / length + 0.5 * d.rod.mass.sum() * motion->velocity.squaredNorm();
    const double moved = motion->velocity.norm() * time;
    if (d.rod.tip.hold != EndHold::kFree) {
      energy += 40 * stiff / length * std::min(1.0, moved / length) +
                0.5 * d.rod.shear_stiffness.row(2).maxCoeff() * moved * moved / length;
    }
  }
  return energy;
}

// From an element's axis to a part in whose frame both its ends are given, m: the least along it, to a
// thousandth of its length. The distance to a convex part falls and rises once along a straight line.
double LeastDistance(const Primitive& part, const Vector3d& start, const Vector3d& end) {
  const auto at = [&](double share) { return DistanceTo(part, start + share * (end - start)).distance; };
  double low = 0, high = 1;
  while (high - low > 1e-3) {
    const double third = (high - low) / 3;
    if (at(low + third) < at(high - third)) {
      high -= third;
    } else {
      low += third;
    }
  }
  return at(0.5 * (low + high));
}

}  // namespace

std::string Divergence::Sentence() const {
  return "at " + ShortNumber(time) + " s, " + rod +
         (element >= 0 ? ", element " + std::to_string(element) : "") + ": " + why;
}

double KineticEnergy(const Rod& rod) {
  double energy = 0;
  for (Index i = 0; i < rod.mass.size(); ++i) {
    energy += 0.5 * rod.mass[i] * rod.velocity.col(i).squaredNorm();
  }
  for (Index i = 0; i < rod.elements(); ++i) {
    energy += 0.5 * rod.inertia.col(i).dot(rod.spin.col(i).cwiseAbs2());
  }
  return energy;
}

double EnergyBudget(const Scene& scene, const std::vector<Driven>& rods) {
  double budget = 0;
  // What falls or flies may hit the rods, and so may what pushes do.
  for (const SceneObject& object : scene.objects) {
    if (object.motion == ObjectMotion::kFixed) continue;
    const double spinning = 0.5 * object.inertia.dot(object.spin.cwiseAbs2());
    budget += 0.5 * object.mass * object.velocity.squaredNorm() + spinning;
    for (const Driven& d : rods) budget += 2 * object.mass * scene.gravity.norm() * d.rod.rest_length.sum();
  }
  for (const Push& push : scene.pushes) {
    const double impulse = push.force.norm() * (push.until - push.from);
    // Of a long push no more than its work along what rods can give by.
    double longest = 0;
    for (const Driven& d : rods) longest = std::max(longest, d.rod.rest_length.sum());
    budget +=
        std::min(0.5 * impulse * impulse / scene.objects[push.object].mass, 2 * longest * push.force.norm());
  }
  // Each pull stores its bending anew.
  const double pulls = std::count_if(scene.phases.begin(), scene.phases.end(),
                                     [](const Phase& phase) { return phase.pull.has_value(); });
  for (const Driven& d : rods) {
    const double speed =
        d.carrier != nullptr ? d.carrier->Fastest() + d.carrier->FastestSpin() * d.rod.rest_length.sum() : 0;
    const double flow = scene.medium.flow.norm();
    budget += 0.5 * d.rod.mass.sum() * (speed * speed + flow * flow) + pulls * StoredAtMost(scene, d);
    if (const std::optional<Ejection> ejection = EjectionOf(scene, d)) {
      budget += 0.5 * (ejection->velocity.colwise().squaredNorm() * d.rod.mass).value();
    }
    const double length = d.rod.rest_length.sum(), mass = d.rod.mass.sum();
    const double force = mass * scene.gravity.norm() + d.tip_force.norm();
    budget += KineticEnergy(d.rod) + StoredAtMost(scene, d) + StoredByMotion(d);
    if (d.rod.base.hold != EndHold::kFree || d.rod.tip.hold != EndHold::kFree) {
      budget += 2 * length * force + 2 * std::numbers::pi * d.rod.tip_couple.norm();
    } else {
      // Nothing stops it: what the loads do to a free body in the whole time.
      const double couple = d.rod.tip_couple.norm() * scene.duration;
      budget += 0.5 * force * force * scene.duration * scene.duration / mass;
      budget += 0.5 * couple * couple / d.rod.inertia.rowwise().sum().minCoeff();
    }
  }
  return budget;
}

std::optional<Divergence> FindNotFinite(const std::vector<Driven>& rods, const std::vector<Rod>& at) {
  for (std::size_t r = 0; r < at.size(); ++r) {
    for (Index i = 0; i < at[r].mass.size(); ++i) {
      const Index element = std::min(i, at[r].elements() - 1);
      const Vector3d spin = at[r].spin.col(element);
      if (at[r].position.col(i).allFinite() && at[r].velocity.col(i).allFinite() && spin.allFinite())
        continue;
      return At(rods[r], element, "a position or a speed is not finite");
    }
  }
  return std::nullopt;
}

Divergence FindFarTurned(const std::vector<Driven>& rods, const std::vector<Rod>& at, double time_step) {
  double most = -1;
  Divergence found;
  for (std::size_t r = 0; r < at.size(); ++r) {
    const Rod& rod = at[r];
    for (Index i = 0; i < rod.elements(); ++i) {
      // Each as a share of what the kernel allows.
      const double turned = (time_step * rod.spin.col(i)).norm();
      double against = 0;
      if (i + 1 < rod.elements()) against = (RestVoronoi(rod, i) * CurvatureOf(rod, i)).norm();
      const double half = 0.5 * rod.rest_length[i];
      if (i == 0 && rod.base.hold == EndHold::kFrame) {
        against = std::max(against, half * BaseCurvature(rod).norm());
      }
      if (i + 1 == rod.elements() && rod.tip.hold == EndHold::kFrame)
        against = half * TipCurvature(rod).norm();
      if (turned / 1.0 > most) {
        most = turned;
        found = At(rods[r], i, "it turns by " + ShortNumber(turned) + " rad in a step");
      }
      if (against / 1.6 > most) {
        most = against / 1.6;
        found = At(rods[r], i, "what is beside it is turned by " + ShortNumber(against) + " rad against it");
      }
    }
  }
  return found;
}

Divergence FindFastest(const std::vector<Driven>& rods, const std::vector<Rod>& at) {
  double most = -1;
  Divergence found;
  for (std::size_t r = 0; r < at.size(); ++r) {
    for (Index i = 0; i < at[r].elements(); ++i) {
      const double speed = at[r].velocity.col(i + 1).norm();
      if (!(speed > most)) continue;
      most = speed;
      found = At(rods[r], i, "it moves at " + ShortNumber(speed) + " m/s");
    }
  }
  return found;
}

Divergence FindDeepest(const Scene& scene, const std::vector<Driven>& rods, const std::vector<Rod>& at,
                       const std::vector<Eigen::Isometry3d>& poses) {
  double least = HUGE_VAL;
  Divergence found;
  const bool published = scene.contact.law != ContactLaw::kHertzSegments;
  const auto look = [&](std::size_t r, Index i, double distance, double radii, const std::string& other) {
    const double share = distance / radii;
    if (!(share < least)) return;
    least = share;
    found = At(rods[r], i,
               "its axis is " + ShortNumber(1e3 * distance) + " mm from that of " + other + ", " +
                   ShortNumber(share) + " of the radii's sum");
  };
  const auto apart = [&](const Rod& rod, Index i, const Vector3d& start, const Vector3d& end) {
    return ClosestOfSegments(rod.position.col(i), rod.position.col(i + 1), start, end).apart.norm();
  };
  for (std::size_t r = 0; r < at.size(); ++r) {
    for (Index i = 0; i < at[r].elements(); ++i) {
      const double radius = published ? PresentRadius(at[r], i) : at[r].radius[i];
      const Vector3d middle = 0.5 * (at[r].position.col(i) + at[r].position.col(i + 1));
      for (std::size_t o = 0; o < scene.objects.size(); ++o) {
        const SceneObject& object = scene.objects[o];
        const std::string name = object.name.empty() ? "object " + std::to_string(o) : object.name;
        if (published) {
          look(r, i, apart(at[r], i, object.body.start, object.body.end), radius + object.body.radius, name);
          continue;
        }
        for (const Primitive& part : object.shape) {
          const double reach = radius + 0.5 * (at[r].position.col(i + 1) - at[r].position.col(i)).norm();
          if (DistanceTo(part, poses[o].inverse() * middle).distance > reach) continue;
          const double distance = LeastDistance(part, poses[o].inverse() * at[r].position.col(i),
                                                poses[o].inverse() * at[r].position.col(i + 1));
          // A rod alike under the surface would be that near.
          const double share = 0.5 + 0.5 * distance / radius;
          if (!(share < least)) continue;
          least = share;
          found = At(rods[r], i,
                     "it is " + ShortNumber(1e3 * (radius - distance)) + " mm deep in " + name + ", " +
                         ShortNumber((radius - distance) / radius) + " of its radius");
        }
      }
      for (std::size_t other = 0; other <= r; ++other) {
        const Rod& b = at[other];
        for (Index j = other == r ? FirstThatMayTouch(b, i, scene.contact.law) : 0; j < b.elements(); ++j) {
          look(r, i, apart(at[r], i, b.position.col(j), b.position.col(j + 1)),
               radius + (published ? PresentRadius(b, j) : b.radius[j]),
               rods[other].name + ", element " + std::to_string(j));
        }
      }
    }
  }
  return found;
}

}  // namespace tendril
