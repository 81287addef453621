#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "calibrate/cameras/bundle.h"
#include "calibrate/cameras/corner_residual.h"

namespace tendril {
namespace {

using Pose6 = Eigen::Matrix<double, kPose, 6, Eigen::RowMajor>;

Pose6 TangentOf(const std::array<double, kPose>& pose) {
  Pose6 tangent;
  PoseManifold().PlusJacobian(pose.data(), tangent.data());
  return tangent;
}

Eigen::Matrix3d Cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// From a step in the manifold of camera_from_lab (half the turn about the camera's axes, then the
// translation) to the camera's position and turn in the lab: with R, t the pose, R' = exp(2 d) R and
// t' = t + s, the position -R'^T t' moves by -R^T (s + t x 2 d), and R^T turns by -R^T 2 d.
Eigen::Matrix<double, 6, 6> LabFromStep(const Camera& camera) {
  const Eigen::Matrix3d back = camera.camera_from_lab.linear().transpose();
  Eigen::Matrix<double, 6, 6> m = Eigen::Matrix<double, 6, 6>::Zero();
  m.block<3, 3>(0, 0) = -2 * back * Cross(camera.camera_from_lab.translation());
  m.block<3, 3>(0, 3) = -back;
  m.block<3, 3>(3, 0) = -2 * back;
  return m;
}

// The inverse of a symmetric matrix of parameters of very different sizes; infinite variance where the data
// say nothing.
Eigen::MatrixXd InverseOf(const Eigen::MatrixXd& information) {
  const Eigen::Index n = information.rows();
  Eigen::VectorXd scale = information.diagonal().cwiseSqrt();
  for (double& s : scale) s = s > 0 ? 1 / s : 1;
  const Eigen::MatrixXd scaled = scale.asDiagonal() * information * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
  Eigen::VectorXd inverse = eigen.eigenvalues();
  std::vector<bool> unknown(static_cast<size_t>(n), false);
  for (Eigen::Index i = 0; i < n; ++i) {
    if (inverse[i] > 1e-13 * eigen.eigenvalues()[n - 1]) {
      inverse[i] = 1 / inverse[i];
      continue;
    }
    inverse[i] = 0;
    for (Eigen::Index k = 0; k < n; ++k) {
      if (std::abs(eigen.eigenvectors()(k, i)) > 1e-4) unknown[static_cast<size_t>(k)] = true;
    }
  }
  Eigen::MatrixXd covariance = scale.asDiagonal() * eigen.eigenvectors() * inverse.asDiagonal() *
                               eigen.eigenvectors().transpose() * scale.asDiagonal();
  for (Eigen::Index k = 0; k < n; ++k) {
    if (unknown[static_cast<size_t>(k)]) covariance(k, k) = std::numeric_limits<double>::infinity();
  }
  return covariance;
}

}  // namespace

BundleCovariance CovarianceOf(const Bundle& bundle, const BundleOptions& options) {
  BundleCovariance answer;
  const bool bent = options.point_sigma > 0;
  std::vector<int> lens_size;
  Eigen::Index size = 0;
  for (size_t c = 0; c < bundle.cameras.size(); ++c) {
    lens_size.push_back(!options.fit_intrinsics  ? 0
                        : options.fit_distortion ? IntrinsicsOf(bundle.cameras[c].distortion)
                                                 : 4);
    answer.intrinsics_at.push_back(size);
    size += lens_size.back();
    answer.pose_at.push_back(c > 0 && options.fit_cameras ? size : -1);
    if (answer.pose_at.back() >= 0) size += 6;
  }
  const Eigen::Index named = size;
  std::vector<Eigen::Index> point_at(static_cast<size_t>(bundle.points.cols()), -1);
  if (bent) {
    for (const BoardPlace& place : bundle.places) {
      for (const BoardView* view : place.views) {
        for (const int id : view->corners.ids) {
          if (point_at[static_cast<size_t>(id)] >= 0) continue;
          point_at[static_cast<size_t>(id)] = size;
          size += 3;
        }
      }
    }
  }

  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(size, size);
  double psi2 = 0;
  double slope = 0;
  double residuals = 0;
  double boards = 0;
  std::vector<Pose6> camera_tangents;
  for (const Camera& camera : bundle.cameras)
    camera_tangents.push_back(TangentOf(PackPose(camera.camera_from_lab)));
  for (const BoardPlace& place : bundle.places) {
    Eigen::Index rows = 0;
    for (const BoardView* view : place.views) rows += 2 * view->corners.pixels.cols();
    if (rows == 0) continue;
    ++boards;
    const auto board_pose = PackPose(place.lab_from_board);
    const Pose6 board_tangent = TangentOf(board_pose);
    Eigen::MatrixXd shared = Eigen::MatrixXd::Zero(rows, size);
    Eigen::MatrixXd board(rows, 6);
    Eigen::Index row = 0;
    for (const BoardView* view : place.views) {
      const auto c = static_cast<size_t>(view->camera);
      const auto lens = PackIntrinsics(bundle.cameras[c]);
      const auto camera_pose = PackPose(bundle.cameras[c].camera_from_lab);
      for (size_t k = 0; k < view->corners.ids.size(); ++k, row += 2) {
        const CornerCost cost(new CornerResidual{bundle.cameras[c].distortion,
                                                 view->corners.pixels.col(static_cast<Eigen::Index>(k)),
                                                 bundle.sigma_px[c]});
        const Eigen::Vector3d point = bundle.points.col(view->corners.ids[k]);
        const double* const parameters[4] = {lens.data(), camera_pose.data(), board_pose.data(),
                                             point.data()};
        Eigen::Matrix<double, 2, kIntrinsics, Eigen::RowMajor> by_lens;
        Eigen::Matrix<double, 2, kPose, Eigen::RowMajor> by_camera;
        Eigen::Matrix<double, 2, kPose, Eigen::RowMajor> by_board;
        Eigen::Matrix<double, 2, 3, Eigen::RowMajor> by_point;
        double* jacobians[4] = {by_lens.data(), by_camera.data(), by_board.data(), by_point.data()};
        Eigen::Vector2d residual;
        if (!cost.Evaluate(parameters, residual.data(), jacobians)) {
          board.middleRows<2>(row).setZero();
          continue;
        }
        shared.block(row, answer.intrinsics_at[c], 2, lens_size[c]) = by_lens.leftCols(lens_size[c]);
        if (answer.pose_at[c] >= 0) {
          shared.block<2, 6>(row, answer.pose_at[c]) = by_camera * camera_tangents[c];
        }
        if (bent) shared.block<2, 3>(row, point_at[static_cast<size_t>(view->corners.ids[k])]) = by_point;
        board.middleRows<2>(row) = by_board * board_tangent;
        const double length = residual.norm();
        psi2 += std::pow(std::min(length, options.outlier), 2);
        slope += length <= options.outlier ? 2 : options.outlier / length;  // radially flat beyond
        residuals += 2;
      }
    }
    const Eigen::MatrixXd across = board.transpose() * shared;
    const Eigen::Matrix<double, 6, 6> own = board.transpose() * board;
    information += shared.transpose() * shared - across.transpose() * own.ldlt().solve(across);
  }
  double parameters = static_cast<double>(size) + 6 * boards;
  if (bent) {
    for (size_t k = 0; k < point_at.size(); ++k) {
      if (point_at[k] < 0) continue;
      // Given places count as three more measurements each.
      parameters -= 3;
    }
  }
  answer.degrees_of_freedom = residuals - parameters;
  slope /= residuals;
  answer.variance_factor = answer.degrees_of_freedom > 0 ? psi2 / answer.degrees_of_freedom / (slope * slope)
                                                         : std::numeric_limits<double>::infinity();
  information /= answer.variance_factor;
  for (size_t c = 0; c < bundle.lens_priors.size(); ++c) {
    for (int k = 0; k < lens_size[c]; ++k) {
      const Eigen::Index at = answer.intrinsics_at[c] + k;
      information(at, at) += std::pow(bundle.lens_priors[c].sigma[static_cast<size_t>(k)], -2);
    }
  }
  if (bent) {
    for (const Eigen::Index at : point_at) {
      if (at >= 0) information.diagonal().segment<3>(at).array() += std::pow(options.point_sigma, -2);
    }
  }
  const Eigen::MatrixXd covariance = InverseOf(information);
  answer.covariance = covariance.topLeftCorner(named, named);
  for (size_t c = 0; c < bundle.cameras.size(); ++c) {
    if (answer.pose_at[c] < 0) continue;
    const Eigen::Matrix<double, 6, 6> turn = LabFromStep(bundle.cameras[c]);
    const Eigen::Index at = answer.pose_at[c];
    const bool known = answer.covariance.diagonal().segment<6>(at).allFinite();
    if (!known) {
      answer.covariance.diagonal().segment<6>(at).setConstant(std::numeric_limits<double>::infinity());
      continue;
    }
    answer.covariance.middleRows(at, 6) = (turn * answer.covariance.middleRows(at, 6)).eval();
    answer.covariance.middleCols(at, 6) = (answer.covariance.middleCols(at, 6) * turn.transpose()).eval();
  }
  return answer;
}

}  // namespace tendril
