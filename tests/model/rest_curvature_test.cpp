// model/fold/rest_curvature.h: turning is moved, never made; a circle stays a circle; places on the rod.
#include "model/fold/rest_curvature.h"

#include <gtest/gtest.h>

#include <numbers>

#include "model/fold/fold.h"

namespace tendril {
namespace {

struct Pulled {
  TentacleLayout layout;
  TendonCurve curve;
};

Pulled PullOf(const TentacleDesign& design, double pull) {
  Pulled pulled{.layout = LayOut(design).value(), .curve = {}};
  const Fold fold = SolveFold(design, pull).value();
  pulled.curve = TendonCurveOf(pulled.layout, FoldChain(pulled.layout, fold.angle), fold.angle);
  return pulled;
}

TEST(RestCurvature, TotalTurningIsKept) {
  for (const auto map : {CurvatureMap::kTurning, CurvatureMap::kMaterial}) {
    for (const int elements : {2, 3, 100, 5000}) {
      for (const double smoothing : {0.0, 2.0, 30.0}) {
        for (const double pull : {0.0, 1e-12, 0.3, 0.95, 1.0}) {
          const Pulled p = PullOf({}, pull);
          const RestCurvature rest = RestCurvatureOf(p.layout, p.curve, {elements, smoothing, map});
          const Eigen::Vector3d total = rest.element_length * rest.curvature.rowwise().sum();
          EXPECT_LT((total - p.curve.turning.rowwise().sum()).norm(),
                    1e-12 * (1e-3 + p.curve.turning.cwiseAbs().sum()))
              << elements << " elements, smoothing " << smoothing << ", pull " << pull;
        }
      }
    }
  }
}

TEST(RestCurvature, EvenTurningStaysEvenAndTheEndsStayStraight) {
  Pulled p = PullOf({}, 0);
  p.layout.hole_z = Eigen::VectorXd::LinSpaced(49, 0, 0.72);
  p.curve.segment_length = Eigen::VectorXd::Constant(48, 0.015 * 0.7);
  p.curve.turning = Eigen::Vector3d(0.1, -0.2, 0.3).replicate(1, 47);
  const RestCurvature rest = RestCurvatureOf(p.layout, p.curve, {.elements = 100, .smoothing = 3});
  // 0.2 rad per 15 mm of rod, from half a segment beyond the first hole (22.5 mm) to as far from the tip.
  for (int node = 4; node < 95; ++node) {
    EXPECT_LT((rest.curvature.col(node) - Eigen::Vector3d(0.1, -0.2, 0.3) / 0.015).norm(), 1e-9) << node;
  }
  EXPECT_LT(rest.curvature.leftCols(2).norm(), 1e-12);
  EXPECT_LT(rest.curvature.rightCols(2).norm(), 1e-12);

  // The tendon's own curvature is what `unscaled` keeps: it turns 1 / 0.7 times too far on the longer rod.
  const RestCurvature unscaled =
      RestCurvatureOf(p.layout, p.curve, {.elements = 100, .smoothing = 3, .map = CurvatureMap::kUnscaled});
  EXPECT_LT((unscaled.curvature * 0.7 - rest.curvature).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(RestCurvature, TurningLandsWhereItsHoleIs) {
  Pulled p = PullOf({}, 0);
  p.curve.turning.setZero();
  p.curve.turning(1, 23) = 1;  // hole 24: the middle of the tentacle
  for (const auto map : {CurvatureMap::kTurning, CurvatureMap::kMaterial}) {
    const RestCurvature rest = RestCurvatureOf(p.layout, p.curve, {100, 0, map});
    double moment = 0;
    for (int node = 0; node < 99; ++node) {
      moment += rest.curvature(1, node) * rest.element_length * (node + 1) * rest.element_length;
    }
    EXPECT_NEAR(moment, p.layout.hole_z[24] - p.layout.base_z, 0.5 * 0.015);
  }
}

TEST(SmoothedTurning, SpreadsAnImpulseByTheStatedDeviation) {
  Eigen::Matrix3Xd impulse = Eigen::Matrix3Xd::Zero(3, 201);
  impulse(0, 100) = 1;
  const Eigen::Matrix3Xd smoothed = SmoothedTurning(impulse, 4);
  double variance = 0;
  for (int i = 0; i < 201; ++i) variance += smoothed(0, i) * (i - 100) * (i - 100);
  EXPECT_NEAR(smoothed.row(0).sum(), 1, 1e-14);
  EXPECT_NEAR(variance, 16, 1e-3);
  EXPECT_EQ(SmoothedTurning(impulse, 0), impulse);
}

TEST(SmoothedTurning, TakesOutTheAlternationBetweenCreases) {
  const Pulled p = PullOf({}, 0.3);
  const Eigen::Matrix3Xd smoothed = SmoothedTurning(p.curve.turning, 2);
  // Neighbouring holes' twists differ by their crease's angle; smoothed, a curve without a zigzag is left.
  for (int i = 8; i + 8 < 47; ++i) {
    EXPECT_LT(std::abs(smoothed(2, i + 1) - 2 * smoothed(2, i) + smoothed(2, i - 1)),
              2e-3 * smoothed(2, i) + 1e-4);
  }
}

}  // namespace
}  // namespace tendril
