#pragma once
// Law `exact`: the fold angles of least elastic energy at a given pull, under the true distances between
// holes. Pure functions, safe to call from any thread. Angles in radians; phi is half of a crease's outer
// angle.

#include <Eigen/Core>
#include <vector>

#include "model/fold/design.h"
#include "model/result.h"

namespace tendril {

struct ExactFold {
  Eigen::VectorXd angle;    // phi_i, rad                                                      (creases)
  double tension = 0;       // T, N; the same all along (no friction); infinity where a shape is only a limit
  bool slack = false;       // the pull is below the rest shape's own: T = 0, phi_i = phi0
  std::vector<int> closed;  // creases at phi_max, ascending
  Eigen::VectorXd
      closing_moment;  // by which the facets of a closed crease press on each other, N m; else 0 (creases)
  double tendon_length = 0;  // hole to hole, m
};

// Stiffness B_i of each crease as a hinge, N m per radian of its outer angle 2 phi: E I / crease_length with
// I = w t^3 / (12 sin a), w_b (w / w_b)^p times the ratio in place of w.                            (creases)
Eigen::VectorXd HingeStiffness(const TentacleDesign& design, const TentacleLayout& layout);

// The pull at which every crease is at phi_max; at phi_max = pi/2 an oblique crease only tends to it.
double LargestExactPull(const TentacleLayout& layout, double closed_angle);

// Minimises sum 2 B_i (phi_i - phi0)^2 over phi0 <= phi_i <= phi_max under sum 2 d_i sqrt(1 - sin^2 a_i sin^2
// phi_i) = (1 - pull) L. Per crease 2 B (phi - phi0) = T d sin^2 a sin phi cos phi / sqrt(1 - sin^2 a sin^2
// phi): with phi0 = 0 it stays flat up to T = 2 B / (d sin^2 a). The minimum is unique (docs/physics.md).
//   hinge_stiffness  B_i, > 0                                                                       (creases)
//   rest_angle       phi0, 0 .. closed_angle
//   returns  angles that meet every equation to a few rounding errors. Where a crease begins to fold its
//            angle goes as the square root of T: there, and only there, it is ill-conditioned.
//   errors   kBadInput    pull < 0 or not finite, phi0 out of its range
//            kUnreachable pull > LargestExactPull(); the message names that bound
Result<ExactFold> SolveExactFold(const TentacleLayout& layout, const Eigen::VectorXd& hinge_stiffness,
                                 double rest_angle, double closed_angle, double pull);

// The same for a design; lays it out first.
Result<ExactFold> SolveExactFold(const TentacleDesign& design, double pull);

}  // namespace tendril
