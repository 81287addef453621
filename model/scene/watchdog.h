#pragma once
// What stops a run that has gone wrong, and where it did.

#include <optional>
#include <string>
#include <vector>

#include "model/rods/contact.h"
#include "model/rods/rod.h"
#include "model/scene/driven.h"
#include "model/scene/scene.h"

namespace tendril {

// Where a run stopped making sense.
struct Divergence {
  double time = 0;  // s
  std::string rod;
  Eigen::Index element = 0;      // below 0: of an object, which `rod` names
  std::string why;               // a clause: "an element turns by 1.7 rad against the one before"
  double suggested_step = 0;     // s
  bool at_start = false;         // bodies start inside each other: the scene is wrong, not the step
  std::string Sentence() const;  // all of it
};

// Axes nearer than this share of the radii's sum: the contact no longer holds bodies apart.
inline constexpr double kLeastAxisShare = 0.5;

// Kinetic energy beyond this many times all that the scene can put in comes from the step, not from the
// scene.
inline constexpr double kEnergyFactor = 10;

// The energy that a scene can put into its rods, J: what they start with, what the strongest rest curvature
// and strain store, a fall by twice their length, the work of tip loads along as much, and what moved ends
// carry along.
double EnergyBudget(const Scene& scene, const std::vector<Driven>& rods);
double KineticEnergy(const Rod& rod);

// Rods at one time; names and time are filled in. Nothing: none is so.
//   reach  a batch's kernel stops at 1.6 rad between elements, or 1 rad in a step
std::optional<Divergence> FindNotFinite(const std::vector<Driven>& rods, const std::vector<Rod>& at);
Divergence FindFarTurned(const std::vector<Driven>& rods, const std::vector<Rod>& at, double time_step);
Divergence FindFastest(const std::vector<Driven>& rods, const std::vector<Rod>& at);
// The pair of elements of rods, or of a rod and an object, whose axes are nearest by the radii's sum.
Divergence FindDeepest(const Scene& scene, const std::vector<Driven>& rods, const std::vector<Rod>& at,
                       const std::vector<Eigen::Isometry3d>& poses);

}  // namespace tendril
