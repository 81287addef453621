#include "analysis/study/scene_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/check.h"

namespace tendril {
namespace {

// Of the room's sides: left, right, top, bottom.
Eigen::Vector4d SlopesOf(const PictureRoom& room, const SceneView& view) {
  return {(room.left - view.center_x_px) / view.focal_px, (room.right - view.center_x_px) / view.focal_px,
          (room.top - view.center_y_px) / view.focal_px, (room.bottom - view.center_y_px) / view.focal_px};
}

}  // namespace

std::optional<Eigen::Vector2d> PixelOf(const SceneView& view, const Eigen::Vector3d& point_in_lab) {
  const Eigen::Vector3d p = view.camera_from_lab * point_in_lab;
  if (!(p.z() > 0)) return std::nullopt;
  return Eigen::Vector2d(view.focal_px * p.x() / p.z() + view.center_x_px,
                         view.focal_px * p.y() / p.z() + view.center_y_px);
}

SceneView Magnified(const SceneView& view, int factor) {
  SceneView large = view;
  large.width_px *= factor;
  large.height_px *= factor;
  large.focal_px *= factor;
  large.center_x_px = (view.center_x_px + 0.5) * factor - 0.5;
  large.center_y_px = (view.center_y_px + 0.5) * factor - 0.5;
  return large;
}

Eigen::Matrix3d CameraTurn(double azimuth, double elevation) {
  const Eigen::Vector3d forward = -Eigen::Vector3d(
      std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
  const Eigen::Vector3d right(-std::sin(azimuth), std::cos(azimuth), 0);
  Eigen::Matrix3d camera_axes;
  camera_axes << right, forward.cross(right), forward;
  return camera_axes.transpose();
}

// A side of the room and the eye span a plane; a ball is inside if its signed distance is at least its
// radius. With the eye at e: n . (c - e) >= r, so each side says n . e <= least of n . c - r, n not
// normalized: (1, -slope) on the near sides, (-1, slope) on the far ones.
EyeBounds BoundsOf(const std::vector<SceneBall>& balls, const PictureRoom& room, const SceneView& view) {
  TENDRIL_CHECK(!balls.empty());
  const Eigen::Vector4d slope = SlopesOf(room, view);
  constexpr double kFar = std::numeric_limits<double>::infinity();
  EyeBounds bounds{.sides = Eigen::Vector4d::Constant(kFar), .depth = kFar};
  for (const SceneBall& ball : balls) {
    const Eigen::Vector3d c = view.camera_from_lab.linear() * ball.center;
    bounds.depth = std::min(bounds.depth, c.z() - ball.radius);
    for (int side = 0; side < 4; ++side) {
      const double sign = side % 2 == 0 ? 1 : -1;
      const double along = side < 2 ? c.x() : c.y();
      const double n_c = sign * (along - slope[side] * c.z());
      bounds.sides[side] =
          std::min(bounds.sides[side], n_c - ball.radius * std::sqrt(1 + slope[side] * slope[side]));
    }
  }
  return bounds;
}

void MoveWithin(const EyeBounds& bounds, const PictureRoom& room, SceneView& view) {
  const Eigen::Vector4d slope = SlopesOf(room, view);
  const Eigen::Vector4d& least = bounds.sides;
  // x - s0 z <= least0 and -x + s1 z <= least1: their sum bounds z.
  double z =
      std::min((least[0] + least[1]) / (slope[1] - slope[0]), (least[2] + least[3]) / (slope[3] - slope[2]));
  z = std::min(z, bounds.depth - 1e-3 * std::abs(bounds.depth - z));
  const auto middle = [&](int side) {
    const double high = least[side] + slope[side] * z;
    const double low = slope[side + 1] * z - least[side + 1];
    return 0.5 * (low + high);
  };
  const Eigen::Vector3d eye(middle(0), middle(2), z);
  view.camera_from_lab.translation() = -eye;
}

double DepthOf(const SceneView& view, const Eigen::Vector3d& point_in_lab) {
  return (view.camera_from_lab * point_in_lab).z();
}

}  // namespace tendril
