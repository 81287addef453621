#pragma once
// Where a scene is seen from: a pinhole camera that looks at it from the side, z up.
//
// Camera axes as everywhere (x right, y down, z forward); pixel centres are integers.

#include <Eigen/Geometry>
#include <optional>
#include <vector>

namespace tendril {

struct SceneView {
  int width_px = 1280;
  int height_px = 720;
  Eigen::Isometry3d camera_from_lab = Eigen::Isometry3d::Identity();
  double focal_px = 1000;
  double center_x_px = 640, center_y_px = 360;

  // What is looked at; the bar of the picture's scale is as deep as it, m.
  Eigen::Vector3d subject = Eigen::Vector3d::Zero();

  // The scene, over all its pictures: a ball about it, and the floor below it.
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();  // m
  double reach = 1;                                  // m, > 0
  double floor_z = -1;                               // m
  bool floor_is_table = false;                       // things may stand on it
};

// Where a point in the lab is in the picture; none: behind the camera.
std::optional<Eigen::Vector2d> PixelOf(const SceneView& view, const Eigen::Vector3d& point_in_lab);

// The same view with `factor` times as many pixels each way.
SceneView Magnified(const SceneView& view, int factor);

// Something to be seen: all within the radius of the centre.
struct SceneBall {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  // m
  double radius = 0;                                 // m
};

// The part of the picture that is for the scene, px.
struct PictureRoom {
  double left = 0, right = 1280, top = 0, bottom = 720;
};

// Rotation from the lab to a camera that looks at the scene from there.
//   azimuth, elevation  of the camera, as seen from the scene, rad
Eigen::Matrix3d CameraTurn(double azimuth, double elevation);

// Where the eye may be, in the axes of the view's camera, for balls to be in the room: behind four planes
// through it, one a side of the room, and nearer than the first ball.
struct EyeBounds {
  Eigen::Vector4d sides = Eigen::Vector4d::Zero();  // m; left, right, top, bottom
  double depth = 0;                                 // m
};
//   balls  at least one (checked), finite
EyeBounds BoundsOf(const std::vector<SceneBall>& balls, const PictureRoom& room, const SceneView& view);

// Moves the camera as near as the bounds let it, to the middle of the room where there is room to spare.
void MoveWithin(const EyeBounds& bounds, const PictureRoom& room, SceneView& view);

// Depth of the point before the camera, m.
double DepthOf(const SceneView& view, const Eigen::Vector3d& point_in_lab);

}  // namespace tendril
