#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include "analysis/study/scene_labels.h"
#include "analysis/study/scene_picture.h"
#include "analysis/study/scene_pieces.h"
#include "model/check.h"

namespace tendril {
namespace {

std::vector<SceneBall> BallsOf(const ScenePicture& picture) {
  std::vector<SceneBall> balls;
  const auto add = [&](const Eigen::Vector3d& at, double radius) {
    if (CanBeDrawn(at)) balls.push_back({at, std::isfinite(radius) ? std::max(0.0, radius) : 0.0});
  };
  for (const Tube& tube : picture.tubes) {
    for (Eigen::Index i = 0; i < tube.points.cols(); ++i) {
      add(tube.points.col(i), i < tube.radius.size() ? tube.radius[i] : 0.0);
    }
  }
  for (const ShownObject& object : picture.objects) {
    for (const SurfaceSphere& sphere : SurfaceSpheres(object.shape))
      add(object.pose * sphere.centre, sphere.radius);
  }
  for (const Wire& wire : picture.wires) {
    if (!wire.in_view) continue;
    for (Eigen::Index i = 0; i < wire.points.cols(); ++i) add(wire.points.col(i), wire.radius);
  }
  return balls;
}

// How good a place to look from: over how much of the screen, in cells of a grid, the balls' middles are
// spread; less where some are so much nearer than others that perspective distorts.
double WorthOf(const std::vector<SceneBall>& balls, const SceneView& view) {
  std::set<std::pair<int, int>> cells;
  double nearest = std::numeric_limits<double>::infinity(), farthest = 0;
  for (const SceneBall& ball : balls) {
    const std::optional<Eigen::Vector2d> pixel = PixelOf(view, ball.center);
    if (!pixel) continue;
    const double depth = DepthOf(view, ball.center);
    nearest = std::min(nearest, depth);
    farthest = std::max(farthest, depth);
    cells.emplace(static_cast<int>(std::floor(pixel->x() * 100 / view.width_px)),
                  static_cast<int>(std::floor(pixel->y() * 56 / view.height_px)));
  }
  return cells.empty() ? 0 : static_cast<double>(cells.size()) * std::sqrt(nearest / farthest);
}

// The direction in which an object is much longer than across; none: it is not.
std::optional<Eigen::Vector3d> LongAxisOf(const ShownObject& object) {
  const std::vector<SurfaceSphere> spheres = SurfaceSpheres(object.shape);
  if (spheres.empty() || !object.pose.matrix().allFinite()) return std::nullopt;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const SurfaceSphere& sphere : spheres) middle += sphere.centre / static_cast<double>(spheres.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  double round = 0;
  for (const SurfaceSphere& sphere : spheres) {
    spread += (sphere.centre - middle) * (sphere.centre - middle).transpose();
    round += sphere.radius * sphere.radius / 3;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
  constexpr double kLonger = 1.5;
  if (axes.eigenvalues()[2] < kLonger * kLonger * (axes.eigenvalues()[1] + round)) return std::nullopt;
  return Eigen::Vector3d(object.pose.linear() * axes.eigenvectors().col(2));
}

// Nearer 1 the less objects are seen end on.
double BroadsideOf(const std::vector<Eigen::Vector3d>& long_axes, const SceneView& view) {
  double worth = 1;
  for (const Eigen::Vector3d& axis : long_axes) {
    const double end_on = (view.camera_from_lab.linear() * axis).z();
    worth *= 1 - 0.3 * end_on * end_on;
  }
  return worth;
}

// The height of the highest table's top; none: there is no table.
std::optional<double> TableOf(const std::vector<ScenePicture>& pictures) {
  std::optional<double> height;
  for (const ScenePicture& picture : pictures) {
    for (const ShownObject& object : picture.objects) {
      for (const Primitive& part : object.shape) {
        if (!IsFloor(part, object.pose)) continue;
        const double z = (object.pose * part.object_from_primitive).translation().z();
        height = std::max(height.value_or(z), z);
      }
    }
  }
  return height;
}

// A column for each picture, made of those of the pictures at most kFollow from it in time.
template <class Take>
Eigen::MatrixXd OverWindow(const Eigen::MatrixXd& columns, const Eigen::VectorXd& time, const Take& take) {
  constexpr double kFollow = 2;  // s
  Eigen::MatrixXd taken(columns.rows(), columns.cols());
  Eigen::Index from = 0, until = 0;
  for (Eigen::Index f = 0; f < columns.cols(); ++f) {
    while (time[from] < time[f] - kFollow) ++from;
    while (until < columns.cols() && time[until] <= time[f] + kFollow) ++until;
    taken.col(f) = take(columns.middleCols(from, until - from));
  }
  return taken;
}

}  // namespace

SceneView FitView(const std::vector<ScenePicture>& pictures, int width_px, int height_px) {
  TENDRIL_CHECK(width_px >= 64 && height_px >= 64);
  SceneView view{.width_px = width_px, .height_px = height_px};
  view.center_x_px = 0.5 * (width_px - 1);
  view.center_y_px = 0.5 * (height_px - 1);
  view.focal_px = 2.0 * std::min(height_px, width_px * 9 / 16);  // 28 degrees high: little distortion
  std::vector<SceneBall> all, last;
  for (const ScenePicture& picture : pictures) {
    const std::vector<SceneBall> balls = BallsOf(picture);
    all.insert(all.end(), balls.begin(), balls.end());
    if (!balls.empty()) last = balls;
  }
  if (all.empty()) all = last = {{Eigen::Vector3d::Zero(), 0.5}};

  Eigen::AlignedBox3d box;
  for (const SceneBall& ball : all) {
    box.extend(Eigen::Vector3d(ball.center.array() - ball.radius));
    box.extend(Eigen::Vector3d(ball.center.array() + ball.radius));
  }
  view.middle = view.subject = box.center();
  view.reach = std::max(0.5 * box.diagonal().norm(), 1e-9);
  view.floor_z = box.min().z() - 0.03 * view.reach;
  if (const std::optional<double> table = TableOf(pictures)) {
    view.floor_z = *table;
    view.floor_is_table = true;
  }
  if (box.diagonal().norm() < 1e-9) all.push_back({view.middle, view.reach});

  // Sixteen turns and three heights; a low camera shows best how far things hang, so a higher one must show
  // clearly more. Among equals, the one from the right front.
  std::vector<Eigen::Vector3d> long_axes;
  if (!pictures.empty()) {
    for (const ShownObject& object : pictures.back().objects) {
      if (const auto axis = LongAxisOf(object)) long_axes.push_back(*axis);
    }
  }
  const PictureRoom room = RoomBesideLabels(width_px, height_px);
  constexpr int kTurns = 16;
  constexpr double kPreferred = -0.32 * std::numbers::pi;
  double best = -1;
  SceneView chosen = view;
  for (const auto& [elevation, worth] :
       {std::pair(0.38, 1.0), std::pair(0.65, 0.80), std::pair(0.95, 0.60)}) {
    for (int turn = 0; turn < kTurns; ++turn) {
      const double azimuth = kPreferred + 2 * std::numbers::pi * turn / kTurns;
      view.camera_from_lab.linear() = CameraTurn(azimuth, elevation);
      MoveWithin(BoundsOf(all, room, view), room, view);
      const double broadside = BroadsideOf(long_axes, view);
      const double preference = 1 + 0.04 * std::cos(azimuth - kPreferred);
      const double score = worth * preference * WorthOf(last, view) * broadside;
      if (score <= best) continue;
      best = score;
      chosen = view;
    }
  }
  return chosen;
}

std::vector<SceneView> FollowViews(const std::vector<ScenePicture>& pictures, const Eigen::VectorXd& time,
                                   int width_px, int height_px) {
  TENDRIL_CHECK(time.size() == static_cast<Eigen::Index>(pictures.size()));
  const SceneView fixed = FitView(pictures, width_px, height_px);
  const PictureRoom room = RoomBesideLabels(width_px, height_px);
  // What each picture asks of the eye, and the middle of what it shows.
  constexpr int kAsked = 5, kMiddle = 3;
  const auto frames = static_cast<Eigen::Index>(pictures.size());
  Eigen::MatrixXd asked(kAsked, frames), middles(kMiddle, frames);
  for (Eigen::Index f = 0; f < frames; ++f) {
    std::vector<SceneBall> balls = BallsOf(pictures[static_cast<std::size_t>(f)]);
    if (balls.empty()) balls.push_back({fixed.middle, fixed.reach});
    const EyeBounds bounds = BoundsOf(balls, room, fixed);
    asked.col(f) << bounds.sides, bounds.depth;
    Eigen::AlignedBox3d box;
    for (const SceneBall& ball : balls) box.extend(ball.center);
    middles.col(f) = box.center();
  }
  // The least of some time is asked for, and then its mean over as long: that is smooth, and never more than
  // any picture allows.
  const Eigen::MatrixXd least =
      OverWindow(asked, time, [](const auto& part) -> Eigen::VectorXd { return part.rowwise().minCoeff(); });
  const auto mean = [](const auto& part) -> Eigen::VectorXd { return part.rowwise().mean(); };
  const Eigen::MatrixXd smooth = OverWindow(least, time, mean), subjects = OverWindow(middles, time, mean);
  std::vector<SceneView> views(pictures.size(), fixed);
  for (Eigen::Index f = 0; f < frames; ++f) {
    SceneView& view = views[static_cast<std::size_t>(f)];
    MoveWithin({.sides = smooth.col(f).head<4>(), .depth = smooth(4, f)}, room, view);
    view.subject = subjects.col(f);
  }
  return views;
}

}  // namespace tendril
