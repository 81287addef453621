// capture/track/planar_chain.h: arcs of known curvature and how sure it is, and gaps that stay gaps.
#include "capture/track/planar_chain.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>

#include "model/geometry/net_curvature.h"

namespace tendril {
namespace {

constexpr double kScale = 0.0005;  // m per px

std::optional<Eigen::Vector2d> Scaled(const Eigen::Vector2d& pixel) {
  return Eigen::Vector2d(kScale * pixel.x(), -kScale * pixel.y());
}

// Frame f shows an arc of total turning f * 0.4 over 8 segments of 60 px, starting to the right.
std::vector<DetectionRow> Arcs(int frames) {
  std::vector<DetectionRow> rows;
  for (int f = 0; f < frames; ++f) {
    Eigen::Vector2d at(100, 500);
    for (int i = 0; i < 9; ++i) {
      DetectionRow row{.camera = 0, .frame = f, .tag = 101 + i, .hamming = 0, .margin = 50, .corners_px = {}};
      row.corners_px << at.x() - 5, at.x() + 5, at.x() + 5, at.x() - 5, at.y() + 5, at.y() + 5, at.y() - 5,
          at.y() - 5;
      rows.push_back(row);
      const double heading = 0.4 * f * i / 7.0;
      at += 60 * Eigen::Vector2d(std::cos(heading), -std::sin(heading));  // up in the picture
    }
  }
  return rows;
}

PlanarChainOptions Options() {
  return {.chain = {101, 102, 103, 104, 105, 106, 107, 108, 109}, .sigma_px = 0.3, .plane_of_pixel = Scaled};
}

TEST(PlanarChain, AnArcsTurningAndCurvatureAreItsOwn) {
  const auto chain = FollowPlanarChain(Arcs(12), Eigen::VectorXd::LinSpaced(12, 0, 1.1), Options());
  ASSERT_TRUE(chain.ok());
  EXPECT_EQ(chain.value().complete_frames, 12);
  for (int f = 0; f < 12; ++f) {  // up to 4.4 rad: more than half a turn
    EXPECT_NEAR(chain.value().tip_angle[f], 0.4 * f, 1e-9);
    EXPECT_NEAR(chain.value().mean_curvature[f], 0.4 * f / (7 * 60 * kScale), 1e-9);
    EXPECT_NEAR(chain.value().curve.sigma[static_cast<size_t>(f)][0], 0.3 * kScale, 1e-12);
    EXPECT_GE(chain.value().curve.curves[static_cast<size_t>(f)].points(2, 8), -0.25 - 1e-9);
  }
  EXPECT_NEAR(MedianSpacingPx(Arcs(3), Options().chain), 60, 1e-9);
}

TEST(PlanarChain, WhatWasNotSeenIsNotMadeUp) {
  auto rows = Arcs(3);
  std::erase_if(rows, [](const DetectionRow& r) { return r.frame == 1 && r.tag == 105; });
  std::erase_if(rows, [](const DetectionRow& r) { return r.frame == 2; });
  const auto chain = FollowPlanarChain(rows, Eigen::Vector4d(0, 1, 2, 3), Options());
  ASSERT_TRUE(chain.ok());
  EXPECT_EQ(chain.value().complete_frames, 1);
  EXPECT_TRUE(std::isnan(chain.value().tip_angle[1]));
  EXPECT_TRUE(std::isnan(chain.value().curve.sigma[1][4]));
  EXPECT_TRUE(std::isnan(chain.value().curve.curves[1].points(0, 4)));
  EXPECT_FALSE(std::isnan(chain.value().curve.sigma[1][3]));
  EXPECT_TRUE(chain.value().curve.covariance_factor[1].middleRows(12, 3).isZero(0));
  EXPECT_NEAR(chain.value().curve.covariance_factor[1].middleRows(9, 3).squaredNorm(),
              2 * std::pow(0.3 * kScale, 2), 1e-15);
  EXPECT_TRUE(chain.value().curve.sigma[2].array().isNaN().all());
  EXPECT_NEAR(chain.value().seen_fraction, (9 + 8) / 36.0, 1e-12);
}

// Drawn chains, no real ones: pixels of the tags' centres err by 0.3 px, and the curvature of the true chain
// is asked to lie in the band that the covariance gives. Seeds 1 to 400, a camera straight on and one that
// looks askance.
TEST(PlanarChain, TheTrueCurvatureLiesInsideItsBandAsOftenAsStated) {
  const auto askance = [](const Eigen::Vector2d& p) -> std::optional<Eigen::Vector2d> {
    const double depth = 1 - 4e-4 * p.x() - 2e-4 * p.y();
    return Eigen::Vector2d(kScale * p.x() / depth, -kScale * (p.y() - 0.1 * p.x()) / depth);
  };
  for (const bool straight : {true, false}) {
    auto options = Options();
    if (!straight) options.plane_of_pixel = askance;
    const std::vector<DetectionRow> clean = Arcs(12);
    const Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(12, 0, 1.1);
    const auto truth = FollowPlanarChain(clean, time, options);
    ASSERT_TRUE(truth.ok());
    const Eigen::VectorXd true_bend = NetCurvatureOf(truth.value().curve).value;
    std::normal_distribution<double> error(0, options.sigma_px);
    int all = 0;
    int in68 = 0;
    int in95 = 0;
    for (int seed = 1; seed <= 400; ++seed) {
      std::mt19937_64 random(static_cast<std::uint64_t>(seed));
      std::vector<DetectionRow> rows = clean;
      for (DetectionRow& row : rows) {
        const Eigen::Vector2d off(error(random), error(random));
        row.corners_px.colwise() += off;
      }
      const auto chain = FollowPlanarChain(rows, time, options);
      ASSERT_TRUE(chain.ok());
      const NetCurvature bend = NetCurvatureOf(chain.value().curve);
      for (Eigen::Index f = 1; f < 12; ++f) {  // the first is straight
        const double z = std::abs(bend.value[f] - true_bend[f]) / bend.sigma[f];
        ++all;
        in68 += z < 0.99446 ? 1 : 0;
        in95 += z < 1.95996 ? 1 : 0;
      }
    }
    std::printf("%s: %.1f %% inside 68 %%, %.1f %% inside 95 %%\n", straight ? "straight on" : "askance",
                100.0 * in68 / all, 100.0 * in95 / all);
    EXPECT_NEAR(100.0 * in68 / all, 68, 2);
    EXPECT_NEAR(100.0 * in95 / all, 95, 1);
  }
}

TEST(PlanarChain, BadInputIsRefused) {
  auto options = Options();
  EXPECT_FALSE(FollowPlanarChain(Arcs(3), Eigen::Vector2d(0, 1), options).ok());
  EXPECT_TRUE(FollowPlanarChain({}, Eigen::VectorXd(), options).ok());
  options.chain = {101};
  EXPECT_FALSE(FollowPlanarChain(Arcs(3), Eigen::Vector3d(0, 1, 2), options).ok());
  options.chain = {101, 102, 101};
  EXPECT_FALSE(FollowPlanarChain(Arcs(3), Eigen::Vector3d(0, 1, 2), options).ok());
  EXPECT_TRUE(std::isnan(MedianSpacingPx({}, options.chain)));
}

// Under perspective the diagonals still cross at the centre; the corners' mean does not lie there.
TEST(PlanarChain, ATagsCenterIsWhereItsDiagonalsCross) {
  Eigen::Matrix<double, 2, 4> corners;
  corners << 0, 8, 6, 2, 0, 0, -4, -4;  // a trapezium: diagonals cross at (4, -8/3)
  EXPECT_LT((TagCenter(corners) - Eigen::Vector2d(4, -8.0 / 3)).norm(), 1e-12);
  EXPECT_EQ(TagCenter(Eigen::Vector2d(3, 4).replicate<1, 4>()), Eigen::Vector2d(3, 4));
}

}  // namespace
}  // namespace tendril
