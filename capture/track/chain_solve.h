#pragma once
// From the tag corners that one or more calibrated cameras saw in one frame to one tentacle's shape: the pose
// of each facet, the framed curve through its holes, and how far off each hole may be.
//
// The facets' poses are the unknowns. They are held by the tags' corners in the pictures, by the creases that
// join neighbours (a hinge that gives a little), by the fold law at the commanded pull (loosely) and by the
// place where the gripper holds the base. docs/tracking.md, "Reconstruction".
//
// SI units, rad, px; lab frame. Facets, holes and creases are numbered from the base (model/fold/design.h).

#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "capture/rig/camera_model.h"
#include "capture/rig/tag_layout.h"
#include "capture/track/chain_factors.h"
#include "model/fold/design.h"
#include "model/geometry/framed_curve.h"

namespace tendril {

// One tag of this tentacle as one camera saw it.
struct TagView {
  int camera = 0;
  const TagPlace* place = nullptr;         // outlives the call
  Eigen::Matrix<double, 2, 4> corners_px;  // in the place's order
};

// What is known of a tentacle before it is seen.
struct ChainModel {
  TentacleLayout layout;
  Eigen::VectorXd expected_angle;  // phi_i by the fold law at the commanded pull, rad             (creases)
  double closed_angle = 1.5707963267948966;                             // phi_max, rad
  Eigen::Isometry3d lab_from_tentacle = Eigen::Isometry3d::Identity();  // where the gripper holds it
};

// How firmly each piece of knowledge is held: 1-sigma values.
struct ChainOptions {
  double sigma_corner_px = 0.12;      // the detector's corners
  double sigma_tag_place = 0.15e-3;   // a tag against its place on the facet, each axis, m
  double sigma_tag_turn = 0.015;      // likewise, and the facet's bending, each axis, rad
  double sigma_hole = 0.10e-3;        // a hole against its place on the facet, each axis, m
  double sigma_gap = 0.20e-3;         // a crease as carried by its two facets, each axis, m
  double sigma_swing = 0.015;         // turning about other axes than the crease, rad
  double sigma_angle = 0.05;          // a crease's phi about what its neighbours suggest, rad
  double sigma_opening = 0.20;        // how far the whole tentacle opens or closes beyond the law, rad
  double sigma_opening_walk = 0.015;  // change of that from one crease to the next, rad
  double sigma_base_place = 1.5e-3;   // hole 0 against its nominal place, each axis, m
  double sigma_base_turn = 0.03;      // its facet likewise, about other axes than the crease, rad
  double sigma_base_fold = 0.15;      // and about its crease, rad
  // Of a view about what all else predicts, per corner coordinate; beyond it the view is left out.
  double largest_chi_square = 6;
  // A hole is "not seen" (sigma NaN) if its facet was not and either holds:
  double farthest_seen = 0.15;   // m along the sheet to the nearest facet that was seen
  double largest_sigma = 0.020;  // m
  int covariance_rank = 36;      // columns of the covariance factor, about; 0: none
  int max_iterations = 60;
};

struct ChainSolution {
  std::vector<FacetState> facets;  // (holes)
  Eigen::VectorXd angle;           // phi_i, rad                                                   (creases)
  FramedCurve curve;               // nodes are the holes, in the lab
  Eigen::VectorXd sigma;           // root mean square distance to the true hole, m; NaN: not seen   (holes)
  Eigen::VectorXi interpolated;    // 1: no view of the facet was used                               (holes)
  // F F^T is about the covariance of the points (x0 y0 z0 x1 ...), each point's own exact; also for nodes
  // that were not seen. Empty if covariance_rank is 0.                                       (3 holes, rank)
  Eigen::MatrixXd covariance_factor;
  std::vector<char> used;  // which views were used                                                 (views)

  int iterations = 0;
  bool converged = false;
  int views_used = 0;
  int views_rejected = 0;  // wrong identities, outliers, behind the camera, not finite
  int facets_seen = 0;
  double chi_square = 0;  // of everything, per degree of freedom; about 1 if the sigmas are right
  double rms_reprojection_px =
      0;  // per corner of the views used, each tag at its most probable place; NaN: none
  double seconds = 0;
};

// The shape that fits best. Always an answer with finite points: with no usable view it is the fold law's
// shape at the gripper, and no node counts as seen.
//   previous  the frame before's answer, tried as another start; may be null
ChainSolution SolveChain(const ChainModel& model, std::span<const Camera> cameras,
                         std::span<const TagView> views, const ChainOptions& options = {},
                         const ChainSolution* previous = nullptr);

// lab_from_sheet of one facet.
Eigen::Isometry3d LabFromSheet(const TentacleLayout& layout, const FacetState& facet, int number);

}  // namespace tendril
