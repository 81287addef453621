#pragma once
// Where in its picture is a calibrated camera sure of what it projects, and where is it not?

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "capture/rig/camera_model.h"

namespace tendril {

struct ProjectionUncertainty {
  Eigen::MatrixXd sigma_px;  // (rows, columns) over the picture, at the cells' centres; NaN: no ray there
  double median_px = 0;
  double largest_px = 0;
};

// Standard deviation, in its worst direction, of the pixel that a distant point falls on. A lens that errs as
// if the camera were turned does no harm to a rig whose poses were fitted with it, so the turn that suits
// the error best, where the lens is known well, is taken off first.
//   lens_covariance  of fx, fy, cx, cy (px) and the coefficients in use
ProjectionUncertainty UncertaintyOf(const Camera& camera, const Eigen::MatrixXd& lens_covariance,
                                    int rows = 24, int columns = 32);

struct UncertaintyPanel {
  std::string title;
  int width_px = 0;
  int height_px = 0;
  ProjectionUncertainty uncertainty;
  std::vector<Eigen::Vector2d> corners_px;  // seen, drawn as dots
};

// One panel per camera with contours at round values and one scale of colours, in px (logarithmic). BGR.
cv::Mat DrawUncertainty(const std::vector<UncertaintyPanel>& panels);

}  // namespace tendril
