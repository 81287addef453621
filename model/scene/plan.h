#pragma once
// What a scene requires of the physics: which terms are on, how long a step may be, and the estimates that
// say so.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "model/result.h"
#include "model/rods/rod.h"
#include "model/scene/driven.h"
#include "model/scene/scene.h"

namespace tendril {

// For messages: six digits.
std::string ShortNumber(double value);

// A part of the physics, whether this scene requires it, and the estimate by which that was told.
struct PlanTerm {
  std::string name;
  bool on = false;
  std::string why;
};

// What stands in for a term that is off: the rods are softer, or heavier against acceleration, than they are,
// by as much as the estimate allows.
struct RodRelief {
  double stretch = 1;         // E A is divided by it
  double shear = 1;           // alpha_c G A likewise
  double rotary_inertia = 1;  // elements' moments of inertia across their axes are multiplied by it
  double mass = 1;            // all inertia is; weight and damping force stay
};

struct SimulationPlan {
  double time_step = 0;    // s, the largest taken
  double stable_step = 0;  // s, of the stiffest rod
  std::string step_why;
  bool rod_contact = false, self_contact = false, object_contact = false;
  int contact_points = 1;  // of an element, where the energy of contact is reckoned (press.h)
  RodRelief relief;
  bool plain = false;  // step in the plain form, hundreds of times slower: to check the fast one
  std::vector<PlanTerm> terms;
};

// What the scene requires. Contact is left out only where nothing can meet: rods farther apart than they are
// long. A strain is left out where it changes a rod by less than kPlanTolerance of its length.
//   full    everything on
//   errors  as MakeRods; a scene without rods
Result<SimulationPlan> PlanScene(const Scene& scene, bool full = false);

inline constexpr double kPlanTolerance = 1e-3;

// The largest stable steps of a straight rod, 2 / omega of the fastest wave, s: each the shortest over its
// elements; bound from below (docs/rods.md, "Step").
struct StableSteps {
  double stretch = 0, bend = 0, twist = 0, shear = 0, contact = 0;
  double Least() const;
};
//   contact_stiffness  N/m^(3/2); 0: none;  contact_damping  N s/m
StableSteps StableStepsOf(const Rod& rod, double contact_stiffness, double contact_damping = 0);

// The largest that is stable for a rod that sticks by its surface along its whole length, with its bending
// waves: what pulls there also turns the elements, the more easily the thinner and the shorter they are. A
// bound from below.
double StickingStep(const Rod& rod, const Contact& contact);

void ApplyRelief(const RodRelief& relief, Rod& rod);

}  // namespace tendril
