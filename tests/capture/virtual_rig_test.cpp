// capture/rig/virtual_rig.h: the tentacles are in every picture at every pull, finely enough for their tags;
// the example rig is the one it makes.
#include "capture/rig/virtual_rig.h"

#include <gtest/gtest.h>

#include <cmath>

#include "capture/rig/virtual_truth.h"

namespace tendril {
namespace {

using Vector3 = Eigen::Vector3d;

TEST(VirtualRig, HoldsEveryTentacleAtEveryPullFinelyEnough) {
  for (const int tentacles : {1, 2, 3, 4}) {
    Gripper gripper;
    gripper.tentacles = tentacles;
    const auto rig = VirtualRig(TentacleDesign{}, gripper);
    ASSERT_TRUE(rig.ok()) << rig.error().message;
    ASSERT_EQ(rig.value().cameras.size(), 2U);
    std::mt19937_64 random(4);
    const auto truth = DrawTruth({}, gripper, {0.95, 1, 1}, {}, {}, {}, random);
    for (const double time : {0.0, 4.0, 11.0}) {
      const auto shape = TrueShapeAt(truth.value(), time);
      for (const Camera& camera : rig.value().cameras) {
        for (const TrueTentacle& t : shape.value().tentacles) {
          for (Eigen::Index i = 0; i < t.centerline.points.cols(); ++i) {
            const Vector3 p = t.centerline.points.col(i);
            const auto pixel = Project(camera, p);
            ASSERT_TRUE(pixel.has_value());
            EXPECT_GT(pixel->x(), 0);
            EXPECT_GT(pixel->y(), 0);
            EXPECT_LT(pixel->x(), camera.width_px - 1);
            EXPECT_LT(pixel->y(), camera.height_px - 1);
            // A millimetre across the line of sight, in pixels.
            const Vector3 across = camera.camera_from_lab.linear().row(0).transpose() * 1e-3;
            EXPECT_GT((*Project(camera, p + across) - *pixel).norm(), 1 / 0.32);
          }
        }
      }
    }
  }
}

TEST(VirtualRig, TheExampleRigIsTheOneItMakes) {
  const auto example = ReadRig(std::string(TENDRIL_SOURCE_DIR) + "/examples/rigs/two_cameras.toml");
  ASSERT_TRUE(example.ok()) << example.error().message;
  Gripper gripper;
  gripper.tentacles = 2;
  const auto made = VirtualRig(TentacleDesign{}, gripper);
  ASSERT_EQ(example.value().cameras.size(), made.value().cameras.size());
  for (std::size_t i = 0; i < 2; ++i) {
    const Camera& a = example.value().cameras[i];
    const Camera& b = made.value().cameras[i];
    EXPECT_EQ(a.width_px, b.width_px);
    EXPECT_EQ(a.focal_x_px, b.focal_x_px);
    EXPECT_EQ(a.coefficients, b.coefficients);
    EXPECT_LT((a.camera_from_lab.matrix() - b.camera_from_lab.matrix()).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(VirtualRig, BadOptionsAreNamed) {
  const auto message = [](const VirtualRigOptions& options) {
    const auto rig = VirtualRig(TentacleDesign{}, Gripper{}, options);
    return rig.ok() ? std::string() : rig.error().message;
  };
  EXPECT_NE(message({.views = {}, .distance = 0.1}).find("0.1 m away"), std::string::npos);
  EXPECT_NE(message({.views = {}, .pixel_pitch = 1e-6}).find("8192"), std::string::npos);
  EXPECT_FALSE(message({.views = {}, .largest_pull = 1.5}).empty());
}

}  // namespace
}  // namespace tendril
