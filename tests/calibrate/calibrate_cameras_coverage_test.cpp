// calibrate/cameras: how often stated intervals have the truth, on made-up rigs.
#include <gtest/gtest.h>

#include "calibrate/cameras/calibrate_cameras.h"
#include "capture/track/board.h"
#include "tests/support/calibration_rig.h"

namespace tendril {
namespace {

using namespace testing_support;

TEST(CalibrateCameras, IntervalsHaveTheTruthAsOftenAsTheySay) {
  Coverage lenses;
  Coverage poses;
  for (const Distortion lens : {Distortion::kBrown, Distortion::kEquidistant}) {
    const std::vector<Camera> truth = FourInARow(lens);
    for (unsigned seed = 1; seed <= 6; ++seed) {
      std::mt19937 random(seed);
      const auto views = ChainedViews(truth, Points(), 10, 0.2, random);
      const auto fit = CalibrateCameras(Unknown(truth), views, Points(), {.folds = 0});
      ASSERT_TRUE(fit.ok()) << "seed " << seed << ": " << fit.error().message;
      EXPECT_NEAR(fit.value().rms_px, 0.2 * std::sqrt(2.0), 0.03);
      Count(fit.value(), truth, lenses, poses);
    }
  }
  // Parameters of one fit err together, so 12 fits leave much to chance; the bench takes 50.
  std::printf("lenses %.1f %% of %d (spread %.2f), poses %.1f %% of %d (spread %.2f)\n", 100 * lenses.share(),
              lenses.asked, lenses.spread(), 100 * poses.share(), poses.asked, poses.spread());
  EXPECT_GT(lenses.share(), 0.88);
  EXPECT_GT(poses.share(), 0.88);
  EXPECT_GT(lenses.spread(), 0.75);
  EXPECT_LT(lenses.spread(), 1.25);
}

// Corners of one picture that err together, as on a board that is pulled a little out of shape at each
// moment.
TEST(CalibrateCameras, IntervalsHoldWhereCornersErrTogetherAndSayMoreThanIndependentOnes) {
  std::vector<Camera> truth = FourInARow(Distortion::kBrown);
  truth.resize(2);
  Coverage together[2];
  Coverage alone[2];
  double ratio = 0;
  constexpr int kSeeds = 12;
  for (unsigned seed = 21; seed < 21 + kSeeds; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> amplitude(0, 0.25);
    auto views = ChainedViews(truth, Points(), 20, 0.05, random);
    for (BoardView& view : views) {
      const Eigen::Array2Xd p = (view.corners.pixels.colwise() - view.corners.pixels.col(0)) / 100;
      for (Eigen::Index row = 0; row < 2; ++row) {
        view.corners.pixels.row(row).array() += amplitude(random) * p.row(0).square() +
                                                amplitude(random) * p.row(0) * p.row(1) +
                                                amplitude(random) * p.row(1).square();
      }
    }
    const auto fit = CalibrateCameras(Unknown(truth), views, Points(), {.folds = 5});
    const auto naive =
        CalibrateCameras(Unknown(truth), views, Points(), {.folds = 0, .independent_corners = true});
    ASSERT_TRUE(fit.ok() && naive.ok()) << "seed " << seed;
    ratio += fit.value().refit_ratio / kSeeds;
    Count(fit.value(), truth, together[0], together[1]);
    Count(naive.value(), truth, alone[0], alone[1]);
  }
  const auto share = [](const Coverage* c) {
    return static_cast<double>(c[0].inside + c[1].inside) / (c[0].asked + c[1].asked);
  };
  std::printf("moments %.1f %%, independent corners %.1f %% of %d; refit ratio %.2f\n", 100 * share(together),
              100 * share(alone), together[0].asked + together[1].asked, ratio);
  EXPECT_GT(share(together), 0.88);
  EXPECT_LT(share(alone), 0.75);
  EXPECT_LT(ratio, 1.5);
}

}  // namespace
}  // namespace tendril
