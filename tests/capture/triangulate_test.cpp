// capture/track/tag_pose.h and triangulate.h, against poses and points that were projected.
#include "capture/track/triangulate.h"

#include <gtest/gtest.h>

#include <random>

#include "capture/track/tag_pose.h"

namespace tendril {
namespace {

Camera LookingAt(const Eigen::Vector3d& from, const Eigen::Vector3d& at, Distortion distortion) {
  Camera camera;
  camera.width_px = 1280;
  camera.height_px = 1024;
  camera.focal_x_px = camera.focal_y_px = 1000;
  camera.center_x_px = 639.5;
  camera.center_y_px = 511.5;
  camera.distortion = distortion;
  if (distortion == Distortion::kBrown) camera.coefficients = {-0.2, 0.05, 0.001, -0.0005, 0};
  if (distortion == Distortion::kEquidistant) camera.coefficients = {-0.013, -0.0099, 0.012, -0.0045, 0};
  const Eigen::Vector3d z = (at - from).normalized();
  const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Isometry3d lab_from_camera = Eigen::Isometry3d::Identity();
  lab_from_camera.linear() << x, z.cross(x), z;
  lab_from_camera.translation() = from;
  camera.camera_from_lab = lab_from_camera.inverse();
  return camera;
}

std::vector<Camera> Three() {
  return {LookingAt({1, 0.2, 0}, {0, 0, 0}, Distortion::kBrown),
          LookingAt({0.6, -0.9, 0.3}, {0, 0, 0}, Distortion::kNone),
          LookingAt({-0.8, -0.7, -0.2}, {0, 0, 0}, Distortion::kEquidistant)};
}

std::vector<Sighting> Seen(const std::vector<Camera>& cameras, const Eigen::Vector3d& p) {
  std::vector<Sighting> seen;
  for (size_t i = 0; i < cameras.size(); ++i) seen.push_back({static_cast<int>(i), *Project(cameras[i], p)});
  return seen;
}

TEST(Triangulate, FindsAProjectedPointExactly) {
  const auto cameras = Three();
  for (const Eigen::Vector3d& p : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.1, -0.15, 0.2)}) {
    const auto point = Triangulate(cameras, Seen(cameras, p));
    ASSERT_TRUE(point.has_value());
    EXPECT_LT((point->in_lab - p).norm(), 1e-10);
    EXPECT_LT(point->rms_px, 1e-8);
  }
}

// The scatter of many noisy solutions is what the covariance says.
TEST(Triangulate, TheCovarianceIsTheScatterOfNoisySolutions) {
  const auto cameras = Three();
  const Eigen::Vector3d truth(0.05, 0.1, -0.1);
  std::mt19937 random(4);
  std::normal_distribution<double> noise(0, 0.4);
  constexpr int kTrials = 4000;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d stated = Eigen::Matrix3d::Zero();
  double chi2 = 0;
  for (int i = 0; i < kTrials; ++i) {
    auto seen = Seen(cameras, truth);
    for (Sighting& s : seen) s.pixel += Eigen::Vector2d(noise(random), noise(random));
    const auto point = Triangulate(cameras, seen, 0.4);
    ASSERT_TRUE(point.has_value());
    scatter += (point->in_lab - truth) * (point->in_lab - truth).transpose() / kTrials;
    stated = point->covariance;
    for (const auto& r : point->residuals) chi2 += r.squaredNorm() / (0.4 * 0.4);
  }
  // Standard error of a variance from 4000: 2.2 %.
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(scatter(i, i) / stated(i, i), 1, 0.1);
  EXPECT_NEAR(chi2 / kTrials, 6 - 3, 0.1);  // six pixels, three unknowns
}

TEST(Triangulate, SaysWhenItCannot) {
  const auto cameras = Three();
  auto seen = Seen(cameras, {0, 0, 0});
  EXPECT_FALSE(Triangulate(cameras, std::vector<Sighting>{seen[0]}).has_value());
  EXPECT_FALSE(Triangulate(cameras, {}).has_value());
  EXPECT_FALSE(Triangulate(cameras, std::vector<Sighting>{seen[0], seen[0]}).has_value());  // one ray, twice
  seen[1].pixel.x() = std::nan("");
  EXPECT_FALSE(Triangulate(cameras, seen).has_value());
  // Rays that meet behind the cameras.
  const std::vector<Camera> pair = {LookingAt({0, 0, 0}, {1, 0, 0}, Distortion::kNone),
                                    LookingAt({0, 0.1, 0}, {1, 0.1, 0}, Distortion::kNone)};
  const std::vector<Sighting> apart = {{0, {600, 511.5}}, {1, {680, 511.5}}};
  const std::vector<Sighting> crossing = {{0, {680, 511.5}}, {1, {600, 511.5}}};
  EXPECT_NE(Triangulate(pair, apart).has_value(), Triangulate(pair, crossing).has_value());
}

TEST(TagPoses, OneOfTheTwoIsTheTruePose) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (const Camera& camera : Three()) {
    for (int i = 0; i < 100; ++i) {
      Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
      truth.linear() = (Eigen::AngleAxisd(M_PI * unit(random), Eigen::Vector3d::UnitZ()) *
                        Eigen::AngleAxisd(1.2 * unit(random),
                                          Eigen::Vector3d(unit(random), unit(random), 0.01).normalized()))
                           .toRotationMatrix();
      truth.translation() = Eigen::Vector3d(0.1 * unit(random), 0.1 * unit(random), 0.8 + 0.3 * unit(random));
      Eigen::Matrix<double, 2, 4> seen;
      for (int c = 0; c < 4; ++c) {
        seen.col(c) = ProjectInCamera<double>(camera, truth * Eigen::Vector3d(TagCorners3d(0.0064).col(c)));
      }
      const auto poses = TagPoses(camera, seen, 0.0064);
      ASSERT_FALSE(poses.empty());
      EXPECT_LT((poses[0].camera_from_tag.translation() - truth.translation()).norm(), 1e-6);
      EXPECT_LT((poses[0].camera_from_tag.linear() - truth.linear()).norm(), 1e-4);
      EXPECT_LT(poses[0].rms_px, 1e-4);
      EXPECT_TRUE(poses.size() == 1 || poses[1].rms_px >= poses[0].rms_px);
    }
  }
}

TEST(TagPoses, NonsenseHasNoPose) {
  const Camera camera = Three()[0];
  Eigen::Matrix<double, 2, 4> nan = Eigen::Matrix<double, 2, 4>::Constant(std::nan(""));
  EXPECT_TRUE(TagPoses(camera, nan, 0.01).empty());
  for (const TagPose& pose : TagPoses(camera, Eigen::Matrix<double, 2, 4>::Constant(500), 0.01)) {
    EXPECT_TRUE(pose.camera_from_tag.matrix().allFinite());
  }
}

}  // namespace
}  // namespace tendril
