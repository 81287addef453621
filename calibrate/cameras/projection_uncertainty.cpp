#include "calibrate/cameras/projection_uncertainty.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "calibrate/cameras/bundle.h"
#include "model/median.h"

namespace tendril {
namespace {

using Row2 = Eigen::Matrix<double, 2, Eigen::Dynamic>;

// d pixel / d lens and d pixel / d turn of the camera, by central differences: all are smooth and well
// scaled, and the result is a picture.
Row2 ByLens(const Camera& camera, const Eigen::Vector3d& ray, Eigen::Index parameters) {
  Row2 slope(2, parameters);
  for (Eigen::Index i = 0; i < parameters; ++i) {
    const auto moved = [&](double step) {
      Camera c = camera;
      double* const first[4] = {&c.focal_x_px, &c.focal_y_px, &c.center_x_px, &c.center_y_px};
      (i < 4 ? *first[i] : c.coefficients[static_cast<size_t>(i - 4)]) += step;
      return ProjectInCamera<double>(c, ray);
    };
    const double step = i < 4 ? 1e-3 : 1e-6;
    slope.col(i) = (moved(step) - moved(-step)) / (2 * step);
  }
  return slope;
}

Row2 ByTurn(const Camera& camera, const Eigen::Vector3d& ray) {
  Row2 slope(2, 3);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d axis = Eigen::Vector3d::Unit(i);
    slope.col(i) = (ProjectInCamera<double>(camera, ray + kStep * axis.cross(ray)) -
                    ProjectInCamera<double>(camera, ray - kStep * axis.cross(ray))) /
                   (2 * kStep);
  }
  return slope;
}

}  // namespace

ProjectionUncertainty UncertaintyOf(const Camera& camera, const Eigen::MatrixXd& lens_covariance, int rows,
                                    int columns) {
  ProjectionUncertainty answer;
  answer.sigma_px = Eigen::MatrixXd::Constant(rows, columns, std::numeric_limits<double>::quiet_NaN());
  const Eigen::Index n = lens_covariance.rows();
  if (!lens_covariance.allFinite() || n < 4) return answer;
  struct Cell {
    Row2 lens;
    Row2 turn;
  };
  std::vector<std::optional<Cell>> cells(static_cast<size_t>(rows * columns));
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const Eigen::Vector2d pixel((c + 0.5) * camera.width_px / columns - 0.5,
                                  (r + 0.5) * camera.height_px / rows - 0.5);
      const auto ray = RayOfPixel(camera, pixel);
      if (!ray || !(ray->z() > 0)) continue;
      cells[static_cast<size_t>(r * columns + c)] = Cell{ByLens(camera, *ray, n), ByTurn(camera, *ray)};
    }
  }
  // The turn that suits best where the lens is known: cells count by the inverse of their variance, which
  // takes a turn to compute; three rounds suffice for a picture. None counts more than the middle one, or the
  // turn would suit one place better and better, and that place seem known.
  Eigen::MatrixXd compensating = Eigen::MatrixXd::Zero(3, n);
  for (int round = 0; round < 3; ++round) {
    Eigen::Matrix3d turns = Eigen::Matrix3d::Zero();
    Eigen::MatrixXd across = Eigen::MatrixXd::Zero(3, n);
    std::vector<double> variances;
    for (const auto& cell : cells) {
      if (!cell) continue;
      const Row2 slope = cell->lens - cell->turn * compensating;
      variances.push_back((slope * lens_covariance * slope.transpose()).trace());
    }
    if (variances.empty()) return answer;
    const double floor = std::max(Median(variances), 1e-12);
    std::size_t next = 0;
    for (const auto& cell : cells) {
      if (!cell) continue;
      const double weight = 1 / std::max(variances[next++], floor);
      turns += weight * cell->turn.transpose() * cell->turn;
      across += weight * cell->turn.transpose() * cell->lens;
    }
    if (!(turns.trace() > 0)) return answer;
    compensating = turns.ldlt().solve(across);
  }
  std::vector<double> known;
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const auto& cell = cells[static_cast<size_t>(r * columns + c)];
      if (!cell) continue;
      const Row2 slope = cell->lens - cell->turn * compensating;
      const Eigen::Matrix2d spread = slope * lens_covariance * slope.transpose();
      const double largest = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(spread).eigenvalues()[1];
      answer.sigma_px(r, c) = std::sqrt(std::max(0.0, largest));
      known.push_back(answer.sigma_px(r, c));
    }
  }
  answer.median_px = Median(known);
  answer.largest_px = *std::max_element(known.begin(), known.end());
  return answer;
}

}  // namespace tendril
