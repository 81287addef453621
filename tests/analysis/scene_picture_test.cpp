// analysis/study/scene_picture.h and what it is made of: sizes by the pinhole camera, what hides what, smooth
// joints, everything in view, labels apart, and scenes that are hardly there.
#include "analysis/study/scene_picture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/core.hpp>
#include <random>

#include "analysis/study/scene_backdrop.h"
#include "analysis/study/scene_labels.h"
#include "analysis/study/scene_pieces.h"
#include "analysis/study/scene_raster.h"
#include "tests/support/scene_things.h"

namespace tendril {
namespace {

using namespace testing_support;

TEST(DrawScene, ASpheresOutlineHasThePinholesRadius) {
  for (const double distance : {0.5, 2.0, 50.0}) {
    const double radius = 0.2 * distance;
    const SceneView view = FromTheFront(distance);
    ScenePicture scene{.time = kNaN};
    const cv::Mat without = DrawScene(scene, view);
    scene.objects = {Sphere(Eigen::Vector3d::Zero(), radius)};
    const cv::Mat with = DrawScene(scene, view);
    int across = 0, down = 0;
    for (int x = 0; x < view.width_px; ++x)
      across += with.at<cv::Vec3b>(240, x) != without.at<cv::Vec3b>(240, x);
    for (int y = 0; y < view.height_px; ++y)
      down += with.at<cv::Vec3b>(y, 320) != without.at<cv::Vec3b>(y, 320);
    const double outline = view.focal_px * radius / std::sqrt(distance * distance - radius * radius);
    EXPECT_NEAR(0.5 * across, outline, 1) << distance;
    EXPECT_NEAR(0.5 * down, outline, 1) << distance;
  }
}

TEST(DrawScene, TheNearerTubeHidesTheFarther) {
  const SceneView view = FromTheFront(1);
  const auto middle_of = [&](double across_at) {
    const ScenePicture scene{.tubes = {Straight("a", {-0.2, across_at, 0}, {0.2, across_at, 0}, 0.02),
                                       Straight("b", {0, 0, -0.2}, {0, 0, 0.2}, 0.02)}};
    return DrawScene(scene, view).at<cv::Vec3b>(240, 320);
  };
  const cv::Vec3b a_in_front = middle_of(-0.1), a_behind = middle_of(0.1);
  EXPECT_GT(a_in_front[0], a_in_front[2]);  // blue
  EXPECT_GT(a_behind[2], a_behind[0]);      // orange
}

TEST(DrawScene, OrderOfDeclarationChangesNothing) {
  ScenePicture scene = Wound(10, 3);
  const SceneView view = FitView({scene}, 640, 360);
  const cv::Mat first = DrawScene(scene, view);
  std::reverse(scene.tubes.begin(), scene.tubes.end());
  std::reverse(scene.objects.begin(), scene.objects.end());
  EXPECT_TRUE(Same(first, DrawScene(scene, view)));
}

TEST(ScenePainter, GivesTheSameBytesAgainWhateverItDrewBefore) {
  const ScenePicture scene = Wound(4, 1);
  const SceneView view = FitView({scene}, 640, 360);
  ScenePainter painter(view);
  const cv::Mat first = painter.Draw(scene);
  painter.Draw(Wound(7, 2));
  EXPECT_TRUE(Same(first, painter.Draw(scene)));
  EXPECT_TRUE(Same(first, DrawScene(scene, view)));
}

TEST(FitView, EverythingOfEveryPictureIsInsideAndSomethingReachesTheSide) {
  for (unsigned seed = 0; seed < 6; ++seed) {
    const std::vector<ScenePicture> pictures = {Wound(1, seed), Wound(8, seed + 100)};
    const int width = seed % 2 == 0 ? 640 : 500, height = seed % 3 == 0 ? 360 : 500;
    const SceneView view = FitView(pictures, width, height);
    const PictureRoom room = RoomBesideLabels(width, height);
    double least = 1e9;
    for (const ScenePicture& picture : pictures) {
      std::vector<ScenePiece> pieces;
      for (const Tube& tube : picture.tubes) AddTube(tube, 0, view, 0, pieces);
      for (const ShownObject& object : picture.objects) AddObject(object, 0, view, 0, pieces);
      SceneRaster raster;
      CastRays(pieces, view, raster);
      for (int y = raster.top; y < raster.bottom; ++y) {
        for (int x = raster.left; x < raster.right; ++x) {
          if (raster.piece[raster.At(x, y)] < 0) continue;
          for (const double spare : {x - room.left, room.right - x, y - room.top, room.bottom - y}) {
            EXPECT_GE(spare, -1) << "seed " << seed << " at " << x << ", " << y;
            least = std::min(least, spare);
          }
        }
      }
    }
    EXPECT_LT(least, 4) << "seed " << seed;
  }
}

TEST(FitView, LooksTheSameAtScenesThatDifferOnlyInSize) {
  ScenePicture scene = Wound(3, 5);
  const SceneView view = FitView({scene}, 640, 360);
  for (const double scale : {1e-3, 100.0}) {
    ScenePicture scaled = scene;
    for (Tube& tube : scaled.tubes) {
      tube.points *= scale;
      tube.radius *= scale;
    }
    for (ShownObject& object : scaled.objects) {
      object.pose.translation() *= scale;
      for (Primitive& part : object.shape) {
        part.radius *= scale;
        part.half *= scale;
      }
    }
    const SceneView there = FitView({scaled}, 640, 360);
    for (int i = 0; i <= 60; i += 20) {
      const auto at = PixelOf(view, scene.tubes[0].points.col(i));
      const auto scaled_at = PixelOf(there, scaled.tubes[0].points.col(i));
      ASSERT_TRUE(at && scaled_at);
      EXPECT_LT((*at - *scaled_at).norm(), 1e-6) << scale;
    }
  }
}

// Each picture's nearest view would be jerky where rods go fast.
TEST(FollowViews, HoldsEveryPictureAndGoesSlowly) {
  constexpr int kFrames = 121, kWidth = 640, kHeight = 360;
  const ScenePicture wound = Wound(4, 7);
  std::vector<ScenePicture> pictures(kFrames, wound);
  const Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(kFrames, 0, 12);
  for (int f = 0; f < kFrames; ++f) {
    // Drawn together at 4 s, in one frame; then carried away.
    for (Tube& tube : pictures[static_cast<std::size_t>(f)].tubes) {
      if (time[f] > 4) tube.points.row(2) *= 0.3;
      tube.points.row(0).array() += std::max(0.0, 0.1 * (time[f] - 8));
    }
    pictures[static_cast<std::size_t>(f)].objects.clear();
  }
  const std::vector<SceneView> views = FollowViews(pictures, time, kWidth, kHeight);
  const PictureRoom room = RoomBesideLabels(kWidth, kHeight);
  ASSERT_EQ(views.size(), pictures.size());
  const auto eye_of = [&](int f) -> Eigen::Vector3d {
    return views[static_cast<std::size_t>(f)].camera_from_lab.inverse().translation();
  };
  for (int f = 0; f < kFrames; ++f) {
    for (const Tube& tube : pictures[static_cast<std::size_t>(f)].tubes) {
      for (Eigen::Index i = 0; i < tube.points.cols(); ++i) {
        const auto at = PixelOf(views[static_cast<std::size_t>(f)], tube.points.col(i));
        ASSERT_TRUE(at);
        EXPECT_TRUE(at->x() > room.left && at->x() < room.right && at->y() > room.top &&
                    at->y() < room.bottom)
            << "frame " << f << " node " << i;
      }
    }
    EXPECT_EQ(views[static_cast<std::size_t>(f)].camera_from_lab.linear(), views[0].camera_from_lab.linear());
    // The jump at 4 s is spread over the 40 frames of a window.
    if (f == 0) continue;
    EXPECT_LT((eye_of(f) - eye_of(f - 1)).norm(), 1.5 / 40 * (eye_of(0) - eye_of(80)).norm() + 0.02);
  }
  EXPECT_LT(DepthOf(views[80], wound.tubes[0].points.col(0)),
            0.8 * DepthOf(views[0], wound.tubes[0].points.col(0)));
}

TEST(FollowViews, OfWhatDoesNotMoveAreTheFixedOne) {
  const ScenePicture scene = Wound(3, 5);
  const SceneView fixed = FitView({scene, scene, scene}, 640, 360);
  for (const SceneView& view : FollowViews({scene, scene, scene}, Eigen::Vector3d(0, 1, 5), 640, 360)) {
    EXPECT_LT((view.camera_from_lab.matrix() - fixed.camera_from_lab.matrix()).norm(), 1e-12);
  }
}

TEST(NormalAt, NeighboursAgreeAtTheirJointAndFollowTheTorus) {
  constexpr double kRing = 0.1, kRadius = 0.02;
  const Tube arc = Arc(kRing, kRadius, 61);
  std::vector<ScenePiece> pieces;
  AddTube(arc, 0, FromTheFront(1), 0, pieces);
  std::erase_if(pieces, [](const ScenePiece& p) { return p.kind != ScenePiece::Kind::kCone; });
  ASSERT_EQ(pieces.size(), 60u);
  for (std::size_t i = 1; i < pieces.size(); ++i) {
    const Eigen::Vector3d outward = pieces[i].a.normalized();
    for (const double around : {0.0, 0.7, 1.9, 3.0}) {
      const Eigen::Vector3d normal = std::cos(around) * outward + std::sin(around) * Eigen::Vector3d::UnitY();
      const Eigen::Vector3d point = pieces[i].a + kRadius * normal;
      EXPECT_LT((NormalAt(pieces[i - 1], point) - normal).norm(), 1e-6);
      EXPECT_LT((NormalAt(pieces[i], point) - normal).norm(), 1e-6);
    }
    if (i + 1 == pieces.size()) break;  // an end goes straight on
    // Between joints the blended tangent is the circle's.
    const Eigen::Vector3d between = 0.5 * (pieces[i].a + pieces[i].b);
    const Eigen::Vector3d normal = between.normalized();
    EXPECT_LT((NormalAt(pieces[i], between + kRadius * normal) - normal).norm(), 1e-9);
  }
}

TEST(CastRays, ABentTubeHasNoCracksAndTheDepthOfATorus) {
  constexpr double kRing = 0.1, kRadius = 0.02, kDistance = 1;
  const SceneView view = FromTheFront(kDistance, 640, 640, 2000);
  std::vector<ScenePiece> pieces;
  AddTube(Arc(kRing, kRadius, 91), 0, view, 0, pieces);
  SceneRaster raster;
  CastRays(pieces, view, raster);
  int seen = 0;
  for (int y = raster.top; y < raster.bottom; ++y) {
    for (int x = raster.left; x < raster.right; ++x) {
      const double depth = raster.depth[raster.At(x, y)];
      const Eigen::Vector3d slopes((x - view.center_x_px) / view.focal_px,
                                   (y - view.center_y_px) / view.focal_px, 1);
      // Where the ray is when it is at the ring's distance from the camera.
      const double ring = kDistance * slopes.head<2>().norm();
      const double angle = std::atan2(-slopes.y(), slopes.x());
      if (angle < -0.5 * std::numbers::pi + 0.02 && angle > -std::numbers::pi) continue;  // the arc's gap
      if (angle < 0 && angle > -0.5 * std::numbers::pi) continue;
      if (std::abs(ring - kRing) > 0.9 * kRadius) continue;
      ASSERT_TRUE(std::isfinite(depth)) << x << ", " << y;
      const Eigen::Vector3d at = slopes * depth;
      const double from_ring = std::hypot(at.head<2>().norm() - kRing, at.z() - kDistance);
      EXPECT_NEAR(from_ring, kRadius, 0.003 * kRadius) << x << ", " << y;
      ++seen;
    }
  }
  EXPECT_GT(seen, 20000);
}

TEST(DrawScene, DrawsWhatIsHardlyThere) {
  const Eigen::Vector3d end(0, 0, 0.3);
  Tube torn = Straight("torn", Eigen::Vector3d::Zero(), end, 0.01);
  torn.points(1, 4) = kNaN;
  torn.points(0, 7) = std::numeric_limits<double>::infinity();
  torn.points(2, 9) = 1e300;
  Tube still = Straight("still", end, end, 0.01);
  Tube bare = Straight("bare", Eigen::Vector3d::Zero(), end, 0.01);
  bare.radius.resize(0);
  Tube broken = Straight("broken", Eigen::Vector3d::Zero(), end, kNaN);
  Tube back = Straight("back", Eigen::Vector3d::Zero(), end, 0.01, 3);
  back.points.col(2) = back.points.col(0);
  const std::vector<std::vector<Tube>> scenes = {
      {},
      {Tube{}},
      {Straight("one node", Eigen::Vector3d::Zero(), end, 0.01, 1)},
      {Straight("two", Eigen::Vector3d::Zero(), end, 0.01, 2)},
      {Straight("no extent", Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), 0)},
      {Straight("long", {0, 0, 0}, {100, 0, 0}, 0.02)},
      {Straight("short", {0, 0, 0}, {0, 0, 1e-3}, 1e-4)},
      {Straight("far", {1e5, 1e5, 0}, {1e5, 1e5, 0.3}, 0.01)},
      {torn},
      {still},
      {bare},
      {broken},
      {back},
      {torn, still, bare, broken, back}};
  for (const std::vector<Tube>& tubes : scenes) {
    const ScenePicture scene{
        .title = "extreme", .tubes = tubes, .objects = {Sphere({kNaN, 0, 0}, 1), {}}, .wires = {{}}};
    const SceneView view = FitView({scene}, 320, 180);
    EXPECT_TRUE(view.camera_from_lab.matrix().allFinite());
    EXPECT_EQ(DrawScene(scene, view).size(), cv::Size(320, 180)) << (tubes.empty() ? "none" : tubes[0].name);
    const Eigen::Vector2d middle = PixelOf(view, view.middle).value_or(Eigen::Vector2d(-1, -1));
    EXPECT_TRUE(middle.x() > 0 && middle.x() < 320 && middle.y() > 0 && middle.y() < 180);
  }
}

TEST(DrawScene, AThinRodIsDrawnWithoutGaps) {
  const ScenePicture scene{.tubes = {Straight("wire", {-100, 0, 30}, {100, 0, -30}, 1e-4)}};
  const SceneView view = FromTheFront(400);
  const cv::Mat with = DrawScene(scene, view), without = DrawScene({}, view);
  const int left = static_cast<int>(PixelOf(view, {-100, 0, 30})->x()) + 2;
  const int right = static_cast<int>(PixelOf(view, {100, 0, -30})->x()) - 2;
  for (int x = std::max(left, 200); x < right; ++x) {  // right of the labels
    int changed = 0;
    for (int y = 0; y < view.height_px; ++y)
      changed += with.at<cv::Vec3b>(y, x) != without.at<cv::Vec3b>(y, x);
    EXPECT_GE(changed, 1) << x;
    EXPECT_LE(changed, 4) << x;
  }
}

TEST(DrawScene, WhatIsBehindTheCameraIsLeftOut) {
  const SceneView view = FromTheFront(1);
  const ScenePicture none{.time = kNaN};
  ScenePicture scene = none;
  scene.tubes = {Straight("", {0, -3, 0}, {0, -1.5, 0}, 0.05)};
  scene.objects = {Sphere({0, -1, 0}, 0.1)};  // about the camera
  EXPECT_TRUE(Same(DrawScene(scene, view), DrawScene(none, view)));
  scene.tubes = {Straight("", {0, -2, 0}, {0, 2, 0}, 0.05)};  // through it
  EXPECT_FALSE(Same(DrawScene(scene, view), DrawScene(none, view)));
}

TEST(LayOutLabels, BoxesAreInsideApartAndHoldAllInk) {
  for (const int width : {64, 320, 1280, 1600}) {
    for (const int height : {64, 240, 720, 1000}) {
      for (const int lines : {0, 2, 60}) {
        ScenePicture scene = Wound(8, 1);
        scene.title = lines == 2
                          ? "a title of more words than there is room for in any column of a picture at all"
                          : "one" + std::string(200, 'W') + "\xC3\xA9\n";
        scene.lines.assign(static_cast<std::size_t>(lines), "a line of text that tells of 3.14159 turns");
        const SceneView view = FitView({scene}, width, height);
        std::vector<std::string> names;
        for (const Tube& tube : scene.tubes) names.push_back(tube.name);
        const auto labels =
            LayOutLabels(scene, view, names, std::vector<cv::Scalar>(names.size(), cv::Scalar(9, 9, 9)), 0.1);
        const cv::Rect whole(0, 0, width, height);
        for (std::size_t i = 0; i < labels.size(); ++i) {
          EXPECT_EQ(labels[i].box & whole, labels[i].box) << labels[i].text;
          for (std::size_t j = 0; j < i; ++j) EXPECT_TRUE((labels[i].box & labels[j].box).empty());
        }
        cv::Mat canvas(height, width, CV_8UC3, cv::Scalar::all(255));
        DrawLabels(labels, canvas);
        for (const SceneLabel& label : labels) canvas(label.box).setTo(cv::Scalar::all(255));
        EXPECT_EQ(cv::norm(canvas, cv::Mat(height, width, CV_8UC3, cv::Scalar::all(255)), cv::NORM_INF), 0)
            << width << " x " << height << ", " << lines << " lines";
      }
    }
  }
}

TEST(LayOutLabels, TheBarIsAsLongAsItSays) {
  const SceneView view = FromTheFront(2, 1280, 720, 1000);  // 500 px per metre
  for (const SceneLabel& label : LayOutLabels({}, view, {}, {}, 1)) {
    if (label.kind != SceneLabel::Kind::kBar) continue;
    EXPECT_EQ(label.text, "200 mm");
    EXPECT_DOUBLE_EQ(label.bar_px, 100);
    return;
  }
  FAIL() << "no bar";
}

TEST(RoundLength, IsOneTwoOrFive) {
  EXPECT_DOUBLE_EQ(RoundLength(0.19), 0.1);
  EXPECT_DOUBLE_EQ(RoundLength(4.9), 2);
  EXPECT_DOUBLE_EQ(RoundLength(51), 50);
}

}  // namespace
}  // namespace tendril
