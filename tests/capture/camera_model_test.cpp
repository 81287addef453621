// capture/rig/camera_model.h: projection and its inverse, against each other, OpenCV's and where they end.
#include "capture/rig/camera_model.h"

#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <random>

namespace tendril {
namespace {

Camera Plain() {
  Camera camera;
  camera.name = "c";
  camera.width_px = 1280;
  camera.height_px = 1024;
  camera.focal_x_px = 900;
  camera.focal_y_px = 905;
  camera.center_x_px = 631;
  camera.center_y_px = 517;
  return camera;
}

Camera Brown(std::array<double, 5> k) {
  Camera camera = Plain();
  camera.distortion = Distortion::kBrown;
  camera.coefficients = k;
  return camera;
}

Camera Fisheye(std::array<double, 5> k) {
  Camera camera = Plain();
  camera.focal_x_px = 470;
  camera.focal_y_px = 471;
  camera.distortion = Distortion::kEquidistant;
  camera.coefficients = k;
  return camera;
}

std::vector<Camera> Lenses() {
  return {Plain(), Brown({-0.28, 0.09, 0.0012, -0.0008, -0.01}), Brown({0.2, -0.05, -0.003, 0.002, 0.0}),
          Fisheye({-0.013211, -0.00988947, 0.0121051, -0.00452971}),
          Fisheye({0.000221074, -0.0302259, 0.0280996, -0.00926951})};
}

TEST(CameraModel, RayOfPixelUndoesProjectionOverTheWholePicture) {
  for (const Camera& camera : Lenses()) {
    int seen = 0;
    for (int v = 0; v < camera.height_px; v += 73) {
      for (int u = 0; u < camera.width_px; u += 61) {
        const auto ray = RayOfPixel(camera, {u, v});
        const double bent = std::hypot((u - camera.center_x_px) / camera.focal_x_px,
                                       (v - camera.center_y_px) / camera.focal_y_px);
        if (camera.distortion == Distortion::kEquidistant && bent > 1.4)
          continue;  // near 90 degrees and beyond
        ASSERT_TRUE(ray.has_value()) << u << " " << v;
        EXPECT_NEAR(ray->norm(), 1, 1e-15);
        const Eigen::Vector2d again = ProjectInCamera<double>(camera, *ray);
        EXPECT_LT((again - Eigen::Vector2d(u, v)).norm(), 1e-12 * camera.focal_x_px * 2) << u << " " << v;
        ++seen;
      }
    }
    EXPECT_GT(seen, 200);
  }
}

TEST(CameraModel, AgreesWithOpenCv) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> across(-0.6, 0.6);
  for (const Camera& camera : Lenses()) {
    const cv::Matx33d k(camera.focal_x_px, 0, camera.center_x_px, 0, camera.focal_y_px, camera.center_y_px, 0,
                        0, 1);
    for (int i = 0; i < 50; ++i) {
      const Eigen::Vector3d p(across(random), across(random), 1);
      std::vector<cv::Point3d> object{{p.x(), p.y(), p.z()}};
      std::vector<cv::Point2d> image;
      const auto& c = camera.coefficients;
      const cv::Vec3d none(0, 0, 0);
      if (camera.distortion == Distortion::kEquidistant) {
        cv::fisheye::projectPoints(object, image, none, none, k, cv::Vec4d(c[0], c[1], c[2], c[3]));
      } else {
        cv::projectPoints(object, none, none, k, std::vector<double>(c.begin(), c.end()), image);
      }
      const auto ours = Project(camera, p);
      ASSERT_TRUE(ours.has_value());
      EXPECT_NEAR(ours->x(), image[0].x, 1e-9);
      EXPECT_NEAR(ours->y(), image[0].y, 1e-9);
    }
  }
}

TEST(CameraModel, NothingIsSeenBehindOrBesideTheCamera) {
  for (const Camera& camera : Lenses()) {
    EXPECT_FALSE(Project(camera, {0, 0, -1}).has_value());
    EXPECT_FALSE(Project(camera, {0.1, 0, 0}).has_value());
    EXPECT_FALSE(Project(camera, {0, 0, 0}).has_value());
  }
}

TEST(CameraModel, ThePoseMovesPointsFirst) {
  Camera camera = Plain();
  camera.camera_from_lab = Eigen::Translation3d(0, 0, 2) * Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX());
  const auto pixel = Project(camera, {0.1, 0.2, 0.5});  // in the camera: (0.1, -0.2, 1.5)
  ASSERT_TRUE(pixel.has_value());
  EXPECT_NEAR(pixel->x(), 631 + 900 * 0.1 / 1.5, 1e-12);
  EXPECT_NEAR(pixel->y(), 517 - 905 * 0.2 / 1.5, 1e-12);
}

