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
#include <limits>
#include <span>
#include <vector>

#include "capture/rig/camera_model.h"
#include "capture/rig/tag_layout.h"
#include "capture/track/chain_options.h"
#include "model/fold/design.h"
#include "model/geometry/framed_curve.h"

namespace tendril {

// One tag of this tentacle as one camera saw it.
struct TagView {
  int camera = 0;
  const TagPlace* place = nullptr;         // outlives the call
  Eigen::Matrix<double, 2, 4> corners_px;  // in the place's order
  // Stated error of a corner's coordinate, root mean square of the eight; NaN: not known.
  double sigma_px = std::numeric_limits<double>::quiet_NaN();
};

// Fold angles that other moments know of; entries of sigma NaN, or none: not recalled.
struct RecalledAngles {
  Eigen::VectorXd angle;  // phi_i, rad                                                            (creases)
  Eigen::VectorXd sigma;  // rad                                                                   (creases)
};

// What is known of a tentacle before it is seen.
struct ChainModel {
  TentacleLayout layout;
  Eigen::VectorXd expected_angle;  // phi_i by the fold law at the commanded pull, rad             (creases)
  double closed_angle = 1.5707963267948966;                             // phi_max, rad
  Eigen::Isometry3d lab_from_tentacle = Eigen::Isometry3d::Identity();  // where the gripper holds it
  RecalledAngles recalled = {};
};

inline constexpr double kToldByPictures = 0.5;  // share from which the pictures count as telling an angle

struct ChainSolution {
  std::vector<FacetState> facets;  // (holes)
  Eigen::VectorXd angle;           // phi_i, rad                                                   (creases)
  Eigen::VectorXd angle_sigma;     // of these, rad; NaN: not known                                (creases)
  // Share of what is known of phi_i that this moment's pictures tell, 0 to 1                      (creases)
  Eigen::VectorXd angle_by_pictures;
  FramedCurve curve;             // nodes are the holes, in the lab
  Eigen::VectorXd sigma;         // root mean square distance to the true hole, m; NaN: not seen   (holes)
  Eigen::VectorXi interpolated;  // 1: no view of the facet was used                               (holes)
  // F F^T is about the covariance of the points (x0 y0 z0 x1 ...), each point's own exact; also for nodes
  // that were not seen. Empty if covariance_rank is 0.                                       (3 holes, rank)
  Eigen::MatrixXd covariance_factor;
  // G: with points off by F z, normals are turned about the curve by G z, right-handed about the tangent; its
  // first columns are those of F, z goes on. rad. Empty as the above.           (holes, more than rank)
  Eigen::MatrixXd turn_factor;
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
