#pragma once
// A tentacle's design as a person states it, and the flat sheet that follows from it: where its holes,
// creases and facets lie.
//
// SI units, angles in radians. Holes, creases and facets are numbered from the base: crease i lies midway
// between holes i and i+1, facet i carries hole i, creases i-1 and i bound facet i.
// The sheet's frame: origin at hole 0, z along the centerline toward the tip, y across, x the outer face's
// normal; the flat sheet is x = 0. A crease at angle a runs along cos(a) z + sin(a) y.

#include <Eigen/Core>
#include <numbers>
#include <optional>
#include <vector>

#include "model/result.h"

namespace tendril {

enum class FoldLaw {
  kPaper,  // phi - phi0 = k d / W, tendon between holes 2 d cos(phi)
  kExact,  // exact_law.h
};

// Defaults are the paper's values (Methods, "Modeling origami folding kinematics").
struct TentacleDesign {
  double length = 0.750;                      // cut length, m
  double base_width = 0.020;                  // m
  double taper = 0.5;                         // tip width / base width
  double unit_length = 0.030;                 // b + c, m
  double spacing_ratio = 0.5;                 // c / b
  double alpha = std::numbers::pi / 2;        // angle of creases 0, 2, 4, ..., rad
  double beta = 75 * std::numbers::pi / 180;  // angle of creases 1, 3, 5, ..., rad
  int holes = 49;
  double hole_diameter = 0.002;                // m
  double thickness = 1.0e-4;                   // m
  double youngs_modulus = 4.0e9;               // PET, Pa
  double closed_angle = std::numbers::pi / 2;  // phi_max, rad, in (0, pi/2]
  // Beyond the paper; these values give the paper's model.
  double crease_length = 1.0e-3;  // m, so that a hinge's stiffness is E I / crease_length
  double rest_angle = 0;          // phi0, rad
  double stiffness_exponent = 1;  // a crease's stiffness grows with width^p
  double stiffness_ratio = 1;     // stiffness of beta creases / alpha creases at equal width
  double tendon_friction = 0;     // mu
  double wrap_angle = 5.7 * std::numbers::pi / 180;  // theta0 at each hole edge, rad
  // What a calibration found. A law: scenes fold by it, rest angle and friction included; none: as published.
  std::optional<FoldLaw> law;
  double pull_scale = 1;  // the tendon's real pull / the one commanded, in scenes
};

// The flat sheet. H holes, H - 1 creases, H facets.
struct TentacleLayout {
  Eigen::VectorXd hole_z;        // m; hole_z[0] = 0                                    (H)
  Eigen::VectorXd crease_z;      // where the crease crosses the centerline, m          (H-1)
  Eigen::VectorXd crease_angle;  // to the centerline, rad, in (0, pi)                  (H-1)
  Eigen::VectorXd half_spacing;  // d_i: crease to either neighbouring hole, m          (H-1)
  Eigen::VectorXd width;         // w_i: ribbon width at the crease's centre, m         (H-1)
  Eigen::VectorXd stiffness;  // relative to a crease of base width: (w/w_b)^p, times the ratio for beta (H-1)
  double base_z = 0;          // the sheet's cut ends, m: base_z <= 0 < tip_z
  double tip_z = 0;
  std::vector<Eigen::Matrix3Xd> facets;  // corners in the sheet's frame, counter-clockwise seen from +x  (H)
};

// errors  kBadInput: a value out of its range (names the field, the value and the range)
Status CheckDesign(const TentacleDesign& design);

// Lays out holes, creases and facets (docs/physics.md, "Counts"). Spacing b, c, b, ... from the base; what
// the holes do not use of the length is shared equally by the two ends.
//   errors  as CheckDesign; kBadInput if the holes need more than the cut length
Result<TentacleLayout> LayOut(const TentacleDesign& design);

// The ribbon's width at z of the sheet, m; linear over the cut length (docs/physics.md, "Widths").
double WidthAt(const TentacleDesign& design, const TentacleLayout& layout, double z);

// The design whose tentacle coils with the opposite chirality: every crease angle a becomes pi - a.
TentacleDesign Mirrored(TentacleDesign design);

// L in the tendon's equation: hole-to-hole length of the flat sheet, sum of 2 d_i, m.
double FlatTendonLength(const TentacleLayout& layout);

}  // namespace tendril
