#include "calibrate/cameras/bundle.h"

#include <ceres/ceres.h>
#include <ceres/normal_prior.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "calibrate/cameras/corner_residual.h"
#include "model/median.h"

namespace tendril {
namespace {

Status Check(const Bundle& bundle) {
  const auto bad = [](const std::string& message) { return Error{ErrorKind::kBadInput, message}; };
  if (bundle.cameras.empty() || bundle.places.empty()) return bad("no camera or no board to adjust");
  if (bundle.sigma_px.size() != bundle.cameras.size()) {
    return bad(fmt::format("{} sigmas for {} cameras", bundle.sigma_px.size(), bundle.cameras.size()));
  }
  if (!bundle.lens_priors.empty() && bundle.lens_priors.size() != bundle.cameras.size()) {
    return bad(
        fmt::format("{} lenses' priors for {} cameras", bundle.lens_priors.size(), bundle.cameras.size()));
  }
  for (const double sigma : bundle.sigma_px) {
    if (!(sigma > 0)) return bad(fmt::format("corners' sigma is {} px; expected more than 0", sigma));
  }
  for (const BoardPlace& place : bundle.places) {
    for (const BoardView* view : place.views) {
      if (view->camera < 0 || static_cast<size_t>(view->camera) >= bundle.cameras.size()) {
        return bad(
            fmt::format("a view by camera {}; expected 0 to {}", view->camera, bundle.cameras.size() - 1));
      }
      if (view->corners.pixels.cols() != static_cast<Eigen::Index>(view->corners.ids.size()) ||
          !view->corners.pixels.allFinite()) {
        return bad(fmt::format("a view by camera {} whose corners have no place", view->camera));
      }
      for (const int id : view->corners.ids) {
        if (id >= 0 && id < bundle.points.cols()) continue;
        return bad(fmt::format("corner {}; expected 0 to {}", id, bundle.points.cols() - 1));
      }
    }
  }
  return Ok{};
}

}  // namespace

int IntrinsicsOf(Distortion distortion) {
  return distortion == Distortion::kBrown ? 9 : distortion == Distortion::kEquidistant ? 8 : 4;
}

Result<BundleFit> AdjustBundle(Bundle& bundle, const BundleOptions& options) {
  if (auto s = Check(bundle); !s.ok()) return s.error();
  if (options.point_sigma > 0 && bundle.layout.cols() != bundle.points.cols()) {
    return Error{ErrorKind::kBadInput, "a board to be corrected has no layout"};
  }
  std::vector<std::array<double, kIntrinsics>> intrinsics;
  std::vector<std::array<double, kPose>> camera_poses;
  for (const Camera& camera : bundle.cameras) {
    intrinsics.push_back(PackIntrinsics(camera));
    camera_poses.push_back(PackPose(camera.camera_from_lab));
  }
  std::vector<std::array<double, kPose>> board_poses;
  for (const BoardPlace& place : bundle.places) board_poses.push_back(PackPose(place.lab_from_board));
  Eigen::Matrix3Xd points = bundle.points;

  // Shared by all residuals, so not the problem's to delete.
  ceres::HuberLoss robust(options.outlier);
  ceres::Problem::Options shared;
  shared.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(shared);
  auto* const ordering = new ceres::ParameterBlockOrdering;
  for (size_t i = 0; i < bundle.places.size(); ++i) {
    for (const BoardView* view : bundle.places[i].views) {
      const auto c = static_cast<size_t>(view->camera);
      for (size_t k = 0; k < view->corners.ids.size(); ++k) {
        auto* const cost = new CornerCost(
            new CornerResidual{bundle.cameras[c].distortion,
                               view->corners.pixels.col(static_cast<Eigen::Index>(k)), bundle.sigma_px[c]});
        problem.AddResidualBlock(cost, &robust, intrinsics[c].data(), camera_poses[c].data(),
                                 board_poses[i].data(), points.col(view->corners.ids[k]).data());
      }
    }
    if (!problem.HasParameterBlock(board_poses[i].data())) continue;
    problem.SetManifold(board_poses[i].data(), new PoseManifold);
    ordering->AddElementToGroup(board_poses[i].data(), 0);
  }
  bool any_shared = false;
  for (size_t c = 0; c < bundle.cameras.size(); ++c) {
    double* const lens = intrinsics[c].data();
    double* const pose = camera_poses[c].data();
    if (!problem.HasParameterBlock(lens)) continue;
    ordering->AddElementToGroup(lens, 1);
    ordering->AddElementToGroup(pose, 1);
    const int used = options.fit_distortion ? IntrinsicsOf(bundle.cameras[c].distortion) : 4;
    if (!options.fit_intrinsics) {
      problem.SetParameterBlockConstant(lens);
    } else if (used < kIntrinsics) {
      std::vector<int> held;
      for (int k = used; k < kIntrinsics; ++k) held.push_back(k);
      problem.SetManifold(lens, new ceres::SubsetManifold(kIntrinsics, held));
    }
    if (options.fit_intrinsics && !bundle.lens_priors.empty()) {
      const LensPrior& prior = bundle.lens_priors[c];
      const Eigen::Map<const Eigen::VectorXd> mean(prior.mean.data(), kIntrinsics);
      const Eigen::Map<const Eigen::VectorXd> sigma(prior.sigma.data(), kIntrinsics);
      const Eigen::MatrixXd weight = sigma.cwiseInverse().asDiagonal();
      problem.AddResidualBlock(new ceres::NormalPrior(weight, mean), nullptr, lens);
    }
    problem.SetManifold(pose, new PoseManifold);
    if (c == 0 || !options.fit_cameras) problem.SetParameterBlockConstant(pose);
    any_shared = any_shared || options.fit_intrinsics || (options.fit_cameras && c > 0);
  }
  for (Eigen::Index k = 0; k < points.cols(); ++k) {
    double* const point = points.col(k).data();
    if (!problem.HasParameterBlock(point)) continue;
    ordering->AddElementToGroup(point, 1);
    if (!(options.point_sigma > 0)) {
      problem.SetParameterBlockConstant(point);
      continue;
    }
    any_shared = true;
    const Eigen::Matrix3d weight = Eigen::Matrix3d::Identity() / options.point_sigma;
    problem.AddResidualBlock(new ceres::NormalPrior(weight, bundle.layout.col(k)), nullptr, point);
  }

  ceres::Solver::Options solver;
  // Without anything shared each board is a problem of its own: no Schur complement to take.
  solver.linear_solver_type = any_shared ? ceres::DENSE_SCHUR : ceres::SPARSE_NORMAL_CHOLESKY;
  if (any_shared) {
    solver.linear_solver_ordering.reset(ordering);
  } else {
    delete ordering;
  }
  solver.max_num_iterations = options.most_iterations;
  solver.function_tolerance = 1e-12;
  solver.parameter_tolerance = 1e-11;
  solver.gradient_tolerance = 1e-12;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  if (!summary.IsSolutionUsable()) {
    return Error{ErrorKind::kUnreachable, "the cameras' fit failed: " + summary.message};
  }
  for (size_t c = 0; c < bundle.cameras.size(); ++c) {
    Camera& camera = bundle.cameras[c];
    camera.focal_x_px = intrinsics[c][0];
    camera.focal_y_px = intrinsics[c][1];
    camera.center_x_px = intrinsics[c][2];
    camera.center_y_px = intrinsics[c][3];
    std::copy(intrinsics[c].begin() + 4, intrinsics[c].end(), camera.coefficients.begin());
    camera.camera_from_lab = UnpackPose(camera_poses[c]);
  }
  for (size_t i = 0; i < bundle.places.size(); ++i)
    bundle.places[i].lab_from_board = UnpackPose(board_poses[i]);
  bundle.points = points;
  return BundleFit{.cost = summary.final_cost,
                   .iterations = static_cast<int>(summary.iterations.size()),
                   .converged = summary.termination_type == ceres::CONVERGENCE,
                   .stopped_because = summary.message};
}

namespace {

// Squared distances of seen to projected corners, by camera; infinite behind the camera.
std::vector<std::vector<double>> SquaredErrors(const Bundle& bundle) {
  std::vector<std::vector<double>> errors(bundle.cameras.size());
  for (const BoardPlace& place : bundle.places) {
    for (const BoardView* view : place.views) {
      const Camera& camera = bundle.cameras[static_cast<size_t>(view->camera)];
      for (size_t k = 0; k < view->corners.ids.size(); ++k) {
        const Eigen::Vector3d in_camera =
            camera.camera_from_lab *
            (place.lab_from_board * Eigen::Vector3d(bundle.points.col(view->corners.ids[k])));
        const Eigen::Vector2d seen = view->corners.pixels.col(static_cast<Eigen::Index>(k));
        errors[static_cast<size_t>(view->camera)].push_back(
            in_camera.z() > 0 ? (ProjectInCamera<double>(camera, in_camera) - seen).squaredNorm()
                              : std::numeric_limits<double>::infinity());
      }
    }
  }
  return errors;
}

}  // namespace

BundleRms RmsOf(const Bundle& bundle) {
  BundleRms rms;
  double all = 0;
  for (const std::vector<double>& errors : SquaredErrors(bundle)) {
    double sum = 0;
    for (const double e : errors) sum += e;
    rms.by_camera_px.push_back(std::sqrt(sum / static_cast<double>(errors.size())));
    all += sum;
    rms.corners += static_cast<int>(errors.size());
  }
  rms.all_px = std::sqrt(all / rms.corners);
  return rms;
}

void MeasureSigma(Bundle& bundle) {
  std::vector<std::vector<double>> errors = SquaredErrors(bundle);
  for (size_t c = 0; c < errors.size(); ++c) {
    if (errors[c].empty()) continue;
    // A squared distance of two normal coordinates is below 2 ln 2 sigma^2 half of the time.
    bundle.sigma_px[c] = std::max(0.01, std::sqrt(Median(std::move(errors[c])) / (2 * std::log(2.0))));
    if (!std::isfinite(bundle.sigma_px[c])) bundle.sigma_px[c] = 1;
  }
}

}  // namespace tendril
