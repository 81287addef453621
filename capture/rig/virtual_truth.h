#pragma once
// The hidden truth of the virtual rig: what shape do the tentacles of one virtual trial really have at a
// time? It is near the fold model but not on it: creases and holes sit a little off, facets are bent, the
// tentacle sags, the base is not quite where the drawing says, the tendons start late. Nothing that tracks or
// fits reads this; the recorder writes it beside the recording (truth.h5, truth.toml) for those who judge the
// result.
//
// SI units, radians. What is drawn and from which ranges: docs/virtual_rig.md.

#include <Eigen/Geometry>
#include <numbers>
#include <random>
#include <vector>

#include "capture/rig/tag_layout.h"
#include "model/fold/design.h"
#include "model/fold/gripper.h"
#include "model/fold/rising_fold.h"
#include "model/geometry/framed_curve.h"
#include "model/result.h"

namespace tendril {

// The fold model's true parameters: one set for all trials of a study, the answer that a fit should find.
struct TrueFold {
  double pull_scale = 0.95;       // effective pull / commanded pull
  double stiffness_ratio = 1.0;   // beta creases / alpha creases
  double stiffness_exponent = 1;  // a crease's stiffness grows with width^p
  FoldLaw law = FoldLaw::kPaper;  // by which the tentacles really fold
  double rest_angle = 0;          // phi0, rad
  double friction = 0;            // mu of the tendon at the holes; pulls only rise
};

// What differs from trial to trial. A deviation of 0 switches its draw off.
struct TruthRanges {
  double position_sd = 0.15e-3;                           // holes (z and y) and creases (z), m
  double crease_angle_sd = 0.3 * std::numbers::pi / 180;  // rad
  double stiffness_sd = 0.03;                             // of log(stiffness), per crease
  double facet_bend_sd = 3.0 * std::numbers::pi / 180;    // turn from one end of a facet to the other, rad
  double largest_sag_compliance = 1.0;                    // uniform from 0, rad per N m of weight at a crease
  double base_position_sd = 0.5e-3;                       // each axis, m
  double base_angle_sd = 0.5 * std::numbers::pi / 180;    // about each axis, rad
  double largest_delay = 0.5;                             // uniform from 0, s; paper, Methods
  double rate_perturbation = 0.001875;  // uniform between minus and plus, 1/s; paper, Methods
  double tag_place_sd = 0.10e-3;        // glue: a tag against its drawn place, along the sheet's y and z, m
  double tag_turn_sd = 0.4 * std::numbers::pi / 180;      // glue: likewise, about the sheet's normal, rad
  double object_position_sd = 0.005;                      // each axis, m
  double object_angle_sd = 3.0 * std::numbers::pi / 180;  // about each axis, rad
};

// A cylinder in the lab frame; radius 0: no object.
struct VirtualCylinder {
  Eigen::Vector3d center = {0, 0, -0.15};
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();
  double radius = 0.0225;
  double length = 0.280;
};

// How the tendons were told to move: from 0 at `rate` to `pull`, then held.
struct PullCommand {
  double pull = 0.3;   // of the tendon's flat length
  double rate = 0.03;  // 1/s
};

struct TentacleTruth {
  TentacleLayout layout;       // with holes, creases, stiffness and facets where they really are
  Eigen::VectorXd hole_y;      // m                                                   (holes)
  Eigen::VectorXd facet_bend;  // turn from one end of a facet to the other, rad      (facets)
  double sag_compliance = 0;   // rad / (N m)
  Eigen::Isometry3d lab_from_tentacle = Eigen::Isometry3d::Identity();
  double delay = 0;        // s
  double rate_offset = 0;  // 1/s
};

struct VirtualTruth {
  TentacleDesign design;  // as drawn, with the true stiffness ratio and exponent, rest angle and friction
  TrueFold fold;
  PullCommand command;
  std::vector<TentacleTruth> tentacles;
  VirtualCylinder object;
};

// Draws the truth of one trial.
//   errors  kBadInput: the design's; a range that is negative or so wide that holes and creases change places
Result<VirtualTruth> DrawTruth(const TentacleDesign& design, const Gripper& gripper, const TrueFold& fold,
                               const PullCommand& command, const VirtualCylinder& object,
                               const TruthRanges& ranges, std::mt19937_64& random);

// The same tags where somebody's hands put them: each moved and turned within the sheet's plane.
TagLayout GlueTags(const TagLayout& drawn, const TruthRanges& ranges, std::mt19937_64& random);

// A flat piece of a bent facet.
struct TrueStrip {
  int facet = 0;
  double from_z = 0;  // joined to its neighbours in the facet along these lines of the sheet, m
  double to_z = 0;
  Eigen::Matrix3Xd corners_in_sheet;  // convex, counter-clockwise seen from +x, m
  Eigen::Vector2d hole_in_sheet;      // (y, z) of the facet's hole, m
  Eigen::Isometry3d lab_from_sheet = Eigen::Isometry3d::Identity();
};

struct TrueTentacle {
  double command = 0;             // pull that the tentacle's servo stands for, delay and rate included
  double pull = 0;                // effective: pull_scale * command
  Eigen::VectorXd fold_angle;     // phi_i, rad                                    (creases)
  std::vector<TrueStrip> strips;  // three per facet, from base to tip
  FramedCurve centerline;         // nodes are the holes, in the lab
};

struct TrueShape {
  double time = 0;  // s since the trial began
  std::vector<TrueTentacle> tentacles;
  VirtualCylinder object;
};

// Pull commanded to a tentacle's servo at a time.
double CommandAt(const VirtualTruth& truth, int tentacle, double time);

//   errors  kUnreachable: the effective pull is beyond the design's reach; kBadInput as SolveRisingFold
Result<TrueShape> TrueShapeAt(const VirtualTruth& truth, double time);

// Where a tag's corners really are, in the lab, m.
Eigen::Matrix<double, 3, 4> TrueTagCorners(const TrueShape& shape, const TagPlace& tag);

}  // namespace tendril
