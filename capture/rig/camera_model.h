#pragma once
// How a camera maps a point to a pixel: pinhole, then the lens's distortion.
//
// Camera frame: z forward, x right, y down (OpenCV's). Pixel (0, 0) is the centre of the top left pixel.

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <optional>
#include <string>

namespace tendril {

enum class Distortion {
  kNone,
  kBrown,        // k1, k2, p1, p2, k3: OpenCV's order
  kEquidistant,  // k1 .. k4 of the fisheye model r = theta (1 + k1 theta^2 + ...)
};

struct Camera {
  std::string name;
  int width_px = 0;
  int height_px = 0;
  double focal_x_px = 0;
  double focal_y_px = 0;
  double center_x_px = 0;
  double center_y_px = 0;
  Distortion distortion = Distortion::kNone;
  std::array<double, 5> coefficients{};  // dimensionless; unused ones are 0
  Eigen::Isometry3d camera_from_lab = Eigen::Isometry3d::Identity();
};

// Distorts normalised coordinates (x/z, y/z) by five coefficients. A template, so that Ceres can
// differentiate it, by the coefficients (K) too.
template <class T, class K>
Eigen::Vector2<T> DistortBy(Distortion distortion, const K* k, const Eigen::Vector2<T>& undistorted) {
  const T& x = undistorted.x();
  const T& y = undistorted.y();
  switch (distortion) {
    case Distortion::kNone:
      return undistorted;
    case Distortion::kBrown: {
      const T r2 = x * x + y * y;
      const T radial = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
      return {x * radial + 2.0 * k[2] * x * y + k[3] * (r2 + 2.0 * x * x),
              y * radial + k[2] * (r2 + 2.0 * y * y) + 2.0 * k[3] * x * y};
    }
    case Distortion::kEquidistant: {
      using std::atan;
      using std::sqrt;
      const T r2 = x * x + y * y;
      if (r2 < T(1e-16)) return undistorted;
      const T r = sqrt(r2);
      const T theta = atan(r);
      const T t2 = theta * theta;
      const T bent = theta * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
      return undistorted * (bent / r);
    }
  }
  return undistorted;
}

template <class T>
Eigen::Vector2<T> Distort(const Camera& camera, const Eigen::Vector2<T>& undistorted) {
  return DistortBy<T, double>(camera.distortion, camera.coefficients.data(), undistorted);
}

// Pixel of a point in the camera's frame; the caller makes sure that z > 0.
template <class T>
Eigen::Vector2<T> ProjectInCamera(const Camera& camera, const Eigen::Vector3<T>& in_camera) {
  const Eigen::Vector2<T> normalised(in_camera.x() / in_camera.z(), in_camera.y() / in_camera.z());
  const Eigen::Vector2<T> distorted = Distort<T>(camera, normalised);
  return {camera.focal_x_px * distorted.x() + camera.center_x_px,
          camera.focal_y_px * distorted.y() + camera.center_y_px};
}

// Pixel of a lab point; none behind the camera.
std::optional<Eigen::Vector2d> Project(const Camera& camera, const Eigen::Vector3d& in_lab);

// Unit direction in the camera's frame that a pixel sees: the inverse of ProjectInCamera, to 1e-12 in
// normalised coordinates. None where the distortion has no inverse there.
std::optional<Eigen::Vector3d> RayOfPixel(const Camera& camera, const Eigen::Vector2d& pixel);

}  // namespace tendril
