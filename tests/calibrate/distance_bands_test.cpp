// tests/support/distance_bands.h on drawn cameras: what bench/distance_bands.cpp estimates is what was drawn.
#include "tests/support/distance_bands.h"

#include <gtest/gtest.h>

namespace tendril::testing_support {
namespace {

constexpr double kPictureNs = 33.3e6;
constexpr double kOffset = 0.012;  // s, by which camera 1 is early

// Two cameras 0.2 m apart without any error of their own.
CameraCalibration TwoCameras() {
  CameraCalibration fit;
  for (const double at : {0.0, 0.2}) {
    Camera camera{.name = "c",
                  .width_px = 1280,
                  .height_px = 1024,
                  .focal_x_px = 800,
                  .focal_y_px = 800,
                  .center_x_px = 640,
                  .center_y_px = 512};
    camera.camera_from_lab.translation() << -at, 0, 0;
    fit.cameras.push_back(camera);
  }
  const Eigen::Index lens = IntrinsicsOf(Distortion::kNone);
  fit.covariance.covariance = Eigen::MatrixXd::Zero(2 * lens + 6, 2 * lens + 6);
  fit.covariance.intrinsics_at = {0, lens};
  fit.covariance.pose_at = {-1, 2 * lens};
  return fit;
}

// Tags on a body that swings up and down before them, and centres that err by `pixel` px.
std::vector<MovingTag> Swing(const CameraCalibration& fit, int stamps, double pixel, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const auto project = [&](std::size_t camera, int tag, double time) {
    const Eigen::Vector3d at(0.06 * (tag % 3) + 0.03 * std::cos(2 * time),
                             0.06 * (tag / 3) + 0.1 * std::sin(3 * time), 0.8 + 0.05 * std::sin(time));
    return *Project(fit.cameras[camera], at);
  };
  std::vector<MovingTag> moving;
  for (int s = 0; s < stamps; ++s) {
    for (int tag = 0; tag < 6; ++tag) {
      for (std::size_t c = 0; c < 2; ++c) {
        const double time = 1e-9 * kPictureNs * s - (c == 1 ? kOffset : 0);
        const Eigen::Vector2d off(pixel * normal(random), pixel * normal(random));
        MovingTag m;
        m.seen = {.stamp = static_cast<std::int64_t>(kPictureNs) * (s + 1),
                  .tag = tag,
                  .camera = static_cast<int>(c),
                  .corners_px = (project(c, tag, time) + off).replicate<1, 4>()};
        const Eigen::Vector2d velocity = (project(c, tag, time + 1e-3) - project(c, tag, time - 1e-3)) / 2e6;
        m.velocity = velocity.replicate<1, 4>();
        m.px_per_picture = kPictureNs * velocity.norm();
        moving.push_back(m);
      }
    }
  }
  return moving;
}

TEST(DistanceBands, OffsetAndErrorOfAPairAreThoseDrawnAndBandsHoldTheDistances) {
  const CameraCalibration fit = TwoCameras();
  const std::vector<MovingTag> moving = Swing(fit, 200, 0.4, 5);
  std::map<std::int64_t, int> rank;
  for (const MovingTag& m : moving) rank.emplace(m.seen.stamp, static_cast<int>(rank.size()));
  const BandModel model = EstimateBands(fit, SeenTags(moving, rank, 0), 0.1);
  ASSERT_EQ(model.offset.size(), 4u);  // windows
  for (const auto& [key, offset] : model.offset) {
    EXPECT_NEAR(offset.seconds, kOffset, 3 * offset.sigma);
    EXPECT_LT(offset.sigma, 0.003);
  }
  EXPECT_NEAR(model.pair_px.at({0, 1}), std::sqrt(0.4 * 0.4 - 0.1 * 0.1), 0.03);

  const BandShares odd = SharesInside(BandedDistances(fit, SeenTags(moving, rank, 1), model), 0, 1e9);
  EXPECT_EQ(odd.distances, 1500);
  EXPECT_NEAR(100.0 * odd.in68 / odd.distances, 68, 5);
  EXPECT_NEAR(100.0 * odd.in95 / odd.distances, 95, 2.5);
  BandModel deaf = model;  // to the offset
  deaf.offset.clear();
  deaf.elsewhere = {};
  const BandShares off = SharesInside(BandedDistances(fit, SeenTags(moving, rank, 1), deaf), 0, 1e9);
  EXPECT_GT(off.scatter, 1.1 * odd.scatter);

  // On one clock rows agree, as cameras beside each other differ along x alone.
  std::map<std::pair<std::int64_t, int>, std::array<double, 2>> rows;
  for (const TagInPicture& tag : OnOneClock(moving, rank, model, 2)) {
    rows[{tag.stamp, tag.tag}][static_cast<std::size_t>(tag.camera)] = tag.corners_px(1, 0);
  }
  ASSERT_EQ(rows.size(), 1200u);
  double sum2 = 0;
  for (const auto& [key, row] : rows) sum2 += std::pow(row[1] - row[0], 2) / 1200;
  EXPECT_NEAR(std::sqrt(sum2), 0.4 * std::sqrt(2), 0.04);
}

}  // namespace
}  // namespace tendril::testing_support