// Barrel distortion r (1 - 0.2 r^2) turns back at r = sqrt(5/3), where it reaches 2/3 sqrt(5/3).
TEST(CameraModel, RefusesWhereTheDistortionFoldsOver) {
  const Camera camera = Brown({-0.2, 0, 0, 0, 0});
  const double turn = std::sqrt(5.0 / 3.0);
  const double reach = 2.0 / 3.0 * turn;
  const auto at = [&](double bent) {
    return RayOfPixel(camera, {631 + 900 * bent * std::cos(0.3), 517 + 905 * bent * std::sin(0.3)});
  };
  const auto near_turn = at(reach * (1 - 1e-6));
  ASSERT_TRUE(near_turn.has_value());
  EXPECT_NEAR(near_turn->hnormalized().norm(), turn, 3e-3 * turn);
  EXPECT_LT(near_turn->hnormalized().norm(), turn);
  EXPECT_FALSE(at(reach * 1.0001).has_value());
  EXPECT_FALSE(at(5).has_value());
  EXPECT_TRUE(Project(camera, {turn * 0.999, 0, 1}).has_value());
  EXPECT_FALSE(Project(camera, {turn * 1.001, 0, 1}).has_value());
  EXPECT_FALSE(Project(camera, {3, 0, 1}).has_value());  // would fold back into the picture
}

// theta (1 - theta^2 / 3) turns back at theta = 1, where it reaches 2/3.
TEST(CameraModel, RefusesWhereAFisheyeFoldsOver) {
  const Camera camera = Fisheye({-1.0 / 3.0, 0, 0, 0, 0});
  const auto at = [&](double bent) { return RayOfPixel(camera, {631 + 470 * bent, 517}); };
  const auto inside = at(2.0 / 3.0 * (1 - 1e-8));
  ASSERT_TRUE(inside.has_value());
  EXPECT_NEAR(std::atan2(inside->x(), inside->z()), 1.0, 1e-3);
  EXPECT_FALSE(at(2.0 / 3.0 * 1.0001).has_value());
  EXPECT_FALSE(Project(camera, {std::tan(1.001), 0, 1}).has_value());
  EXPECT_FALSE(
      RayOfPixel(Fisheye({}), {631 + 470 * 1.58, 517}).has_value());  // beside the camera: 90.5 degrees
}

TEST(CameraModel, BadPixelsHaveNoRay) {
  for (const Camera& camera : Lenses()) {
    EXPECT_FALSE(RayOfPixel(camera, {std::nan(""), 3}).has_value());
    EXPECT_FALSE(RayOfPixel(camera, {INFINITY, 3}).has_value());
  }
}

TEST(CameraModel, TheCentreIsExact) {
  for (const Camera& camera : Lenses()) {
    const auto ray = RayOfPixel(camera, {631, 517});
    ASSERT_TRUE(ray.has_value());
    EXPECT_EQ(*ray, Eigen::Vector3d(0, 0, 1));
  }
}

}  // namespace
}  // namespace tendril
