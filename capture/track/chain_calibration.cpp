#include "capture/track/chain_calibration.h"

#include <cmath>

namespace tendril {
namespace {

constexpr int kFields = 6;  // of a camera: constant, slope, slope in x, then in y

// The step of a tag that looks like a shift of its picture by 1 px in x (column 0) and in y (column 1): what
// the camera is wrong by, the tag seems to have moved by.
Eigen::Matrix<double, 6, 2> StepOfPixel(const Camera& camera, double depth) {
  Eigen::Matrix<double, 6, 2> step = Eigen::Matrix<double, 6, 2>::Zero();
  const Eigen::Matrix3d lab_from_camera = camera.camera_from_lab.linear().transpose();
  step.block<3, 1>(3, 0) = lab_from_camera.col(0) * depth / camera.focal_x_px;
  step.block<3, 1>(3, 1) = lab_from_camera.col(1) * depth / camera.focal_y_px;
  return step;
}

}  // namespace

Eigen::MatrixXd PosesByCalibration(const ChainProblem& problem, const Descent& run,
                                   const ChainCholesky& cholesky) {
  const ChainOptions& options = *problem.options;
  const std::size_t count = run.facets.size();
  const std::size_t fields = kFields * problem.cameras.size();
  std::vector<std::vector<FacetVector>> pull(fields, std::vector<FacetVector>(count, FacetVector::Zero()));
  std::vector<char> sees(problem.cameras.size(), 0);
  for (const std::vector<int>& members : problem.tags) {
    ViewFit sum;
    if (!SumOfViews(run.at, run.weight, members, sum)) continue;
    const TagPlace& place = *problem.views[members.front()].place;
    const FacetState& facet = run.facets[place.facet];
    const TagSlop slop = SlopOfTag(options, facet.rotation);
    const Eigen::Vector3d hole(0, 0, problem.model->layout.hole_z[place.facet]);
    const Eigen::Vector3d arm = place.corners_in_sheet.rowwise().mean() - hole;
    for (const int v : members) {
      if (!run.at.views[v] || !(run.weight[v] > 0)) continue;
      const int number = problem.views[v].camera;
      const Camera& camera = problem.cameras[number];
      sees[number] = 1;
      const Eigen::Vector3d in_camera = camera.camera_from_lab * (facet.hole + facet.rotation * arm);
      const Eigen::Matrix<double, 6, 2> gradient =
          run.weight[v] * run.at.views[v]->hessian * StepOfPixel(camera, in_camera.z());
      const Eigen::Vector2d pixel = problem.views[v].corners_px.rowwise().mean();
      // Legendre's polynomials, each of mean square 1 over the picture.
      const double across = std::sqrt(3.0) * (2 * pixel.x() / camera.width_px - 1);
      const double down = std::sqrt(3.0) * (2 * pixel.y() / camera.height_px - 1);
      const double share = options.sigma_calibration_px / std::sqrt(3.0);
      const FacetPulls pulls = PullsOnFacet(sum, slop, gradient, facet.rotation, arm);
      for (int axis = 0; axis < 2; ++axis) {
        const FacetVector on_facet = pulls.col(axis);
        const std::size_t first = static_cast<std::size_t>(kFields * number + 3 * axis);
        pull[first][place.facet] += share * on_facet;
        pull[first + 1][place.facet] += share * across * on_facet;
        pull[first + 2][place.facet] += share * down * on_facet;
      }
    }
  }
  Eigen::MatrixXd moved =
      Eigen::MatrixXd::Zero(6 * static_cast<Eigen::Index>(count), static_cast<Eigen::Index>(fields));
  for (std::size_t f = 0; f < fields; ++f) {
    if (sees[f / kFields] == 0) continue;
    const std::vector<FacetVector> step = cholesky.Solve(pull[f]);
    for (std::size_t i = 0; i < count; ++i) {
      moved.block<6, 1>(6 * static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(f)) = step[i].head<6>();
    }
  }
  return moved;
}

}  // namespace tendril
