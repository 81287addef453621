#pragma once
// A tendon that rubs at the holes: tension differs along the tentacle and depends on how the pull was
// reached.

#include <Eigen/Core>
#include <vector>

#include "model/fold/design.h"
#include "model/fold/fold_slope.h"
#include "model/fold/hinge.h"
#include "model/result.h"

namespace tendril {

struct FrictionFold {
  Eigen::VectorXd angle;        // phi_i, rad                                                       (creases)
  Eigen::VectorXd tension;      // of the tendon across each crease, from the base, N               (creases)
  double tendon_length = 0;     // hole to hole, m
  bool slack = false;           // no tension anywhere and more taken in than the pull
  Eigen::VectorXd angle_slope;  // d phi_i along what Follow was told; empty: nothing           (creases)
};

// Quasi-static pulls and releases under law `exact` with capstan friction: across hole i the tension changes
// by at most the factor exp(eta_i), eta_i = mu (theta0 + the tendon's deflection at the hole); it slides
// where it would change by more, and sticks elsewhere.
class FrictionTendon {
 public:
  // Flat, or at its rest angle, the tendon without tension.
  //   errors  as LayOut; kBadInput tendon_friction or wrap_angle below 0, rest_angle out of law exact's range
  static Result<FrictionTendon> Make(const TentacleDesign& design);

  // Goes to a pull, by the shortest way from the last one, in steps of 0.01 or less. A pull that the rest
  // shape exceeds leaves the tendon slack.
  //   errors  as SolveExactFold; the state is then as before
  Result<FrictionFold> MoveTo(double pull);

  // From now on answers carry their derivative along this change, friction and all that led here included
  // (where the tendon stuck counts). The change's pull is that of each MoveTo's end. One-sided where a hole
  // begins to slide or a crease to fold or to close; a hole at which the tendon runs straight counts as
  // staying straight. To be called before the first MoveTo.
  void Follow(const DesignChange& change);

 private:
  FrictionTendon() = default;
  void Step(double pull, double pull_slope);
  // Along the change, from the tensions before a step to those after it.
  Eigen::VectorXd TensionSlope(const Eigen::VectorXd& after, double pull, double pull_slope) const;
  HingeChange ChangeOf(Eigen::Index crease) const;
  // At which the holes draw together by `wanted`, looked for near another; `next` is scratch.
  double BaseTension(double wanted, double near, Eigen::VectorXd& next) const;
  // Tensions that follow from one at the base, given those before (play operators in a row).
  void Slide(double base_tension, Eigen::VectorXd& tension) const;
  double Shortening(const Eigen::VectorXd& tension) const;  // m
  Eigen::VectorXd AnglesAt(const Eigen::VectorXd& tension) const;

  TentacleDesign design_;
  TentacleLayout layout_;
  std::vector<Hinge> hinges_;
  double friction_ = 0;
  double wrap_angle_ = 0;
  double flat_ = 0;
  double largest_pull_ = 0;
  double pull_ = 0;
  Eigen::VectorXd tension_;
  bool following_ = false;
  FoldChange change_;
  double friction_change_ = 0;
  double wrap_angle_change_ = 0;
  Eigen::VectorXd tension_slope_;  // N
  Eigen::VectorXd eta_;  // at the hole before each crease; that of crease 0 does not count    (creases)
};

}  // namespace tendril
