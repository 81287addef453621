#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

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

// A root L of the inverse L L^T of a symmetric matrix of parameters of very different sizes, and where the
// data say nothing.
struct RootOfInverse {
  Eigen::MatrixXd root;
  std::vector<bool> unknown;

  explicit RootOfInverse(const Eigen::MatrixXd& information)
      : unknown(static_cast<size_t>(information.rows()), false) {
    const Eigen::Index n = information.rows();
    if (n == 0) return;
    Eigen::VectorXd scale = information.diagonal().cwiseSqrt();
    for (double& s : scale) s = s > 0 ? 1 / s : 1;
    const Eigen::MatrixXd scaled = scale.asDiagonal() * information * scale.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
    Eigen::VectorXd inverse = eigen.eigenvalues();
    for (Eigen::Index i = 0; i < n; ++i) {
      if (inverse[i] > 1e-13 * eigen.eigenvalues()[n - 1]) {
        inverse[i] = 1 / std::sqrt(inverse[i]);
        continue;
      }
      inverse[i] = 0;
      for (Eigen::Index k = 0; k < n; ++k) {
        if (std::abs(eigen.eigenvectors()(k, i)) > 1e-4) unknown[static_cast<size_t>(k)] = true;
      }
    }
    root = scale.asDiagonal() * eigen.eigenvectors() * inverse.asDiagonal();
  }
};

// What one moment says: sum of J^T J and of J^T psi, boards' poses eliminated.
struct Cluster {
  Eigen::MatrixXd information;
  Eigen::VectorXd score;
};

