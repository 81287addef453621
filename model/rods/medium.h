#pragma once
// What a rod feels of the medium it moves in: buoyancy, drag and added mass (docs/media.md).
//
// SI units. A node stands for half an element on either side, and its tangent is that between its neighbours.
// In the medium a node's inertia differs along and across the tangent t:
//   along   m a_t = F_t + (m - rho V) g_t - rho/2 C_t pi D l |u_t| u_t
//   across  (m + m_a) a_n = F_n + (m - rho V) g_n - rho/2 C_n D l |u_n| u_n,  m_a = C_a rho pi D^2 l / 4
// with u the velocity against the medium's and D, l as unstretched.
//
// Left out: how the added mass changes as the rod turns (its gradient, from which come Munk's moment and
// Lighthill's reactive thrust), the medium's pressure along a curved rod (in effect a change of its tension),
// lift and eddies shed in turn, drag against spin about the rod's axis, and what one body does to the flow
// about another.

#include <Eigen/Core>

#include "model/result.h"
#include "model/rods/rod.h"

namespace tendril {

// A fluid that fills all space and flows evenly. Defaults are for smooth circular cylinders at
// Re = |u| D / nu from 300 to 1e5; docs/media.md has the sources and what they become outside.
struct Medium {
  double density = 0;                              // kg/m^3; 0: vacuum
  Eigen::Vector3d flow = Eigen::Vector3d::Zero();  // m/s
  double cross_drag = 1.1;                         // C_n, on D l: Hoerner 1965
  double along_drag = 0.017;                       // C_t, on pi D l: Taylor 1952, 5.4 / (pi sqrt(Re)) at 1e4
  double added_mass = 1;                           // C_a, on pi D^2 l / 4: potential flow, Lamb 1932
};
Medium Air();    // at 20 C and 101,325 Pa, at rest
Medium Water();  // at 20 C, at rest

// A rod that stands for something of another cross-section, as a thick rod for a thin ribbon.
struct Wetted {
  double drag_diameter_scale = 1;  // D / (2 r)
  double displaced = 1;            // V / (pi r^2 l)
};

//   errors  kBadInput  a value below 0 or not finite (names it)
Status CheckMedium(const Medium& medium);
Status CheckWetted(const Wetted& wetted);

// What the medium makes of a rod's nodes.                                              each (N+1)
struct WettedNodes {
  Eigen::VectorXd weighed;         // m - rho V, kg
  Eigen::VectorXd inverse_across;  // 1 / (m + m_a), 1/kg
  Eigen::VectorXd across_drag;     // rho/2 C_n D l / (m + m_a), 1/m
  Eigen::VectorXd along_drag;      // rho/2 C_t pi D l / m, 1/m
};
WettedNodes WettedNodesOf(const Rod& rod, const Medium& medium, const Wetted& wetted);

// A node's velocity after a kick (keep and gain: DampedKick), m/s. Drag takes the speed from before the kick
// and the velocity from after it, so that however long the step, drag can stop a node and not turn it round;
// the speed of steady sinking is exact for any step. Second order in time for straight motion.
//   edge          between the node's neighbours, or to the only one, m
//   force         on the node but for what comes of the medium and gravity, N
//   inverse_mass  1/kg
Eigen::Vector3d KickInMedium(const WettedNodes& nodes, Eigen::Index node, const Eigen::Vector3d& flow,
                             double keep, double gain, const Eigen::Vector3d& edge,
                             const Eigen::Vector3d& velocity, const Eigen::Vector3d& force,
                             const Eigen::Vector3d& gravity, double inverse_mass);

}  // namespace tendril
