// capture/rig/rig.h: rig files, there and back, and what is said about bad ones.
#include "capture/rig/rig.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tendril {
namespace {

const char kGood[] = R"(name = "bench"
[[camera]]
name = "left"
image_size_px = [1280, 1024]
focal_px = [900, 905.5]
center_px = [631.25, 517]
distortion = "brown"
coefficients = [-0.28, 0.09, 0.0012, -0.0008, -0.01]
position = [0.1, -1.2, -0.3]
rotation_xyzw = [-0.70710678118654752, 0, 0, 0.70710678118654752]
[[camera]]
image_size_px = [640, 480]
focal_px = [500, 500]
center_px = [320, 240]
distortion = "equidistant"
coefficients = [0.01, 0.02, 0.03, 0.04]
position = [0, 0, 0]
rotation_xyzw = [0, 0, 0, 1]
)";

std::string With(const std::string& from, const std::string& to) {
  std::string text = kGood;
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(Rig, ReadsCamerasInOrder) {
  const auto rig = ParseRig(kGood, "rig.toml");
  ASSERT_TRUE(rig.ok()) << rig.error().message;
  ASSERT_EQ(rig.value().cameras.size(), 2u);
  const Camera& left = rig.value().cameras[0];
  EXPECT_EQ(left.name, "left");
  EXPECT_EQ(rig.value().cameras[1].name, "cam1");
  EXPECT_EQ(left.width_px, 1280);
  EXPECT_EQ(left.focal_y_px, 905.5);
  EXPECT_EQ(left.distortion, Distortion::kBrown);
  EXPECT_EQ(left.coefficients[4], -0.01);
  // Turned by -90 degrees about x: the camera looks along the lab's +y, its image's down is the lab's -z.
  const Eigen::Matrix3d lab_from_camera = left.camera_from_lab.linear().transpose();
  EXPECT_LT((lab_from_camera * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitY()).norm(), 1e-12);
  EXPECT_LT((lab_from_camera * Eigen::Vector3d::UnitY() + Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_LT((left.camera_from_lab * Eigen::Vector3d(0.1, -1.2, -0.3)).norm(), 1e-12);
}

TEST(Rig, WhatIsWrittenReadsBack) {
  const auto first = ParseRig(kGood, "rig.toml");
  ASSERT_TRUE(first.ok());
  const auto again = ParseRig(RigToml(first.value()), "again.toml");
  ASSERT_TRUE(again.ok()) << again.error().message << "\n" << RigToml(first.value());
  EXPECT_EQ(again.value().name, "bench");
  for (size_t i = 0; i < 2; ++i) {
    const Camera& a = first.value().cameras[i];
    const Camera& b = again.value().cameras[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.width_px, b.width_px);
    EXPECT_EQ(a.height_px, b.height_px);
    EXPECT_EQ(a.focal_x_px, b.focal_x_px);
    EXPECT_EQ(a.center_y_px, b.center_y_px);
    EXPECT_EQ(a.distortion, b.distortion);
    EXPECT_EQ(a.coefficients, b.coefficients);
    EXPECT_LT((a.camera_from_lab.matrix() - b.camera_from_lab.matrix()).norm(), 1e-15);
  }
}

TEST(Rig, BadFilesAreNamedByFileAndField) {
  const struct {
    std::string text;
    std::string says;
  } cases[] = {
      {With("focal_px = [900, 905.5]", "focal_px = [900]"), "focal_px"},
      {With("focal_px = [900, 905.5]", "focal_px = [-900, 905.5]"), "focal_px"},
      {With("focal_px = [900, 905.5]\n", ""), "focal_px"},
      {With("image_size_px = [1280, 1024]", "image_size_px = [1280.5, 1024]"), "image_size_px"},
      {With("distortion = \"brown\"", "distortion = \"fisheye\""), "distortion"},
      {With("coefficients = [-0.28, 0.09, 0.0012, -0.0008, -0.01]\n", ""), "coefficients"},
      {With("coefficients = [0.01, 0.02, 0.03, 0.04]", "coefficients = [0.01]"), "coefficients"},
      {With("rotation_xyzw = [0, 0, 0, 1]", "rotation_xyzw = [0, 0, 0, 2]"), "rotation_xyzw"},
      {With("rotation_xyzw = [0, 0, 0, 1]", "rotation_xyzw = [0, 0, 1]"), "rotation_xyzw"},
      {With("position = [0, 0, 0]", "positon = [0, 0, 0]"), "position"},
      {"name = \"none\"\n", "[[camera]]"},
      {"name = ", "rig.toml"},
  };
  for (const auto& c : cases) {
    const auto rig = ParseRig(c.text, "rig.toml");
    ASSERT_FALSE(rig.ok()) << c.says;
    EXPECT_EQ(rig.error().kind, ErrorKind::kBadInput);
    EXPECT_THAT(rig.error().message, testing::HasSubstr("rig.toml"));
    EXPECT_THAT(rig.error().message, testing::HasSubstr(c.says));
  }
  EXPECT_EQ(ReadRig("no/such/rig.toml").error().kind, ErrorKind::kNotFound);
}

}  // namespace
}  // namespace tendril
