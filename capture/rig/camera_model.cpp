#include "capture/rig/camera_model.h"

#include <algorithm>
#include <numbers>

namespace tendril {
namespace {

// How far Brown's model is from the identity at radius r, as a bound on the change of its Jacobian. The
// Jacobian is symmetric (the map is a gradient), so below 1 it is positive definite in the whole disc: no
// fold in there.
double BrownBend(const Camera& camera, double r2) {
  const auto& k = camera.coefficients;
  return r2 * (3 * std::abs(k[0]) + r2 * (5 * std::abs(k[1]) + r2 * 7 * std::abs(k[4]))) +
         8 * (std::abs(k[2]) + std::abs(k[3])) * std::sqrt(r2);
}

Eigen::Matrix2d BrownJacobian(const Camera& camera, const Eigen::Vector2d& at) {
  const auto& k = camera.coefficients;
  const double x = at.x();
  const double y = at.y();
  const double r2 = at.squaredNorm();
  const double radial = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  const double slope = 2 * (k[0] + r2 * (2 * k[1] + r2 * 3 * k[4]));  // d radial / d r^2, twice
  Eigen::Matrix2d j;
  j(0, 0) = radial + slope * x * x + 2 * k[2] * y + 6 * k[3] * x;
  j(0, 1) = slope * x * y + 2 * k[2] * x + 2 * k[3] * y;
  j(1, 0) = j(0, 1);
  j(1, 1) = radial + slope * y * y + 6 * k[2] * y + 2 * k[3] * x;
  return j;
}

bool PositiveDefinite(const Eigen::Matrix2d& symmetric) {
  return symmetric(0, 0) > 0 && symmetric.determinant() > 0;
}

// Whether the distortion keeps neighbouring directions apart all the way from the optical axis to here.
bool BrownIsOneToOne(const Camera& camera, const Eigen::Vector2d& at) {
  if (BrownBend(camera, at.squaredNorm()) < 1) return true;
  constexpr int kSteps = 64;
  for (int i = 1; i <= kSteps; ++i) {
    if (!PositiveDefinite(BrownJacobian(camera, at * (static_cast<double>(i) / kSteps)))) return false;
  }
  return true;
}

std::optional<Eigen::Vector2d> Newton(const Camera& camera, const Eigen::Vector2d& wanted,
                                      Eigen::Vector2d at) {
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector2d residual = Distort<double>(camera, at) - wanted;
    const Eigen::Matrix2d jacobian = BrownJacobian(camera, at);
    if (!PositiveDefinite(jacobian)) return std::nullopt;
    const Eigen::Vector2d step = jacobian.inverse() * residual;
    at -= step;
    if (!at.allFinite()) return std::nullopt;
    if (step.norm() <= 1e-13 * (1 + at.norm())) return at;
  }
  return std::nullopt;
}

std::optional<Eigen::Vector2d> UndistortBrown(const Camera& camera, const Eigen::Vector2d& wanted) {
  if (auto direct = Newton(camera, wanted, wanted); direct && BrownIsOneToOne(camera, *direct)) {
    return direct;
  }
  // Strong distortion: follow the solution outward from the axis, so that it stays on the branch that the
  // lens shows.
  constexpr int kSteps = 64;
  Eigen::Vector2d at = Eigen::Vector2d::Zero();
  for (int i = 1; i <= kSteps; ++i) {
    const auto next = Newton(camera, wanted * (static_cast<double>(i) / kSteps), at);
    if (!next || !BrownIsOneToOne(camera, *next)) return std::nullopt;
    at = *next;
  }
  return at;
}

double BentAngle(const Camera& camera, double theta) {
  const auto& k = camera.coefficients;
  const double t2 = theta * theta;
  return theta * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
}

double BentAngleSlope(const Camera& camera, double theta) {
  const auto& k = camera.coefficients;
  const double t2 = theta * theta;
  return 1 + t2 * (3 * k[0] + t2 * (5 * k[1] + t2 * (7 * k[2] + t2 * 9 * k[3])));
}

constexpr int kAngleSteps = 64;
constexpr double kLargestAngle = std::numbers::pi / 2;

bool EquidistantIsOneToOne(const Camera& camera, double theta) {
  for (int i = 1; i <= kAngleSteps; ++i) {
    if (!(BentAngleSlope(camera, theta * i / kAngleSteps) > 0)) return false;
  }
  return true;
}

// The angle to the axis, below 90 degrees, that the lens bends to `wanted`.
std::optional<double> UnbendAngle(const Camera& camera, double wanted) {
  double low = 0;
  double high = 0;
  for (int i = 1; BentAngle(camera, high) < wanted; ++i) {
    if (i > kAngleSteps) return std::nullopt;
    low = high;
    high = kLargestAngle * i / kAngleSteps;
    if (BentAngleSlope(camera, high) > 0) continue;
    // The lens turns back within this step: the answer lies before the turn, or nowhere.
    double turn_low = low;
    for (int j = 0; j < 60; ++j) {
      const double middle = 0.5 * (turn_low + high);
      (BentAngleSlope(camera, middle) > 0 ? turn_low : high) = middle;
    }
    if (BentAngle(camera, turn_low) < wanted) return std::nullopt;
    high = turn_low;
  }
  double theta = 0.5 * (low + high);
  for (int i = 0; i < 100; ++i) {
    const double residual = BentAngle(camera, theta) - wanted;
    (residual > 0 ? high : low) = theta;
    double next = theta - residual / BentAngleSlope(camera, theta);
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    const double step = std::abs(next - theta);
    theta = next;
    if (step <= 1e-15) break;
  }
  if (!(theta < kLargestAngle) || !(BentAngleSlope(camera, theta) > 0)) return std::nullopt;
  return theta;
}

}  // namespace

std::optional<Eigen::Vector2d> Project(const Camera& camera, const Eigen::Vector3d& in_lab) {
  const Eigen::Vector3d in_camera = camera.camera_from_lab * in_lab;
  if (!(in_camera.z() > 0)) return std::nullopt;
  const Eigen::Vector2d normalised = in_camera.hnormalized();
  if (!normalised.allFinite()) return std::nullopt;
  if (camera.distortion == Distortion::kBrown && !BrownIsOneToOne(camera, normalised)) return std::nullopt;
  if (camera.distortion == Distortion::kEquidistant &&
      !EquidistantIsOneToOne(camera, std::atan(normalised.norm()))) {
    return std::nullopt;
  }
  return ProjectInCamera<double>(camera, in_camera);
}

std::optional<Eigen::Vector3d> RayOfPixel(const Camera& camera, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d bent((pixel.x() - camera.center_x_px) / camera.focal_x_px,
                             (pixel.y() - camera.center_y_px) / camera.focal_y_px);
  if (!bent.allFinite()) return std::nullopt;
  switch (camera.distortion) {
    case Distortion::kNone:
      break;
    case Distortion::kBrown: {
      const auto straight = UndistortBrown(camera, bent);
      if (!straight) return std::nullopt;
      return straight->homogeneous().normalized();
    }
    case Distortion::kEquidistant: {
      const double r = bent.norm();
      if (r < 1e-8) break;
      const auto theta = UnbendAngle(camera, r);
      if (!theta) return std::nullopt;
      const Eigen::Vector2d across = bent * (std::sin(*theta) / r);
      return Eigen::Vector3d(across.x(), across.y(), std::cos(*theta));
    }
  }
  return bent.homogeneous().normalized();
}

}  // namespace tendril
