#pragma once
// Either law's fold angles under a pull that was only ever raised, with a rest angle and tendon friction, and
// their slopes by what a calibration fits (docs/calibration.md, "Models"). Pure functions, safe to call from
// any thread. Angles in radians.

#include <Eigen/Core>
#include <optional>
#include <string>

#include "model/fold/design.h"
#include "model/result.h"

namespace tendril {

const char* NameOf(FoldLaw law);  // "paper", "exact"
std::optional<FoldLaw> FoldLawOf(const std::string& name);

struct RisingFold {
  Eigen::VectorXd angle;    // phi_i, rad                                                        (creases)
  Eigen::VectorXd tension;  // across each crease; law paper: k. Relative: E t^3 / 12 l is left out  (creases)
  double tendon_length = 0;  // by the law's own distances between holes, m
  int closed = 0;            // creases at phi_max
};

// Of phi_i. Closed creases do not move; at pull 0 and rest angle 0 (paper's law: every slope there but that
// by the rest angle is 0 by convention, since the one by pull is infinite).
struct RisingSlopes {
  Eigen::VectorXd pull, rest_angle, friction;  //                                                 (creases)
  Eigen::MatrixXd stiffness;                   // by the directions of ln W that were asked for  (creases, m)
};

// The largest pull that a law can reach with this sheet.
double LargestPullOf(FoldLaw law, const TentacleLayout& layout, double closed_angle);

//   design      closed_angle, base_width, rest_angle, tendon_friction and wrap_angle count
//   layout      half_spacing, crease_angle and stiffness count: they need not be the design's
//   directions  of ln W, for the slopes                                                          (creases, m)
// Across hole i the tension falls by exp(mu (theta0 + deflection)), as tendon_friction.h has it where the
// tendon slides everywhere. Where a crease may be flat or folded at one tension of its neighbour (law exact,
// rest angle 0), it is flat as long as it can be.
//   errors  kBadInput    pull < 0 or not finite; rest angle not in [0, closed_angle); friction < 0
//           kUnreachable pull > LargestPullOf
Result<RisingFold> SolveRisingFold(FoldLaw law, const TentacleDesign& design, const TentacleLayout& layout,
                                   double pull);
// by_friction: false saves the time for that slope where the friction is 0 (it is then 0 here).
RisingSlopes SlopesOf(FoldLaw law, const TentacleDesign& design, const TentacleLayout& layout,
                      const RisingFold& fold, const Eigen::Ref<const Eigen::MatrixXd>& directions,
                      bool by_friction = true);

}  // namespace tendril
