#pragma once
// Intrinsics and poses of any number of cameras from pictures of a board: the answer, how sure it is, how
// well it does on pictures that it has not seen, and in words what the pictures are too weak to tell.
//
// Lab frame: camera 0's, unless its given pose or a board that lies in the lab says otherwise. Camera 0's
// pose counts as exact: others' standard errors are about it.

#include <optional>
#include <string>
#include <vector>

#include "calibrate/cameras/bundle.h"
#include "model/progress.h"

namespace tendril {

// A moment in which the board lay at a known place of the lab.
struct BoardInLab {
  std::int64_t stamp = 0;
  Eigen::Isometry3d lab_from_board = Eigen::Isometry3d::Identity();
};

struct CalibrateCamerasOptions {
  // How far the printed board may be from its stated layout, standard deviation of a corner's place, m;
  // 0: it is exact. Corrections of the corners are fitted with this as their prior.
  double board_sigma = 0;
  double outlier = 3;        // sigmas beyond which a corner counts less
  int folds = 5;             // of the cross-validation, over stamps; below 2: none
  double confidence = 0.95;  // of the intervals
  // Standard errors as if no two corners erred together; else moments are what is independent.
  bool independent_corners = false;
  // Known intrinsics, by camera: they stay and only poses are fitted; empty: all are fitted.
  std::vector<Camera> lenses = {};
  std::optional<BoardInLab> lab = {};  // where the lab's frame is; none: by camera 0
  bool refine_lenses = false;  // `lenses` are where their fit starts: views of four corners then suffice
};

struct CalibratedParameter {
  std::string name;           // focal_x_px, k1, position_x_m, rotation_x_rad, ...
  double value = 0;           // rotation: of the vector of the camera's turn in the lab
  double standard_error = 0;  // infinite: not determined
  double low = 0;             // interval
  double high = 0;
};

struct CalibratedCamera {
  std::vector<CalibratedParameter> parameters;
  int views = 0;
  int corners = 0;
  double rms_px = 0;
  double held_out_rms_px = 0;  // NaN: no cross-validation
  double sigma_px = 0;         // of a corner's coordinate
  Eigen::MatrixXd lens_covariance;
};

struct CameraCalibration {
  std::vector<Camera> cameras;
  std::vector<CalibratedCamera> reports;
  Eigen::Matrix3Xd points;     // the board's corners with their corrections, m
  double rms_px = 0;           // distance of seen to projected corners, all cameras
  double held_out_rms_px = 0;  // the same on held-out stamps, where only boards' poses were fitted; NaN: none
  double start_rms_px = 0;     // before the joint adjustment
  int stamps = 0;
  int views = 0;
  int corners = 0;
  int down_weighted = 0;  // corners beyond `outlier`
  BundleCovariance covariance;
  // How much refits without one fold scatter (jackknife), over what the standard errors promise, root mean
  // square over all parameters: near 1 where those hold; NaN: no cross-validation.
  double refit_ratio = 0;
  int folds_used = 0;  // those without which every camera can still be fitted
  bool converged = false;
  int iterations = 0;
  std::vector<std::string> weaknesses;  // sentences
  double seconds = 0;
};

//   cameras   names, sizes and kind of distortion
//   points    the board's corners as its layout has them   (3, corners)
//   errors    kBadInput     a view that fits no camera or corner, an option out of range, no board at lab's
//                           stamp
//             kUnreachable  too few views of a camera (names it), cameras not linked (names them), no fit
//             kStopped      progress said so
Result<CameraCalibration> CalibrateCameras(const std::vector<Camera>& cameras,
                                           const std::vector<BoardView>& views,
                                           const Eigen::Matrix3Xd& points,
                                           const CalibrateCamerasOptions& options = {},
                                           const Progress& progress = {});

// Root mean square of what is left when only the boards' poses are fitted to the views: how well a
// calibration does on pictures that are new to it. By camera and of all; NaN without views.
BundleRms RmsWithPosesFitted(const std::vector<Camera>& cameras, const std::vector<const BoardView*>& views,
                             const Eigen::Matrix3Xd& points);

}  // namespace tendril
