#pragma once
// Derivatives of a fold: how fold angles and holes move as the design, the pull or the stiffnesses change.
// Analytic, by the implicit function theorem (docs/physics.md, "Derivatives").
//
// Creases that are flat or closed stay so: where one begins to fold or closes, the answer is one-sided. At
// pull 0 the angles go as the square root of the pull: TENDRIL_CHECK fails there, and where a tension is
// infinite.

#include <Eigen/Core>

#include "model/fold/design.h"
#include "model/fold/exact_law.h"
#include "model/fold/fold.h"

namespace tendril {

// A direction in which a design and its pull change; members as in TentacleDesign.
struct DesignChange {
  double length = 0, base_width = 0, taper = 0, unit_length = 0, spacing_ratio = 0;
  double alpha = 0, beta = 0;
  double thickness = 0, youngs_modulus = 0, crease_length = 0;
  double rest_angle = 0, stiffness_exponent = 0, stiffness_ratio = 0;
  double tendon_friction = 0, wrap_angle = 0;
  double pull = 0;
};

// The same for what a law is given. An empty vector: no change.
struct FoldChange {
  double pull = 0;
  double rest_angle = 0;          // rad
  Eigen::VectorXd log_stiffness;  // of ln B_i; law `paper`: of ln W_i                            (creases)
  Eigen::VectorXd half_spacing;   // of d_i, m                                                    (creases)
  Eigen::VectorXd crease_angle;   // of a_i, rad                                                  (creases)
};

// layout: LayOut(design)
FoldChange ChangeForPaperLaw(const TentacleDesign& design, const TentacleLayout& layout,
                             const DesignChange& change);
FoldChange ChangeForExactLaw(const TentacleDesign& design, const TentacleLayout& layout,
                             const DesignChange& change);

// d phi_i of law `paper`.   fold: SolveFold for this layout, at a pull above 0                     (creases)
Eigen::VectorXd SlopeOf(const TentacleLayout& layout, const Fold& fold, const FoldChange& change);

struct ExactSlope {
  Eigen::VectorXd angle;   // d phi_i                                                              (creases)
  double log_tension = 0;  // d ln T; 0 where slack
};

// Of law `exact`.   fold: SolveExactFold for this layout, rest angle and closed angle
ExactSlope SlopeOf(const TentacleLayout& layout, const ExactFold& fold, double rest_angle,
                   double closed_angle, const FoldChange& change);

// How the holes move in the tentacle's frame (facet_chain.h), m.                                      (3, H)
//   angle, angle_slope  phi_i and d phi_i                                                          (creases)
//   change              its half_spacing and crease_angle count
// Creases lie midway between their holes, as LayOut has them; the first one is not closed at pi / 2.
Eigen::Matrix3Xd HoleSlopes(const TentacleLayout& layout, const Eigen::VectorXd& angle,
                            const Eigen::VectorXd& angle_slope, const FoldChange& change);

}  // namespace tendril
