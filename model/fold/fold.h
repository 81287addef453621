#pragma once
// Fold angles of one tentacle: given how far the tendon is pulled, how far does each crease close?
// Pure functions, safe to call from any thread. Angles in radians; phi is half of a crease's outer angle.

#include <Eigen/Core>
#include <vector>

#include "model/fold/design.h"
#include "model/result.h"

namespace tendril {

struct Fold {
  Eigen::VectorXd angle;     // phi_i, rad, 0 is flat                                        (creases)
  double scale = 0;          // k in phi_i = min(k d_i / w_i, phi_max), m/m
  std::vector<int> closed;   // creases at phi_max, ascending
  double tendon_length = 0;  // sum 2 d_i cos(phi_i): the law's hole-to-hole length, m
};

// The pull at which every crease has closed: 1 - cos(phi_max), whatever the design.
double LargestPull(double closed_angle);

// Law `paper`: sum_i 2 d_i cos(phi_i) = (1 - pull) L with phi_i = min(k d_i / W_i, phi_max), where W_i is the
// crease's stiffness as a width: w_b * layout.stiffness_i (so that p = 1, ratio = 1 give the paper's w_i).
//   pull     fraction of the tendon's flat length that is taken in, 0 .. LargestPull()
//   returns  angles to 1e-12 relative, from pull 1e-300 to the last pull below reach; pull 0 gives k = 0
//   exactly errors   kBadInput    pull < 0 or not finite
//            kUnreachable pull > LargestPull(); the message names that bound
//   source   paper, Methods, the equation of L_t(gamma); docs/physics.md, "Fold angles"
// Solved for the shortening, sum_i 4 d_i sin^2(phi_i / 2) = pull L, because 1 - cos loses every digit near
// the flat state. closed_angle = pi / 2 stands for a right angle: a closed perpendicular crease's holes meet.
Result<Fold> SolveFold(const TentacleLayout& layout, double base_width, double closed_angle, double pull);

// The same for a design; lays it out first.
Result<Fold> SolveFold(const TentacleDesign& design, double pull);

}  // namespace tendril
