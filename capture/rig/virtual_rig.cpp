#include "capture/rig/virtual_rig.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "capture/rig/virtual_truth.h"

namespace tendril {
namespace {

using Vector3 = Eigen::Vector3d;

// Every corner of every facet, at pulls from flat to the largest, in the lab.
Result<std::vector<Vector3>> Reach(const TentacleDesign& design, const Gripper& gripper,
                                   double largest_pull) {
  TruthRanges exact;
  exact.position_sd = exact.crease_angle_sd = exact.stiffness_sd = exact.facet_bend_sd = 0;
  exact.largest_sag_compliance = exact.base_position_sd = exact.base_angle_sd = 0;
  exact.largest_delay = exact.rate_perturbation = exact.object_position_sd = exact.object_angle_sd = 0;
  TrueFold fold{1.0, design.stiffness_ratio, design.stiffness_exponent};
  std::mt19937_64 unused(0);
  const Result<VirtualTruth> truth =
      DrawTruth(design, gripper, fold, PullCommand{largest_pull, largest_pull}, {}, exact, unused);
  if (!truth.ok()) return truth.error();
  std::vector<Vector3> points;
  for (int step = 0; step <= 6; ++step) {
    const Result<TrueShape> shape = TrueShapeAt(truth.value(), step / 6.0);
    if (!shape.ok()) return shape.error();
    for (const TrueTentacle& tentacle : shape.value().tentacles) {
      for (const TrueStrip& strip : tentacle.strips) {
        for (Eigen::Index i = 0; i < strip.corners_in_sheet.cols(); ++i) {
          points.push_back(strip.lab_from_sheet * Vector3(strip.corners_in_sheet.col(i)));
        }
      }
    }
  }
  return points;
}

// Pose of a camera at `from` that looks at `to`, with the image's down as near the lab's as can be.
Eigen::Isometry3d CameraFromLab(const Vector3& from, const Vector3& to) {
  const Vector3 forward = (to - from).normalized();
  const Vector3 right = forward.cross(Vector3::UnitZ()).normalized();
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear().row(0) = right.transpose();
  pose.linear().row(1) = forward.cross(right).transpose();
  pose.linear().row(2) = forward.transpose();
  pose.translation() = -pose.linear() * from;
  return pose;
}

std::vector<ViewDirection> MeasuredViews(int tentacles) {
  const auto degrees = [](double azimuth, double elevation) {
    return ViewDirection{azimuth * std::numbers::pi / 180, elevation * std::numbers::pi / 180};
  };
  if (tentacles <= 2) return {degrees(10, -40), degrees(50, 40)};
  if (tentacles == 3) return {degrees(2, 40), degrees(58, -40)};
  return {degrees(25, -50), degrees(65, 50)};
}

}  // namespace

Result<Rig> VirtualRig(const TentacleDesign& design, const Gripper& gripper,
                       const VirtualRigOptions& options) {
  const std::vector<ViewDirection> views =
      options.views.empty() ? MeasuredViews(gripper.tentacles) : options.views;
  const Result<std::vector<Vector3>> reach = Reach(design, gripper, options.largest_pull);
  if (!reach.ok()) return reach.error();
  Vector3 low = reach.value().front();
  Vector3 high = low;
  for (const Vector3& p : reach.value()) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Vector3 middle(0, 0, 0.5 * (low.z() + high.z()));

  Rig rig{.name = "virtual", .cameras = {}};
  static constexpr const char* kNames[] = {"left", "right"};
  for (std::size_t i = 0; i < views.size(); ++i) {
    const ViewDirection& view = views[i];
    const double azimuth = gripper.first_azimuth + view.azimuth;
    const Vector3 toward(std::cos(view.elevation) * std::cos(azimuth),
                         std::cos(view.elevation) * std::sin(azimuth), std::sin(view.elevation));
    Camera camera;
    camera.name = i < 2 ? kNames[i] : fmt::format("view{}", i);
    camera.distortion = Distortion::kBrown;
    camera.coefficients = {-0.12, 0.05, 2e-4, -1e-4, 0};
    camera.camera_from_lab = CameraFromLab(middle + options.distance * toward, middle);

    double nearest = INFINITY;
    double farthest = 0;
    for (const Vector3& p : reach.value()) {
      const double depth = (camera.camera_from_lab * p).z();
      nearest = std::min(nearest, depth);
      farthest = std::max(farthest, depth);
    }
    if (!(nearest > 0.1 * options.distance)) {
      return Error{
          ErrorKind::kBadInput,
          fmt::format("virtual rig: a camera {} m away stands within the gripper's reach; expected a "
                      "distance above {:.2f} m",
                      options.distance, options.distance - nearest)};
    }
    camera.focal_x_px = std::round(farthest / options.pixel_pitch);
    camera.focal_y_px = camera.focal_x_px + 2;
    Eigen::Vector2d first(INFINITY, INFINITY);
    Eigen::Vector2d last(-INFINITY, -INFINITY);
    for (const Vector3& p : reach.value()) {
      const Eigen::Vector2d pixel = ProjectInCamera<double>(camera, camera.camera_from_lab * p);
      first = first.cwiseMin(pixel);
      last = last.cwiseMax(pixel);
    }
    const auto size = [&](double from, double to) {
      return 16 * static_cast<int>(std::ceil(std::min(to - from + 2 * options.margin_px, 1e6) / 16));
    };
    camera.width_px = size(first.x(), last.x());
    camera.height_px = size(first.y(), last.y());
    if (camera.width_px > 8192 || camera.height_px > 8192) {
      return Error{
          ErrorKind::kBadInput,
          fmt::format("virtual rig: at {} m per px the image is {} x {} px; expected at most 8192 each",
                      options.pixel_pitch, camera.width_px, camera.height_px)};
    }
    camera.center_x_px = std::round(0.5 * (camera.width_px - first.x() - last.x()));
    camera.center_y_px = std::round(0.5 * (camera.height_px - first.y() - last.y()));
    rig.cameras.push_back(camera);
  }
  return rig;
}

}  // namespace tendril
