#pragma once
// Rods stepped in the plainest way: the oracle that faster steppers must agree with, and the paper's own
// discretisation to compare with.

#include <Eigen/Core>
#include <functional>
#include <span>
#include <vector>

#include "model/rods/medium.h"
#include "model/rods/rod.h"

namespace tendril {

enum class RodForm {
  kPaper,   // Gazzola et al. 2018 with their dilatation factors; they are not an energy's gradient
  kEnergy,  // loads are minus the gradient of EnergyOf; elements turn as free tops between kicks (symplectic)
};

// Internal loads of a rod, from its present state.
//   force   on nodes, N                                                                     (3, N+1)
//   couple  on elements, in their axes, N m; with kPaper also the terms in spin             (3, N)
//   source  Gazzola, Dudte, McCormick, Mahadevan 2018, eqs. 2.13-2.16; docs/rods.md
void InternalLoads(const Rod& rod, RodForm form, Eigen::Matrix3Xd& force, Eigen::Matrix3Xd& couple);

struct PlainOptions {
  RodForm form = RodForm::kEnergy;
  double time_step = 2e-5;                            // s
  double damping = 0;                                 // 1/s: velocities and spins decay as exp(-damping t)
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  // m/s^2
  const Medium* medium = nullptr;                     // null: vacuum
  Wetted wetted = {};                                 // of every rod that is stepped with these
};

// The parts of a step, for rods whose forces depend on rods elsewhere: half a drift, forces, kick, half a
// drift. What is held stays where it is.
//   outside          forces on nodes, N                                                     (3, N+1)
//   outside_couples  on elements, along the lab's axes, N m                                 (3, N), or none:
//   0
void DriftPlain(Rod& rod, RodForm form, double time);
void KickPlain(Rod& rod, const PlainOptions& options, const Eigen::Matrix3Xd& outside,
               const Eigen::Matrix3Xd& outside_couples = {});

// Velocity and spin after a kick of rate a: keep * (their value) + gain * a. kPaper: damping after the kick,
// as published; kEnergy: as a constant rate and damping would have it together, exactly.
struct DampedKick {
  double keep = 1;
  double gain = 0;  // s
};
DampedKick KickOf(RodForm form, double time_step, double damping);

// One step of position Verlet, in place; all rods together.
//   time       at the step's start, s
//   at_middle  called at time + time_step / 2 with positions and directors of that moment: sets rest strains
//              and curvatures and adds external forces (columns as the rods' nodes) to those that are there
using MiddleOfStep =
    std::function<void(double time, std::span<Rod> rods, std::span<Eigen::Matrix3Xd> forces)>;
void StepPlain(std::span<Rod> rods, double time, const PlainOptions& options,
               const MiddleOfStep& at_middle = {});

}  // namespace tendril