// The sandwich L [sum B_g L^T (s_g s_g^T) L B_g] L^T with B_g = (1 - S_g)^(-1/2), S_g = L^T (slope J_g^T J_g)
// L, and Satterthwaite's degrees of freedom of each row of `wanted` (parameters by all), were corners
// independent.
void Sandwich(const std::vector<Cluster>& clusters, double slope, const Eigen::VectorXd& prior,
              const Eigen::MatrixXd& wanted, BundleCovariance& answer) {
  constexpr Eigen::Index kMostCorrected = 300;
  constexpr double kLeast = 0.02;  // of 1 - S_g: a moment that alone decides something
  const Eigen::Index n = prior.size();
  const auto count = static_cast<double>(clusters.size());
  const bool corrected = n <= kMostCorrected;
  Eigen::MatrixXd bread = prior.asDiagonal();
  for (const Cluster& g : clusters) bread += slope * g.information;
  const RootOfInverse inverse(bread);
  const Eigen::MatrixXd& root = inverse.root;
  const Eigen::MatrixXd to_wanted = root.transpose() * wanted.transpose();
  Eigen::MatrixXd meat = root.transpose() * prior.asDiagonal() * root;
  const Eigen::Index parameters = wanted.rows();
  std::vector<Eigen::MatrixXd> parts;  // S_g B_g L^T c, by parameter
  Eigen::MatrixXd own(parameters, static_cast<Eigen::Index>(clusters.size()));
  for (size_t g = 0; g < clusters.size(); ++g) {
    Eigen::VectorXd score = root.transpose() * clusters[g].score;
    if (corrected) {
      const Eigen::MatrixXd share = slope * root.transpose() * clusters[g].information * root;
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(share);
      const Eigen::VectorXd stretch = (1 - eigen.eigenvalues().array()).max(kLeast).sqrt().inverse().matrix();
      const Eigen::MatrixXd bias =
          eigen.eigenvectors() * stretch.asDiagonal() * eigen.eigenvectors().transpose();
      score = (bias * score).eval();
      const Eigen::MatrixXd at = bias * to_wanted;
      parts.emplace_back(share * at);
      own.col(static_cast<Eigen::Index>(g)) = at.cwiseProduct(parts.back()).colwise().sum().transpose();
    } else {
      score *= std::sqrt(count / std::max(1.0, count - 1));
    }
    meat += score * score.transpose();
  }
  answer.covariance = to_wanted.transpose() * meat * to_wanted;
  answer.degrees_of_freedom = Eigen::VectorXd::Constant(parameters, std::max(1.0, count - 1));
  if (corrected) {
    for (Eigen::Index k = 0; k < parameters; ++k) {
      Eigen::MatrixXd part(n, static_cast<Eigen::Index>(parts.size()));
      for (size_t g = 0; g < parts.size(); ++g) part.col(static_cast<Eigen::Index>(g)) = parts[g].col(k);
      Eigen::MatrixXd p = -part.transpose() * part;
      p.diagonal() += own.row(k).transpose();
      const double square = p.squaredNorm();
      if (square > 0) answer.degrees_of_freedom[k] = std::max(1.0, p.trace() * p.trace() / square);
    }
  }
  for (Eigen::Index k = 0; k < parameters; ++k) {
    for (Eigen::Index i = 0; i < n; ++i) {
      if (wanted(k, i) != 0 && inverse.unknown[static_cast<size_t>(i)])
        answer.covariance(k, k) = std::numeric_limits<double>::infinity();
    }
  }
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
  std::map<std::int64_t, Cluster> clusters;  // by stamp
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
    Eigen::VectorXd psi = Eigen::VectorXd::Zero(rows);
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
        psi.segment<2>(row) = residual * std::min(1.0, options.outlier / std::max(length, 1e-300));
        psi2 += std::pow(std::min(length, options.outlier), 2);
        slope += length <= options.outlier ? 2 : options.outlier / length;  // radially flat beyond
        residuals += 2;
      }
    }
    const Eigen::MatrixXd across = board.transpose() * shared;
    const Eigen::Matrix<double, 6, 6> own = board.transpose() * board;
    const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> solved(own);
    const Eigen::MatrixXd left = shared.transpose() * shared - across.transpose() * solved.solve(across);
    information += left;
    Cluster& cluster = clusters[place.stamp];
    if (cluster.score.size() == 0) cluster = {Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(size)};
    cluster.information += left;
    cluster.score += shared.transpose() * psi - across.transpose() * solved.solve(board.transpose() * psi);
  }
  double parameters = static_cast<double>(size) + 6 * boards;
  if (bent) {
    for (size_t k = 0; k < point_at.size(); ++k) {
      if (point_at[k] < 0) continue;
      // Given places count as three more measurements each.
      parameters -= 3;
    }
  }
  const double freedom = residuals - parameters;
  answer.independent_degrees_of_freedom = freedom;
  slope /= residuals;
  answer.variance_factor =
      freedom > 0 ? psi2 / freedom / (slope * slope) : std::numeric_limits<double>::infinity();
  information /= answer.variance_factor;
  Eigen::VectorXd prior = Eigen::VectorXd::Zero(size);
  for (size_t c = 0; c < bundle.lens_priors.size(); ++c) {
    for (int k = 0; k < lens_size[c]; ++k)
      prior[answer.intrinsics_at[c] + k] = std::pow(bundle.lens_priors[c].sigma[static_cast<size_t>(k)], -2);
  }
  if (bent) {
    for (const Eigen::Index at : point_at) {
      if (at >= 0) prior.segment<3>(at).setConstant(std::pow(options.point_sigma, -2));
    }
  }
  information.diagonal() += prior;
  // Poses as positions and turns in the lab.
  Eigen::MatrixXd wanted = Eigen::MatrixXd::Zero(named, size);
  wanted.leftCols(named).setIdentity();
  for (size_t c = 0; c < bundle.cameras.size(); ++c) {
    if (answer.pose_at[c] >= 0)
      wanted.block<6, 6>(answer.pose_at[c], answer.pose_at[c]) = LabFromStep(bundle.cameras[c]);
  }
  const RootOfInverse inverse(information);
  const Eigen::MatrixXd root = wanted * inverse.root;
  answer.independent_covariance = root * root.transpose();
  for (Eigen::Index k = 0; k < named; ++k) {
    for (Eigen::Index i = 0; i < size; ++i) {
      if (wanted(k, i) != 0 && inverse.unknown[static_cast<size_t>(i)])
        answer.independent_covariance(k, k) = std::numeric_limits<double>::infinity();
    }
  }
  std::vector<Cluster> moments;
  for (auto& [stamp, cluster] : clusters) moments.push_back(std::move(cluster));
  Sandwich(moments, slope, prior, wanted, answer);
  return answer;
}

}  // namespace tendril
