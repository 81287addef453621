// Objects, strings and tables in analysis/study/scene_picture.h's pictures: outlines by the pinhole camera,
// what rays meet lies on the shapes' surfaces as model/objects/shape.h measures them, poses, what takes room.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "analysis/study/scene_picture.h"
#include "analysis/study/scene_pieces.h"
#include "analysis/study/scene_raster.h"
#include "tests/support/scene_things.h"

namespace tendril {
namespace {

using namespace testing_support;

TEST(CastRays, FlatEndsAreFlatAndRoundOnesRound) {
  const SceneView view = FromTheFront(1);  // its middle is half a pixel off the centre
  const auto depth_of = [&](PrimitiveKind kind) {
    const SceneRaster raster = Cast(Between(kind, {0, 0, 0}, {0, 0.5, 0}, 0.05), view);
    return raster.depth[raster.At(320, 240)];
  };
  EXPECT_NEAR(depth_of(PrimitiveKind::kCylinder), 1.0, 1e-5);
  EXPECT_NEAR(depth_of(PrimitiveKind::kCapsule), 0.95, 2e-5);
  const SceneRaster ball = Cast(Sphere(Eigen::Vector3d::Zero(), 0.05), view);
  EXPECT_NEAR(ball.depth[ball.At(320, 240)], 0.95, 2e-5);
}

TEST(CastRays, AFlatEndCoversTheCornersThatARoundOneDoesNot) {
  const SceneView view = FromTheFront(50, 640, 480, 30000);  // 600 px per metre, near and far
  const double radius = 0.05, half = 0.2;
  const Eigen::Vector3d end(half, 0, 0), round_end(half - radius, 0, 0);
  const SceneRaster flat = Cast(Between(PrimitiveKind::kCylinder, -end, end, radius), view);
  const SceneRaster round = Cast(Between(PrimitiveKind::kCapsule, -round_end, round_end, radius), view);
  // Both are as long and as thick.
  const auto middle = PixelOf(view, {0, 0, 0}), tip = PixelOf(view, end);
  const int y = static_cast<int>(std::lround(middle->y())), tip_x = static_cast<int>(tip->x());
  EXPECT_TRUE(Hits(flat, tip_x - 2, y) && Hits(round, tip_x - 2, y));
  EXPECT_FALSE(Hits(flat, tip_x + 4, y) || Hits(round, tip_x + 4, y));
  const int x = static_cast<int>(std::lround(middle->x()));
  const int top = static_cast<int>(std::lround(PixelOf(view, {0, 0, radius})->y()));
  EXPECT_TRUE(Hits(flat, x, top + 1) && Hits(round, x, top + 1));
  EXPECT_TRUE(Hits(flat, tip_x - 2, top + 2));
  EXPECT_FALSE(Hits(round, tip_x - 2, top + 2));
}

// Where the pinhole puts its eight corners, and nothing beyond their hull.
TEST(CastRays, ABoxsOutlineIsTheHullOfItsCorners) {
  const SceneView view = FromTheFront(1);
  const Eigen::Vector3d half(0.12, 0.03, 0.06);
  std::mt19937 generator(11);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int pose = 0; pose < 20; ++pose) {
    const Eigen::Vector3d axis(uniform(generator), uniform(generator), uniform(generator));
    const ShownObject box =
        Box(Turned(3 * uniform(generator), axis, {0.05 * uniform(generator), 0, 0.1 * axis.x()}), half);
    std::vector<cv::Point2f> corners;
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d sign(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
      const Eigen::Vector2d at = *PixelOf(view, box.pose * Eigen::Vector3d(half.cwiseProduct(sign)));
      corners.emplace_back(static_cast<float>(at.x()), static_cast<float>(at.y()));
    }
    std::vector<cv::Point2f> hull;
    cv::convexHull(corners, hull);
    const SceneRaster raster = Cast(box, view);
    for (int y = 0; y < view.height_px; ++y) {
      for (int x = 0; x < view.width_px; ++x) {
        const cv::Point2f at(static_cast<float>(x), static_cast<float>(y));
        const double inside = cv::pointPolygonTest(hull, at, true);
        if (std::abs(inside) < 1e-3) continue;
        ASSERT_EQ(Hits(raster, x, y), inside > 0) << "pose " << pose << " at " << x << ", " << y;
        if (inside < 0) continue;
        const Eigen::Vector3d in_camera = Eigen::Vector3d((x - view.center_x_px) / view.focal_px,
                                                          (y - view.center_y_px) / view.focal_px, 1) *
                                          raster.depth[raster.At(x, y)];
        const Eigen::Vector3d point = view.camera_from_lab.inverse() * in_camera;
        EXPECT_NEAR(DistanceTo(box.shape[0], box.pose.inverse() * point).distance, 0, 1e-6);
      }
    }
  }
}

TEST(CastRays, EveryPartOfAUnionIsWhereItsDistanceIsNone) {
  ShownObject object{.shape = {{.kind = PrimitiveKind::kBox, .half = {0.05, 0.04, 0.03}},
                               {.kind = PrimitiveKind::kCylinder, .radius = 0.03, .half = {0, 0, 0.08}},
                               {.kind = PrimitiveKind::kCapsule, .radius = 0.02, .half = {0, 0, 0.06}},
                               {.kind = PrimitiveKind::kSphere, .radius = 0.045}}};
  for (std::size_t part = 0; part < object.shape.size(); ++part) {
    const double turn = 0.8 * static_cast<double>(part);
    object.shape[part].object_from_primitive =
        Turned(turn, {1, turn, -0.5}, {0.08 * static_cast<double>(part) - 0.12, 0, 0.05 * std::sin(turn)});
  }
  object.pose = Turned(2.2, {0.3, -1, 0.4}, {0.02, 0.1, -0.03});
  const SceneView view = FromTheFront(1);
  std::vector<ScenePiece> pieces;
  AddObject(object, 0, view, 0, pieces);
  SceneRaster raster;
  CastRays(pieces, view, raster);
  int seen = 0;
  for (int y = raster.top; y < raster.bottom; ++y) {
    for (int x = raster.left; x < raster.right; ++x) {
      if (!Hits(raster, x, y)) continue;
      const std::size_t at = raster.At(x, y);
      const Eigen::Vector3d in_camera((x - view.center_x_px) / view.focal_px,
                                      (y - view.center_y_px) / view.focal_px, 1);
      const Eigen::Vector3d point = view.camera_from_lab.inverse() * (in_camera * double{raster.depth[at]});
      SurfaceDistance nearest{.distance = 1};
      for (const Primitive& part : object.shape) {
        const SurfaceDistance one = DistanceTo(part, object.pose.inverse() * point);
        if (one.distance < nearest.distance) nearest = one;
      }
      EXPECT_NEAR(nearest.distance, 0, 1e-6) << x << ", " << y;
      ++seen;
    }
  }
  EXPECT_GT(seen, 5000);
}

TEST(DrawScene, AnObjectIsWhereItsPoseSays) {
  const SceneView view = FromTheFront(1);
  const auto middle_of_change = [&](const Eigen::Vector3d& at) {
    ScenePicture scene{.time = kNaN};
    const cv::Mat without = DrawScene(scene, view);
    scene.objects = {Box(Turned(0.3, {0, 0, 1}, at), {0.03, 0.03, 0.03})};
    cv::Mat change, any;
    cv::absdiff(DrawScene(scene, view), without, change);
    cv::inRange(change, cv::Scalar(0, 0, 0), cv::Scalar(0, 0, 0), any);
    const cv::Moments moments = cv::moments(255 - any, true);
    return Eigen::Vector2d(moments.m10 / moments.m00, moments.m01 / moments.m00);
  };
  for (const Eigen::Vector3d& at : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.2, 0.1, -0.15)}) {
    EXPECT_LT((middle_of_change(at) - *PixelOf(view, at)).norm(), 3);
  }
}

