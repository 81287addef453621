#pragma once
// A made-up rig of four cameras in a row and a board that is shown to neighbours: camera 3 shares views with
// camera 2 only. For tests and bench/camera_calibration.cpp.

#include <cmath>
#include <optional>
#include <random>
#include <vector>

#include "calibrate/cameras/calibrate_cameras.h"
#include "capture/track/board.h"

namespace tendril::testing_support {

// Of the chessboard that is shown, m.
inline const Eigen::Matrix3Xd& Points() {
  static const Eigen::Matrix3Xd points = BoardPoints(ParseBoard("chessboard:9x6:0.03").value());
  return points;
}

inline std::vector<Camera> FourInARow(Distortion lens) {
  std::vector<Camera> cameras(4);
  for (size_t i = 0; i < 4; ++i) {
    Camera& c = cameras[i];
    const auto x = static_cast<double>(i);
    c.name = "cam" + std::to_string(i);
    c.width_px = 640;
    c.height_px = 480;
    c.distortion = lens;
    if (lens == Distortion::kEquidistant) {
      c.focal_x_px = 420 + 5 * x;
      c.coefficients = {-0.013 + 0.002 * x, -0.0099, 0.012, -0.0045, 0};
    } else {
      c.focal_x_px = 600 + 10 * x;
      c.coefficients = {-0.25 + 0.02 * x, 0.09, 0.001, -0.0005 * x, -0.01};
    }
    c.focal_y_px = c.focal_x_px + 1.5;
    c.center_x_px = 322 - 3 * x;
    c.center_y_px = 241 + 2 * x;
    Eigen::Isometry3d lab_from_camera = Eigen::Isometry3d::Identity();
    if (i > 0) {
      lab_from_camera.translation() = Eigen::Vector3d(0.5 * x, 0.02 * x, -0.03 * x);
      lab_from_camera.linear() =
          Eigen::AngleAxisd(0.12 * x - 0.2, Eigen::Vector3d(0.3, 1, 0.2).normalized()).toRotationMatrix();
    }
    c.camera_from_lab = lab_from_camera.inverse();
  }
  return cameras;
}

// The cameras as a calibration begins: names, sizes and kind of lens only.
inline std::vector<Camera> Unknown(const std::vector<Camera>& truth) {
  std::vector<Camera> blind(truth.size());
  for (size_t i = 0; i < truth.size(); ++i) {
    blind[i].name = truth[i].name;
    blind[i].width_px = truth[i].width_px;
    blind[i].height_px = truth[i].height_px;
    blind[i].distortion = truth[i].distortion;
  }
  return blind;
}

// Where the whole board is in the picture; none where it is not.
inline std::optional<BoardCorners> WholeBoard(const Camera& camera, const Eigen::Isometry3d& lab_from_board,
                                              const Eigen::Matrix3Xd& points, double margin_px = 6) {
  BoardCorners corners;
  corners.pixels.resize(2, points.cols());
  for (Eigen::Index k = 0; k < points.cols(); ++k) {
    const auto p = Project(camera, lab_from_board * Eigen::Vector3d(points.col(k)));
    if (!p || p->x() < margin_px || p->y() < margin_px || p->x() > camera.width_px - 1 - margin_px ||
        p->y() > camera.height_px - 1 - margin_px) {
      return std::nullopt;
    }
    corners.ids.push_back(static_cast<int>(k));
    corners.pixels.col(k) = *p;
  }
  return corners;
}

// A pose that two neighbours see wholly, tilted by up to 45 degrees.
inline Eigen::Isometry3d ShownTo(const std::vector<Camera>& cameras, size_t first,
                                 const Eigen::Matrix3Xd& points, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  const Eigen::Vector3d middle = 0.5 * (points.rowwise().minCoeff() + points.rowwise().maxCoeff());
  for (;;) {
    const Eigen::Isometry3d a = cameras[first].camera_from_lab.inverse();
    const Eigen::Isometry3d b = cameras[first + 1].camera_from_lab.inverse();
    const Eigen::Vector3d between = 0.5 * (a.translation() + b.translation());
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    const double axis = 3.2 * unit(random);
    pose.linear() = 0.5 * (a.linear() + b.linear());
    pose.linear() =
        Eigen::Quaterniond(pose.linear()).normalized().toRotationMatrix() *
        (Eigen::AngleAxisd(0.8 * std::abs(unit(random)), Eigen::Vector3d(std::cos(axis), std::sin(axis), 0)) *
         Eigen::AngleAxisd(0.4 * unit(random), Eigen::Vector3d::UnitZ()))
            .toRotationMatrix();
    pose.translation() =
        between + Eigen::Vector3d(0.35 * unit(random), 0.35 * unit(random), 0.85 + 0.35 * unit(random)) -
        pose.linear() * middle;
    if (WholeBoard(cameras[first], pose, points) && WholeBoard(cameras[first + 1], pose, points)) return pose;
  }
}

// `per_pair` moments for each pair of neighbours; corners err by noise_px in each coordinate.
inline std::vector<BoardView> ChainedViews(const std::vector<Camera>& cameras, const Eigen::Matrix3Xd& points,
                                           int per_pair, double noise_px, std::mt19937& random) {
  std::normal_distribution<double> noise(0, noise_px);
  std::vector<BoardView> views;
  for (size_t pair = 0; pair + 1 < cameras.size(); ++pair) {
    for (int i = 0; i < per_pair; ++i) {
      const Eigen::Isometry3d pose = ShownTo(cameras, pair, points, random);
      for (size_t c = pair; c <= pair + 1; ++c) {
        BoardView view{static_cast<std::int64_t>(pair) * per_pair + i, 0, static_cast<int>(c),
                       *WholeBoard(cameras[c], pose, points)};
        if (noise_px > 0) {
          for (double& value : view.corners.pixels.reshaped()) value += noise(random);
        }
        views.push_back(std::move(view));
      }
    }
  }
  return views;
}

struct Coverage {
  int inside = 0;
  int asked = 0;
  double chi2 = 0;  // sum of (error / standard error)^2

