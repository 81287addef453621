// calibrate/rig_from_tags.h: a made-up rig of three fisheye cameras comes back from the tags that it would
// see.
#include "calibrate/rig_from_tags.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "capture/track/tag_pose.h"

namespace tendril {
namespace {

constexpr double kBorder = 0.1;

std::vector<Camera> Truth() {
  std::vector<Camera> cameras(3);
  const double along[3] = {0, 0.2, 0.5};
  const double turn[3] = {0, 0.2, -0.3};
  for (size_t i = 0; i < 3; ++i) {
    Camera& c = cameras[i];
    c.name = "c" + std::to_string(i);
    c.width_px = 1280;
    c.height_px = 1024;
    c.focal_x_px = c.focal_y_px = 470;
    c.center_x_px = 640;
    c.center_y_px = 512;
    c.distortion = Distortion::kEquidistant;
    c.coefficients = {-0.013, -0.0099, 0.012, -0.0045, 0};
    Eigen::Isometry3d lab_from_camera = Eigen::Isometry3d::Identity();
    lab_from_camera.translation() = Eigen::Vector3d(along[i], 0.1 * along[i], 0);
    lab_from_camera.linear() =
        Eigen::AngleAxisd(turn[i], Eigen::Vector3d(0.2, 1, 0.1).normalized()).toRotationMatrix();
    c.camera_from_lab = lab_from_camera.inverse();
  }
  return cameras;
}

std::vector<TagView> Views(const std::vector<Camera>& cameras, int count, double noise_px, int wrong) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::normal_distribution<double> noise(0, noise_px);
  std::vector<TagView> views;
  for (int i = 0; i < count; ++i) {
    Eigen::Isometry3d lab_from_tag = Eigen::Isometry3d::Identity();
    lab_from_tag.translation() =
        Eigen::Vector3d(0.25 + 0.5 * unit(random), 0.4 * unit(random), 1.3 + 0.4 * unit(random));
    lab_from_tag.linear() =
        Eigen::AngleAxisd(0.9 * unit(random),
                          Eigen::Vector3d(unit(random), unit(random), unit(random)).normalized())
            .toRotationMatrix();
    for (size_t c = 0; c < cameras.size(); ++c) {
      TagView view{.stamp = i / 4, .tag = i % 4, .camera = static_cast<int>(c), .corners_px = {}};
      for (int k = 0; k < 4; ++k) {
        const auto p = Project(cameras[c], lab_from_tag * Eigen::Vector3d(TagCorners3d(kBorder).col(k)));
        if (!p) return views;
        view.corners_px.col(k) = *p + Eigen::Vector2d(noise(random), noise(random));
      }
      if (i < wrong && c == 1) view.corners_px.array() += 40;  // another tag taken for this one
      views.push_back(view);
    }
  }
  return views;
}

std::vector<Camera> Blind(std::vector<Camera> cameras) {
  for (size_t i = 1; i < cameras.size(); ++i) cameras[i].camera_from_lab = Eigen::Isometry3d::Identity();
  return cameras;
}

TEST(FitRigFromTags, FindsTheRigExactlyWithoutNoise) {
  const auto truth = Truth();
  const auto fit = FitRigFromTags(Blind(truth), Views(truth, 40, 0, 0), {.border = kBorder});
  ASSERT_TRUE(fit.ok()) << fit.error().message;
  EXPECT_TRUE(fit.value().converged);
  EXPECT_EQ(fit.value().tags, 40);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_LT((fit.value().cameras[i].camera_from_lab.matrix() - truth[i].camera_from_lab.matrix()).norm(),
              1e-6);
  }
}

TEST(FitRigFromTags, NoiseAndAFewWrongTagsDoLittle) {
  const auto truth = Truth();
  const auto fit = FitRigFromTags(Blind(truth), Views(truth, 200, 0.1, 6), {.border = kBorder});
  ASSERT_TRUE(fit.ok()) << fit.error().message;
  for (size_t i = 0; i < 3; ++i) {
    const Eigen::Isometry3d off = fit.value().cameras[i].camera_from_lab * truth[i].camera_from_lab.inverse();
    EXPECT_LT(off.translation().norm(), 0.002);
    EXPECT_LT(Eigen::AngleAxisd(off.linear()).angle(), 0.002);
  }
}

TEST(FitRigFromTags, SaysWhichCameraCannotBePlaced) {
  const auto truth = Truth();
  auto views = Views(truth, 40, 0, 0);
  std::erase_if(views, [](const TagView& v) { return v.camera == 2; });
  const auto fit = FitRigFromTags(Blind(truth), views, {.border = kBorder});
  ASSERT_FALSE(fit.ok());
  EXPECT_EQ(fit.error().kind, ErrorKind::kUnreachable);
  EXPECT_THAT(fit.error().message, testing::HasSubstr("camera 2 (c2)"));
  EXPECT_EQ(FitRigFromTags(truth, views, {}).error().kind, ErrorKind::kBadInput);
  EXPECT_EQ(FitRigFromTags({truth[0]}, views, {.border = kBorder}).error().kind, ErrorKind::kBadInput);
  views[0].camera = 7;
  EXPECT_EQ(FitRigFromTags(truth, views, {.border = kBorder}).error().kind, ErrorKind::kBadInput);
  EXPECT_FALSE(FitRigFromTags(truth, {}, {.border = kBorder}).ok());
}

}  // namespace
}  // namespace tendril
