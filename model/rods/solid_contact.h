#pragma once
// Objects that touch each other or a table: surface spheres of what moves against the shapes of all others.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "model/rods/contact.h"
#include "model/rods/friction.h"
#include "model/rods/solid.h"

namespace tendril {

class SolidContact {
 public:
  //   masses  of the solids, kg; 0: it does not move
  SolidContact(const Contact& contact, std::span<const Solid> solids, std::span<const double> masses);

  bool CanTouch() const { return !spheres_.empty() && solids_ > 1; }
  // Forces of the present state, added to what is there: linear in depth, stiffness sqrt(1 mm) a sphere,
  // damped a fifth of critically, with friction (roughness.h).
  // Springs of what sticks move on by a step.
  void Add(std::span<const Solid> solids, double time_step, std::span<Wrench> wrenches);

  // The stiffness of a sphere, N/m, and its damping, N s/m.
  static double StiffnessOf(const Contact& contact);
  static double DampingOf(const Contact& contact, double mass);

  std::vector<double> Save() const;
  bool Restore(std::span<const double> saved);

 private:
  struct Sphere {
    std::size_t solid;
    SurfaceSphere at;
    double damping;     // N s/m
    std::size_t first;  // of its springs: one for each part of all solids
  };
  void Touch(const Sphere& sphere, std::span<const Solid> solids, std::size_t other, std::size_t part,
             Stick& stick, double time_step, std::span<Wrench> wrenches) const;

  Contact contact_;
  std::size_t solids_ = 0;
  std::vector<std::size_t> first_part_;  // of each solid
  std::vector<double> reach_;            // of each, m
  std::vector<Sphere> spheres_;
  std::vector<Stick> sticks_;
};

}  // namespace tendril
