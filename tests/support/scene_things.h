#pragma once
// Things to draw, a camera to see them with, and what its rays meet.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/core.hpp>
#include <random>
#include <string>
#include <vector>

#include "analysis/study/scene_picture.h"
#include "analysis/study/scene_pieces.h"
#include "analysis/study/scene_raster.h"

namespace tendril::testing_support {

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// From (0, -distance, 0) along +y: x to the right, z up.
inline SceneView FromTheFront(double distance, int width = 640, int height = 480, double focal = 600) {
  SceneView view{.width_px = width, .height_px = height, .focal_px = focal};
  view.camera_from_lab.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  view.camera_from_lab.translation() = Eigen::Vector3d(0, 0, distance);
  view.center_x_px = 0.5 * (width - 1);
  view.center_y_px = 0.5 * (height - 1);
  view.floor_z = -1e3;
  return view;
}

inline Tube Straight(const std::string& name, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                     double radius, int nodes = 11) {
  Tube tube{
      .points = Eigen::Matrix3Xd(3, nodes), .radius = Eigen::VectorXd::Constant(nodes, radius), .name = name};
  for (int i = 0; i < nodes; ++i) tube.points.col(i) = from + (to - from) * i / std::max(1, nodes - 1);
  return tube;
}

inline Tube Arc(double ring, double radius, int nodes) {
  Tube tube{.points = Eigen::Matrix3Xd(3, nodes),
            .radius = Eigen::VectorXd::Constant(nodes, radius),
            .name = "arc"};
  for (int i = 0; i < nodes; ++i) {
    const double angle = 1.5 * std::numbers::pi * i / (nodes - 1);
    tube.points.col(i) = ring * Eigen::Vector3d(std::cos(angle), 0, std::sin(angle));
  }
  return tube;
}

inline ShownObject Sphere(const Eigen::Vector3d& at, double radius) {
  ShownObject object{.shape = {{.kind = PrimitiveKind::kSphere, .radius = radius}}};
  object.pose.translation() = at;
  return object;
}

// A capsule between the middles of its ends, or a cylinder between its ends.
inline ShownObject Between(PrimitiveKind kind, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                           double radius) {
  ShownObject object{.shape = {{.kind = kind, .radius = radius, .half = {0, 0, 0.5 * (to - from).norm()}}}};
  object.pose.translation() = 0.5 * (from + to);
  object.pose.linear() =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), to - from).toRotationMatrix();
  return object;
}

inline ShownObject Box(const Eigen::Isometry3d& pose, const Eigen::Vector3d& half) {
  return {.shape = {{.kind = PrimitiveKind::kBox, .half = half}}, .pose = pose};
}

inline ShownObject Table(double height) {
  ShownObject object{.shape = {{.kind = PrimitiveKind::kHalfSpace}}};
  object.pose.translation().z() = height;
  return object;
}

inline Eigen::Isometry3d Turned(double angle, const Eigen::Vector3d& axis, const Eigen::Vector3d& at) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
  pose.translation() = at;
  return pose;
}

inline SceneRaster Cast(const ShownObject& object, const SceneView& view) {
  std::vector<ScenePiece> pieces;
  AddObject(object, 0, view, 0, pieces);
  SceneRaster raster;
  CastRays(pieces, view, raster);
  return raster;
}

inline bool Hits(const SceneRaster& raster, int x, int y) {
  return raster.Holds(x, y) && raster.piece[raster.At(x, y)] >= 0;
}

// Curves like a gripper's: hanging, wound, tapering.
inline ScenePicture Wound(int tubes, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  ScenePicture picture{.title = "wound", .time = 1.25};
  for (int t = 0; t < tubes; ++t) {
    const Eigen::Vector3d start(0.1 * uniform(generator), 0.1 * uniform(generator), 0.1 * uniform(generator));
    const double turns = 1 + uniform(generator), phase = 3 * uniform(generator);
    Tube tube{.points = Eigen::Matrix3Xd(3, 61),
              .radius = Eigen::VectorXd::LinSpaced(61, 0.02, 0.008),
              .name = "tentacle" + std::to_string(t)};
    for (int i = 0; i <= 60; ++i) {
      const double s = i / 60.0, angle = 2 * std::numbers::pi * turns * s + phase;
      tube.points.col(i) =
          start + Eigen::Vector3d(0.1 * s * std::cos(angle), 0.1 * s * std::sin(angle), -0.5 * s);
    }
    picture.tubes.push_back(tube);
  }
  picture.objects = {Between(PrimitiveKind::kCapsule, {-0.15, 0, -0.2}, {0.15, 0.02, -0.2}, 0.02),
                     Between(PrimitiveKind::kCylinder, {0, 0, -0.4}, {0, 0.1, -0.3}, 0.03),
                     Sphere({0.1, 0.1, -0.1}, 0.03),
                     Box(Turned(0.7, {1, 2, 3}, {-0.1, -0.12, -0.3}), {0.05, 0.02, 0.01})};
  picture.lines = {"mutual link 0.50 turns", "object link -1.25 turns"};
  return picture;
}

inline bool Same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

}  // namespace tendril::testing_support
