#pragma once
// Rods at rest whose shapes are known: closed forms, and equations solved here without the rods of model/.
//
// Lengths as shares of the rod's unless said, loads without dimension; source with each.

#include <Eigen/Core>

namespace tendril::testing_support {

// The tip-loaded elastica in elliptic integrals (Bisshopp and Drucker 1945), by P L^2 / EI.
struct TipOf {
  double drop, in;  // across and along the undeformed rod
};
TipOf TipLoadedElastica(double load);

// The elastica under its own weight, by W = rho A g L^3 / EI: theta'' = -W (1 - s) cos theta, theta(0) = 0,
// theta'(1) = 0, by Runge-Kutta and bisection.
TipOf HeavyElastica(double weight);

// Tip deflection of a clamped column beyond Euler's load, by P / P_E: sqrt(P / P_E) = 2 K(k) / pi,
// w = 2 k / (pi / 2 sqrt(P / P_E)).
double BuckledColumn(double load_share);

// M L / EI at which a twisted rod buckles between clamped ends: twice the first root of tan x = x.
double ClampedTwistMoment();

// A Cosserat rod that is an arc of curvature kappa about d1, clamped, under a dead load on its tip: m' = -t x
// f, directors and centreline by Runge-Kutta from the base, whose moment is found by Newton's method so that
// the tip's is 0. SI units, lab frame; the base's directors as rows.
struct LoadedArc {
  double length, curvature, bend, twist, shear, stretch;
};
Eigen::Vector3d TipOfLoadedArc(const LoadedArc& arc, const Eigen::Matrix3d& base,
                               const Eigen::Vector3d& load);

// The helix that dies away along a long rod, twisted by `turn` (rad) and with its ends nearer by `slack` (m)
// (Coyne 1990; van der Heijden and Thompson 2000): cos theta = 1 - (2 - m^2 / 2) sech^2(s / width), the
// branch of less tilt. Rod of bending and twisting stiffness B and C, N m^2.
struct LocalisedHelix {
  double tension, moment;  // N, N m
  double width;            // m
  double largest_tilt;     // rad
};
LocalisedHelix LocalisedHelixOf(double length, double bend, double twist, double turn, double slack);

}  // namespace tendril::testing_support
