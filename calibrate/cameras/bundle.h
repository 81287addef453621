#pragma once
// Which cameras, boards' poses and board explain best where corners were seen? One least squares over
// everything (bundle adjustment), with a robust loss per corner, and how sure its answer is.
//
// Lab frame: whatever the cameras' poses say; camera 0 keeps its pose. Lengths in m, as the board's.

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "capture/rig/camera_model.h"
#include "capture/track/board_detect.h"
#include "model/result.h"

namespace tendril {

// A board in one picture.
struct BoardView {
  std::int64_t stamp = 0;  // pictures of equal stamp were taken at once; any unit
  int target = 0;          // boards of one layout that are in the picture at once, 0, 1, ...
  int camera = 0;
  BoardCorners corners;
};

// A board at one moment.
struct BoardPlace {
  std::int64_t stamp = 0;
  int target = 0;
  Eigen::Isometry3d lab_from_board = Eigen::Isometry3d::Identity();
  std::vector<const BoardView*> views;  // not owned
};

// What a lens can be at all, as normal distributions that are wide beside what any fair set of pictures says
// (fx, fy, cx, cy in px, five coefficients): it keeps a fit to poor ones from running away.
struct LensPrior {
  std::array<double, 9> mean{};
  std::array<double, 9> sigma{};
};

struct Bundle {
  std::vector<Camera> cameras;
  std::vector<double> sigma_px;  // of a corner's coordinate, by camera: its weight
  Eigen::Matrix3Xd points;       // the board's corners, m   (3, corners)
  Eigen::Matrix3Xd layout =
      {};  // where they should be, m   (3, corners); only for BundleOptions::point_sigma
  std::vector<BoardPlace> places = {};
  std::vector<LensPrior> lens_priors = {};  // by camera; empty: none
};

struct BundleOptions {
  bool fit_intrinsics = true;
  bool fit_distortion = true;  // of the intrinsics
  bool fit_cameras = true;     // poses but camera 0's
  // The corners' places on the board too, about the layout's to within this standard deviation, m; 0: as they
  // are.
  double point_sigma = 0;
  double outlier = 3;  // residuals beyond so many sigma_px count less and less (Huber)
  int most_iterations = 200;
};

struct BundleFit {
  double cost = 0;
  int iterations = 0;
  bool converged = false;
  std::string stopped_because;
};

// Improves the bundle in place.
//   errors  kBadInput     sizes that do not fit, a corner that the board does not have
//           kUnreachable  Ceres found no usable answer
Result<BundleFit> AdjustBundle(Bundle& bundle, const BundleOptions& options);

// How many intrinsics a lens has: focal lengths, centre, coefficients.
int IntrinsicsOf(Distortion distortion);

// How the fit's shared parameters err together. In order, for each camera: fx, fy, cx, cy (px), coefficients
// (Brown's k1, k2, p1, p2, k3); for each but camera 0: its position (m) and a small turn about the lab's axes
// (rad).
struct BundleCovariance {
  // Corners of one moment may err together (a board that bends, a lens that the model does not meet): from
  // the scatter of what moments say. Infinite on the diagonal: the data do not determine it.
  Eigen::MatrixXd covariance;
  Eigen::VectorXd degrees_of_freedom;      // of each parameter's standard error
  Eigen::MatrixXd independent_covariance;  // if all corners erred on their own
  double independent_degrees_of_freedom = 0;
  double variance_factor = 0;               // of the residuals / sigma_px: 1 where those are right
  std::vector<Eigen::Index> intrinsics_at;  // by camera
  std::vector<Eigen::Index> pose_at;        // by camera; -1: fixed
};

// From the Jacobian at the fit, boards' poses eliminated by Schur complement. Moments (stamps) are the
// clusters of a sandwich with the correction for few of them, CR2, which is exact for independent corners;
// with more than 300 parameters (corrected boards of many corners) the simpler CR1, as moments are many
// there.
//   source  Bell and McCaffrey, "Bias reduction in standard errors for linear regression with multi-stage
//   samples",
//           2002; Pustejovsky and Tipton, "Small-sample methods for cluster-robust variance estimation",
//           2018. independent: Huber, "Robust Statistics", 1981, 7.6: cov = [sum psi^2 / (n - p)] / [mean
//           psi']^2 (J^T J)^-1
BundleCovariance CovarianceOf(const Bundle& bundle, const BundleOptions& options);

// Root mean square distance (px) of seen to projected corners, by camera and of all; NaN where none were
// seen.
struct BundleRms {
  std::vector<double> by_camera_px;
  double all_px = 0;
  int corners = 0;
};
BundleRms RmsOf(const Bundle& bundle);

// Sets sigma_px to what the residuals of each camera show (from their median, so outliers do not matter), at
// least 0.01 px.
void MeasureSigma(Bundle& bundle);

}  // namespace tendril
