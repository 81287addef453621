#pragma once
// What a crease that is out of sight was seen to do a moment before or after: the fixed-lag temporal prior.
// An angle is recalled as surely as that moment's own pictures told it; what it owed to expectations is not
// counted a second time. docs/tracking.md, "Near moments".
//
// SI units, rad.

#include <span>

#include "capture/track/chain_solve.h"

namespace tendril {

// Fold angles of one moment, each as (creases).
struct MomentAngles {
  double time = 0;           // s
  Eigen::VectorXd expected;  // phi_i by the fold law
  Eigen::VectorXd angle;     // phi_i as that moment has it by itself
  Eigen::VectorXd sigma;
  Eigen::VectorXd by_pictures;  // as ChainSolution::angle_by_pictures
};

MomentAngles AnglesOf(double time, const ChainModel& model, const ChainSolution& solution);

// Of each crease that `now` is told less of by pictures than by expectation: its angle at the moment that
// knows it best of those that pictures tell it at, carried to `now` by the change of the law's expectation;
// sigma NaN: none of `near` knows.
RecalledAngles RecallAngles(const MomentAngles& now, std::span<const MomentAngles> near,
                            const ChainOptions& options);

}  // namespace tendril
