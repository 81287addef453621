#pragma once
// One board corner in one picture, as a Ceres residual: (projected - seen) / sigma, two numbers.

#include <ceres/ceres.h>

#include <Eigen/Geometry>
#include <array>

#include "capture/rig/camera_model.h"

namespace tendril {

constexpr int kIntrinsics = 9;  // fx, fy, cx, cy (px), five coefficients
constexpr int kPose = 7;        // quaternion x, y, z, w, then a translation (m)

using PoseManifold = ceres::ProductManifold<ceres::EigenQuaternionManifold, ceres::EuclideanManifold<3>>;

struct CornerResidual {
  Distortion distortion;
  Eigen::Vector2d seen_px;
  double sigma_px;

  template <class T>
  bool operator()(const T* intrinsics, const T* camera_pose, const T* board_pose, const T* point,
                  T* residual) const {
    const Eigen::Map<const Eigen::Quaternion<T>> camera_from_lab(camera_pose);
    const Eigen::Map<const Eigen::Vector3<T>> lab_in_camera(camera_pose + 4);
    const Eigen::Map<const Eigen::Quaternion<T>> lab_from_board(board_pose);
    const Eigen::Map<const Eigen::Vector3<T>> board_in_lab(board_pose + 4);
    const Eigen::Map<const Eigen::Vector3<T>> on_board(point);
    const Eigen::Vector3<T> in_lab = lab_from_board * on_board + board_in_lab;
    const Eigen::Vector3<T> p = camera_from_lab * in_lab + lab_in_camera;
    if (!(p.z() > T(0))) return false;  // behind the camera: Ceres then rejects the step
    const Eigen::Vector2<T> bent =
        DistortBy<T, T>(distortion, intrinsics + 4, Eigen::Vector2<T>(p.x() / p.z(), p.y() / p.z()));
    residual[0] = (intrinsics[0] * bent.x() + intrinsics[2] - seen_px.x()) / sigma_px;
    residual[1] = (intrinsics[1] * bent.y() + intrinsics[3] - seen_px.y()) / sigma_px;
    return true;
  }
};

using CornerCost = ceres::AutoDiffCostFunction<CornerResidual, 2, kIntrinsics, kPose, kPose, 3>;

inline std::array<double, kIntrinsics> PackIntrinsics(const Camera& c) {
  const auto& k = c.coefficients;
  return {c.focal_x_px, c.focal_y_px, c.center_x_px, c.center_y_px, k[0], k[1], k[2], k[3], k[4]};
}

inline std::array<double, kPose> PackPose(const Eigen::Isometry3d& pose) {
  std::array<double, kPose> packed{};
  Eigen::Map<Eigen::Quaterniond>(packed.data()) = Eigen::Quaterniond(pose.linear());
  Eigen::Map<Eigen::Vector3d>(packed.data() + 4) = pose.translation();
  return packed;
}

inline Eigen::Isometry3d UnpackPose(const std::array<double, kPose>& packed) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::Map<const Eigen::Quaterniond>(packed.data()).normalized().toRotationMatrix();
  pose.translation() = Eigen::Map<const Eigen::Vector3d>(packed.data() + 4);
  return pose;
}

}  // namespace tendril