TEST(FitView, ATablesTopIsTheFloorAndTakesNoRoom) {
  ScenePicture scene = Wound(3, 5);
  const SceneView without = FitView({scene}, 640, 360);
  scene.objects.push_back(Table(-0.6));
  const SceneView with = FitView({scene}, 640, 360);
  EXPECT_FALSE(without.floor_is_table);
  EXPECT_TRUE(with.floor_is_table);
  EXPECT_EQ(with.floor_z, -0.6);
  EXPECT_TRUE(with.camera_from_lab.isApprox(without.camera_from_lab));
}

TEST(DrawScene, ATableIsDarkerBesideWhatStandsOnItThanBelowWhatHangs) {
  constexpr double kRadius = 0.05;
  const auto standing = [&](double height) {
    ScenePicture scene{.time = kNaN, .objects = {Table(0)}};
    scene.objects.push_back(Between(PrimitiveKind::kCylinder, {0, 0, height}, {0, 0, height + 0.2}, kRadius));
    return scene;
  };
  const SceneView view = FitView({standing(0)}, 640, 360);
  // Before it, where nothing hides the table and no shadow of the key light falls.
  Eigen::Vector3d toward = view.camera_from_lab.inverse().translation();
  toward.z() = 0;
  const auto bright_at = [&](const cv::Mat& drawn, double from_axis) {
    const Eigen::Vector2d px = *PixelOf(view, from_axis * toward.normalized());
    return int{drawn.at<cv::Vec3b>(static_cast<int>(std::lround(px.y())), static_cast<int>(px.x()))[1]};
  };
  const cv::Mat stands = DrawScene(standing(0), view), hangs = DrawScene(standing(0.1), view);
  EXPECT_LT(bright_at(stands, 1.15 * kRadius), bright_at(hangs, 1.15 * kRadius) - 4);
}

TEST(FitView, AWireThatMayRunOutOfThePictureTakesNoRoom) {
  ScenePicture scene = Wound(3, 5);
  const SceneView without = FitView({scene}, 640, 360);
  Wire string{.points = Eigen::Matrix3Xd(3, 2), .in_view = false};
  string.points << 0, 0, 0, 0, -0.2, 5;
  scene.wires = {string};
  EXPECT_TRUE(FitView({scene}, 640, 360).camera_from_lab.isApprox(without.camera_from_lab));
  EXPECT_FALSE(Same(DrawScene(scene, without), DrawScene(Wound(3, 5), without)));
  scene.wires[0].in_view = true;
  EXPECT_FALSE(FitView({scene}, 640, 360).camera_from_lab.isApprox(without.camera_from_lab));
}

}  // namespace
}  // namespace tendril