  double share() const { return asked > 0 ? static_cast<double>(inside) / asked : NAN; }
  double spread() const { return asked > 0 ? std::sqrt(chi2 / asked) : NAN; }
};

// Adds, for each parameter, whether its interval has the truth.
inline void Count(const CameraCalibration& fit, const std::vector<Camera>& truth, Coverage& lenses,
                  Coverage& poses) {
  for (size_t c = 0; c < truth.size(); ++c) {
    const Camera& t = truth[c];
    const Eigen::Isometry3d lab_from_truth = t.camera_from_lab.inverse();
    const Eigen::AngleAxisd off(fit.cameras[c].camera_from_lab.inverse().linear() *
                                lab_from_truth.linear().transpose());
    for (size_t i = 0; i < fit.reports[c].parameters.size(); ++i) {
      const CalibratedParameter& p = fit.reports[c].parameters[i];
      const bool pose = p.name.starts_with("position") || p.name.starts_with("rotation");
      const double lens[4] = {t.focal_x_px, t.focal_y_px, t.center_x_px, t.center_y_px};
      double error = 0;
      if (p.name.starts_with("position")) {
        error = p.value - lab_from_truth.translation()[p.name[9] - 'x'];
      } else if (p.name.starts_with("rotation")) {
        error = (off.angle() * off.axis())[p.name[9] - 'x'];
      } else {
        error = p.value - (i < 4 ? lens[i] : t.coefficients[i - 4]);
      }
      Coverage& into = pose ? poses : lenses;
      ++into.asked;
      into.inside += std::abs(error) <= p.high - p.value;
      into.chi2 += std::pow(error / p.standard_error, 2);
    }
  }
}

}  // namespace tendril::testing_support
