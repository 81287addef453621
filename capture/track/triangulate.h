#pragma once
// Where a point is that two cameras or more have seen.

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "capture/rig/camera_model.h"

namespace tendril {

struct Sighting {
  int camera = 0;  // index into the cameras
  Eigen::Vector2d pixel;
};

struct TriangulatedPoint {
  Eigen::Vector3d in_lab;                  // m
  Eigen::Matrix3d covariance;              // for pixels that err by sigma_px in x and in y, m^2
  std::vector<Eigen::Vector2d> residuals;  // projected - seen, px, one per sighting
  double rms_px = 0;                       // of the residuals' lengths
};

// The point with the least squared reprojection error, from the rays' nearest point on.
//   sigma_px  standard deviation of a pixel coordinate
//   returns   none with fewer than two sightings, a pixel without a ray, rays that are parallel to rounding,
//   or
//             a point that comes to lie behind a camera
std::optional<TriangulatedPoint> Triangulate(std::span<const Camera> cameras,
                                             std::span<const Sighting> sightings, double sigma_px = 1);

}  // namespace tendril
