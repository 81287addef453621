#include "capture/track/triangulate.h"

#include <ceres/jet.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "model/check.h"

namespace tendril {
namespace {

// The point nearest to all rays, in the least-squares sense; none if they are parallel.
std::optional<Eigen::Vector3d> NearestToRays(std::span<const Camera> cameras,
                                             std::span<const Sighting> sightings) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Sighting& seen : sightings) {
    const Camera& camera = cameras[static_cast<size_t>(seen.camera)];
    const auto ray = RayOfPixel(camera, seen.pixel);
    if (!ray) return std::nullopt;
    const Eigen::Isometry3d lab_from_camera = camera.camera_from_lab.inverse();
    const Eigen::Vector3d along = lab_from_camera.linear() * *ray;
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - along * along.transpose();
    sum += across;
    right += across * lab_from_camera.translation();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(sum);
  if (!(eigen.eigenvalues()[0] > 1e-12)) return std::nullopt;
  return sum.ldlt().solve(right);
}

struct Reprojection {
  std::vector<Eigen::Vector2d> residuals;
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  double cost = 0;
};

std::optional<Reprojection> Reproject(std::span<const Camera> cameras, std::span<const Sighting> sightings,
                                      const Eigen::Vector3d& in_lab) {
  using Jet = ceres::Jet<double, 3>;
  Reprojection all;
  for (const Sighting& seen : sightings) {
    const Camera& camera = cameras[static_cast<size_t>(seen.camera)];
    const Eigen::Vector3d in_camera = camera.camera_from_lab * in_lab;
    if (!(in_camera.z() > 0)) return std::nullopt;
    Eigen::Vector3<Jet> p;
    for (int i = 0; i < 3; ++i) p[i] = Jet(in_camera[i], i);
    const Eigen::Vector2<Jet> pixel = ProjectInCamera<Jet>(camera, p);
    Eigen::Matrix<double, 2, 3> jacobian;
    jacobian.row(0) = pixel.x().v.transpose();
    jacobian.row(1) = pixel.y().v.transpose();
    jacobian = (jacobian * camera.camera_from_lab.linear()).eval();
    const Eigen::Vector2d residual(pixel.x().a - seen.pixel.x(), pixel.y().a - seen.pixel.y());
    all.residuals.push_back(residual);
    all.hessian += jacobian.transpose() * jacobian;
    all.gradient += jacobian.transpose() * residual;
    all.cost += residual.squaredNorm();
  }
  if (!std::isfinite(all.cost)) return std::nullopt;
  return all;
}

}  // namespace

std::optional<TriangulatedPoint> Triangulate(std::span<const Camera> cameras,
                                             std::span<const Sighting> sightings, double sigma_px) {
  if (sightings.size() < 2) return std::nullopt;
  for (const Sighting& seen : sightings) {
    TENDRIL_CHECK(seen.camera >= 0 && static_cast<size_t>(seen.camera) < cameras.size());
  }
  const auto start = NearestToRays(cameras, sightings);
  if (!start) return std::nullopt;
  Eigen::Vector3d at = *start;
  auto now = Reproject(cameras, sightings, at);
  if (!now) return std::nullopt;
  double damping = 0;
  for (int i = 0; i < 30; ++i) {
    Eigen::Matrix3d damped = now->hessian;
    damped.diagonal() *= 1 + damping;
    const Eigen::Vector3d step = damped.ldlt().solve(-now->gradient);
    if (!step.allFinite()) return std::nullopt;
    auto next = Reproject(cameras, sightings, at + step);
    if (next && next->cost <= now->cost) {
      const double gain = now->cost - next->cost;
      at += step;
      now = std::move(next);
      damping *= 0.1;
      if (gain <= 1e-14 * (now->cost + 1e-12)) break;
    } else {
      damping = std::max(1e-6, 10 * damping);
      if (damping > 1e8) break;
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(now->hessian);
  if (!(eigen.eigenvalues()[0] > 1e-14 * eigen.eigenvalues()[2])) return std::nullopt;
  TriangulatedPoint point;
  point.in_lab = at;
  point.covariance = sigma_px * sigma_px * now->hessian.inverse();
  point.rms_px = std::sqrt(now->cost / static_cast<double>(sightings.size()));
  point.residuals = std::move(now->residuals);
  return point;
}

}  // namespace tendril
