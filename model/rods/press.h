#pragma once
// The energy between two elements that press on each other (kHertzSegments), its forces, and where they act.
//
// A point of the axis of a, at h from the axis of b and within both radii R of it, stores with a piece dt of
// b
//
//   K c (c^2 - t^2) dt,   c^2 = R^2 - h^2,   |t| < c along b from the point's foot,
//
// per length of a, and points of b with pieces of a likewise; half of either counts. Pieces add up over
// elements without a joint, so a crossing is the same wherever it lies on them; K makes rods that cross at a
// right angle press with k eps^(3/2) (1 - 1.75 eps / R + ...), and rods side by side, per length, with
// 0.75 k (2 R)^(-1/2) eps (1 - 1.5 eps / R + ...).

#include <Eigen/Core>

#include "model/rods/contact.h"

namespace tendril {

struct PressSide {
  Eigen::Vector3d start, end;  // of the element's axis, m
  double radius = 0;           // at rest, m
  double rest_length = 0;      // m
};

struct Press {
  bool presses = false;
  double energy = 0;                               // J
  Eigen::Vector3d a_start, a_end, b_start, b_end;  // minus the energy's gradient, N
  // What is across the axes, without what ends of rods push along them: on a, N.
  Eigen::Vector3d normal_force = Eigen::Vector3d::Zero();
  double a_share = 0.5, b_share = 0.5;  // where on the axes it acts
  double stiffness = 0;                 // about d force / d depth, N/m
  double stick_stiffness = 0;           // of what sticks, per tangential_ratio: constant for the pair, N/m
};

//   points  of either element where its energy is reckoned
Press PressOf(double stiffness, int points, const PressSide& a, const PressSide& b);

// K / 2 of the sum of radii, and a pair's stick_stiffness of it.
double PressFactor(double stiffness, double radii_sum);
double StickStiffness(double factor, double radii_sum, double rest_lengths_sum);

// The stiffness of a crossing whose depth is 5 % of the radii's sum, N/m: to which a contact's damping
// refers.
double ReferenceStiffness(double stiffness, double radii_sum);

// Of a rod of this radius on a surface, per length: N/m^2. As of a crossing with its like.
double SurfaceStiffness(double stiffness, double radius);

}  // namespace tendril
