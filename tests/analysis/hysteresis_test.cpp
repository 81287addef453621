// analysis/statistics/hysteresis.h: the closed form of backlash, drives that jump, and how often the truth
// lies inside. Seeds 1 to 400; nothing was tuned on them.
#include "analysis/statistics/hysteresis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>

namespace tendril {
namespace {

// From -1 up to 1 and back, `cycles` times, `rows` each way.
Eigen::VectorXd Triangle(int cycles, int rows) {
  Eigen::VectorXd drive(2 * cycles * rows + 1);
  for (Eigen::Index i = 0; i < drive.size(); ++i) {
    const auto at = static_cast<double>(i % (2 * rows)) / rows;
    drive[i] = at <= 1 ? 2 * at - 1 : 3 - 2 * at;
  }
  return drive;
}

// Backlash: what follows the drive once it has been moved by `play`, starting on the rising side.
Eigen::VectorXd Backlash(const Eigen::VectorXd& drive, double play) {
  Eigen::VectorXd response(drive.size());
  double at = drive[0] - play;
  for (Eigen::Index i = 0; i < drive.size(); ++i) {
    at = std::min(drive[i] + play, std::max(drive[i] - play, at));
    response[i] = at;
  }
  return response;
}

TEST(Hysteresis, BacklashHasTheWidthOfItsClosedForm) {
  const Eigen::VectorXd drive = Triangle(3, 200);
  const Hysteresis loop = MeasureHysteresis(drive, Backlash(drive, 0.1));
  ASSERT_EQ(loop.cycles.size(), 3u);
  ASSERT_EQ(loop.level.size(), 21);
  for (const HysteresisCycle& cycle : loop.cycles) {
    for (int l = 1; l < 20; ++l) {
      // The way down stays at 0.9 until 0.8; the way up likewise once it has turned.
      const double u = loop.level[l];
      const bool first = cycle.first == 1;
      const double up = first ? u - 0.1 : std::max(u - 0.1, -0.9);
      const double down = std::min(u + 0.1, 0.9);
      EXPECT_NEAR(cycle.rising[l], up, 1e-12) << u;
      EXPECT_NEAR(cycle.falling[l], down, 1e-12) << u;
    }
  }
  EXPECT_NEAR(loop.cycles[1].width, loop.cycles[2].width, 0.011);  // the very end was reached in one of them
  EXPECT_NEAR(loop.width, -0.19, 0.006);
  EXPECT_LT(loop.standard_error, 0.005);
  EXPECT_TRUE(std::isnan(loop.sigma));  // no row's sigma was stated
}

TEST(Hysteresis, AResponseWithoutMemoryHasNone) {
  const Eigen::VectorXd drive = Triangle(2, 100);
  const Hysteresis loop = MeasureHysteresis(drive, drive.array().sin());
  EXPECT_NEAR(loop.width, 0, 1e-12);
  EXPECT_EQ(loop.cycles[0].levels, 19);  // all but the two turns
}

TEST(Hysteresis, AHeldTurnBelongsToTheWayThereAndASmallTurnBackToItsStroke) {
  Eigen::VectorXd drive(14);
  drive << 0, 0, 0.5, 0.48, 1, 1, 1, 0.6, NAN, 0.2, 0.2, 0.23, 0.2, 0.9;
  const auto strokes = DriveStrokes(drive, 0.05);
  ASSERT_EQ(strokes.size(), 3u);
  EXPECT_TRUE(strokes[0].rises && !strokes[1].rises && strokes[2].rises);
  EXPECT_EQ(strokes[0].first, 2);
  EXPECT_EQ(strokes[0].last, 6);
  EXPECT_EQ(strokes[1].first, 7);
  EXPECT_EQ(strokes[1].last, 12);
  EXPECT_EQ(strokes[2].first, 13);
  EXPECT_TRUE(DriveStrokes(Eigen::Vector3d(1, 1, 1), 0).empty());
  EXPECT_TRUE(DriveStrokes(Eigen::VectorXd(), 0).empty());
}

// Up at once, down in steps: between the values of a jump nothing was seen on the way up.
TEST(Hysteresis, NothingIsMadeUpAcrossAJump) {
  Eigen::VectorXd drive(16);
  drive << 0, 0, 1, 1, 0.75, 0.5, 0.25, 0, 0, -1, -0.75, -0.5, -0.25, 0, 0, 0;
  const Eigen::VectorXd response = Eigen::VectorXd::LinSpaced(16, 0, 15);
  const Hysteresis loop = MeasureHysteresis(drive, response);
  ASSERT_EQ(loop.cycles.size(), 1u);
  EXPECT_EQ(loop.cycles[0].levels, 1);  // 0, which both reached; -1 and 1 were held on one way only
  EXPECT_DOUBLE_EQ(loop.cycles[0].rising[10], 14);
  EXPECT_DOUBLE_EQ(loop.cycles[0].falling[10], 7.5);
  EXPECT_DOUBLE_EQ(loop.width, 6.5);
  EXPECT_TRUE(std::isnan(loop.standard_error));  // of one cycle
}

TEST(Hysteresis, NoMoveNoRowsAndRowsThatAreNotKnownGiveNoLoop) {
  EXPECT_TRUE(MeasureHysteresis({}, {}).cycles.empty());
  EXPECT_TRUE(std::isnan(MeasureHysteresis(Eigen::Vector3d(1, 1, 1), Eigen::Vector3d(1, 2, 3)).width));
  const Eigen::VectorXd drive = Triangle(1, 50);
  EXPECT_TRUE(MeasureHysteresis(drive, Eigen::VectorXd::Constant(drive.size(), NAN)).cycles.empty());
  Eigen::VectorXd holed = Backlash(drive, 0.1);
  const double whole = MeasureHysteresis(drive, holed).width;
  for (Eigen::Index i = 5; i < holed.size(); i += 7) holed[i] = NAN;
  EXPECT_NEAR(MeasureHysteresis(drive, holed).width, whole, 0.01);
}

// Rows that follow each other are wrong alike, and cycles differ: the interval of cycles as blocks holds the
// truth as often as it says, that of rows taken as independent does not.
TEST(Hysteresis, TheIntervalHoldsTheTruthThoughRowsAreNotIndependent) {
  const Eigen::VectorXd drive = Triangle(5, 60);
  const Eigen::VectorXd shape = drive.array().sin();
  std::normal_distribution<double> normal;
  int inside = 0;
  int inside_by_rows = 0;
  constexpr int kSeeds = 400;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    std::mt19937_64 random(static_cast<std::uint64_t>(seed));
    Eigen::VectorXd response = shape;
    double error = normal(random);
    double half = 0;
    for (Eigen::Index i = 0; i < drive.size(); ++i) {
      if (i % 120 == 1) half = 0.5 * (1 + 0.3 * normal(random));  // of this cycle's loop; 1 on average
      error = 0.95 * error + std::sqrt(1 - 0.95 * 0.95) * normal(random);
      response[i] += (i % 120 < 61 && i % 120 > 0 ? half : -half) + 0.2 * error;
    }
    const Hysteresis loop = MeasureHysteresis(drive, response);
    ASSERT_EQ(loop.cycles.size(), 5u);
    inside += std::abs(loop.width - 1) < loop.half_95 ? 1 : 0;
    double rows = 0;
    double sum2 = 0;
    for (const HysteresisCycle& cycle : loop.cycles) {
      for (Eigen::Index l = 0; l < loop.level.size(); ++l) {
        const double off = cycle.rising[l] - cycle.falling[l] - loop.width;
        if (std::isnan(off)) continue;
        rows += 1;
        sum2 += off * off;
      }
    }
    inside_by_rows += std::abs(loop.width - 1) < 1.96 * std::sqrt(sum2) / rows ? 1 : 0;
  }
  std::printf("inside 95 %%: %.1f %% by cycles, %.1f %% by rows\n", 100.0 * inside / kSeeds,
              100.0 * inside_by_rows / kSeeds);
  EXPECT_GT(inside, 0.92 * kSeeds);
  EXPECT_LT(inside, 0.98 * kSeeds);
  EXPECT_LT(inside_by_rows, 0.75 * kSeeds);
}

// The worst that a row's own sigma can do: all rows of a stroke are off by the same.
TEST(Hysteresis, MeasurementsSigmaHoldsForStrokesThatAreWrongAlikeAndForRowsThatAreNot) {
  const Eigen::VectorXd drive = Triangle(1, 60);
  const Eigen::VectorXd clean = Backlash(drive, 0.1);
  const double truth = MeasureHysteresis(drive, clean).width;
  std::normal_distribution<double> normal(0, 0.2);
  int alike = 0;
  int apart = 0;
  constexpr int kSeeds = 400;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    std::mt19937_64 random(static_cast<std::uint64_t>(seed));
    Eigen::VectorXd strokes = clean;
    strokes.head(61).array() += normal(random);
    strokes.tail(60).array() += normal(random);
    Eigen::VectorXd rows = clean;
    for (double& v : rows) v += normal(random);
    const Eigen::VectorXd sigma = Eigen::VectorXd::Constant(drive.size(), 0.2);
    const Hysteresis a = MeasureHysteresis(drive, strokes, sigma);
    const Hysteresis b = MeasureHysteresis(drive, rows, sigma);
    alike += std::abs(a.width - truth) < 1.96 * a.sigma ? 1 : 0;
    apart += std::abs(b.width - truth) < 1.96 * b.sigma ? 1 : 0;
  }
  EXPECT_NEAR(alike, 0.95 * kSeeds, 0.03 * kSeeds);
  EXPECT_GT(apart, 0.99 * kSeeds);
}

TEST(RowScatter, SeesWhatIsNotSmoothAndNothingElse) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal(0, 0.3);
  Eigen::VectorXd values(2000);
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const double t = 0.01 * static_cast<double>(i);
    values[i] = 5 * std::sin(t) + normal(random);
  }
  EXPECT_NEAR(RowScatter(values), 0.3, 0.02);
  EXPECT_NEAR(RowScatter(Eigen::VectorXd::LinSpaced(50, 0, 7)), 0, 1e-12);
  EXPECT_TRUE(std::isnan(RowScatter(Eigen::Vector4d(1, 2, 3, 4))));
}

}  // namespace
}  // namespace tendril
