// analysis/link/link_bands.h: against the normal distribution's own shares, derivatives in closed form, and
// truths drawn by the test.
#include "analysis/link/link_bands.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

namespace tendril {
namespace {

using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;

FramedCurve Line(const Vector3d& from, const Vector3d& to, int nodes) {
  FramedCurve curve{Matrix3Xd(3, nodes), {}};
  for (int i = 0; i < nodes; ++i) {
    const double t = static_cast<double>(i) / (nodes - 1);
    curve.points.col(i) = (1 - t) * from + t * to;
  }
  return curve;
}

// All nodes move together along `way`.
MatrixXd Together(int nodes, const Vector3d& way) { return way.replicate(nodes, 1); }

constexpr double kLong = 50;  // against separations of millimetres: crossings are all there is

TEST(LinkBands, ACrossingThatMayLieEitherWayGivesBothValuesWithTheirShares) {
  const double sigma = 2e-3;
  for (const double sigmas : {0.0, 0.5, 1.0, 2.0}) {
    const std::vector<FramedCurve> curves = {
        Line({-kLong, 0, 0}, {kLong, 0, 0}, 11),
        Line({0, -kLong, sigmas * sigma + 1e-9}, {0, kLong, sigmas * sigma + 1e-9}, 11)};
    const std::vector<MatrixXd> factors = {Together(11, {0, 0, 0.6 * sigma}),
                                           Together(11, {0, 0, 0.8 * sigma})};
    LinkOptions options;
    options.closure = Closure{ClosureKind::kNone, 0};
    const auto bands = MeasureLinkBands(curves, factors, options, {.draws = 4000});
    ASSERT_TRUE(bands.ok());
    const LinkBand& gauss = bands.value().pairs[0].gauss;
    const double passed = 0.5 * std::erfc(sigmas / std::numbers::sqrt2);
    ASSERT_EQ(gauss.modes.size(), 2u);
    EXPECT_NEAR(gauss.modes[1].share, passed, 4 * std::sqrt(passed * (1 - passed) / 4000));
    EXPECT_NEAR(std::abs(gauss.modes[0].value - gauss.modes[1].value), 1, 1e-3);
    ASSERT_EQ(bands.value().undecided.size(), 1u);
    const UndecidedCrossing& crossing = bands.value().undecided[0];
    EXPECT_NEAR(crossing.separation, sigmas * sigma, 1e-8);
    EXPECT_NEAR(crossing.sigma, sigma, 1e-9);
    EXPECT_NEAR(crossing.node_a, 5, 1e-6);
    EXPECT_NEAR(crossing.node_b, 5, 1e-6);
  }
}

TEST(LinkBands, ACrossingFarApartIsDecided) {
  const double sigma = 2e-3;
  const std::vector<FramedCurve> curves = {Line({-kLong, 0, 0}, {kLong, 0, 0}, 11),
                                           Line({0, -kLong, 4 * sigma}, {0, kLong, 4 * sigma}, 11)};
  // Much of it along the strands: it does not bring them together.
  const std::vector<MatrixXd> factors = {Together(11, {0.1, 0.1, 0.6 * sigma}),
                                         Together(11, {0.1, 0.1, 0.8 * sigma})};
  const auto bands = MeasureLinkBands(curves, factors, {});
  ASSERT_TRUE(bands.ok());
  EXPECT_EQ(bands.value().pairs[0].gauss.modes.size(), 1u);
  EXPECT_TRUE(bands.value().undecided.empty());
}

TEST(LinkBands, WithoutUncertaintyEveryBandIsTheValue) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  std::vector<FramedCurve> curves;
  for (int k = 0; k < 3; ++k) {
    FramedCurve curve{Matrix3Xd::NullaryExpr(3, 30, [&] { return normal(random); }),
                      Matrix3Xd::NullaryExpr(3, 30, [&] { return normal(random); })};
    curves.push_back(curve);
  }
  LinkOptions options;
  options.axis = Axis{{0.1, 0.2, 0}, {0, 0, 1}};
  const std::vector<MatrixXd> factors(3, MatrixXd::Zero(90, 2));
  const auto bands = MeasureLinkBands(curves, factors, options, {.draws = 5});
  const auto report = MeasureLink(curves, options);
  ASSERT_TRUE(bands.ok() && report.ok());
  const auto is = [](const LinkBand& band, double value) {
    EXPECT_NEAR(band.low95, value, 1e-9);
    EXPECT_NEAR(band.high95, value, 1e-9);
    EXPECT_NEAR(band.standard_deviation, 0, 1e-9);
    ASSERT_EQ(band.modes.size(), 1u);
    EXPECT_EQ(band.modes[0].share, 1);
  };
  for (std::size_t k = 0; k < 3; ++k) {
    is(bands.value().curves[k].writhe, report.value().curves[k].writhe.value);
    is(bands.value().curves[k].self_link, report.value().curves[k].self_link.value);
    is(bands.value().curves[k].object_link, report.value().curves[k].object_link.value);
    is(bands.value().pairs[k].link, report.value().pairs[k].link.value);
  }
  is(bands.value().mutual_link, report.value().mutual_link);
  is(bands.value().performance, report.value().performance);
}

// A segment beside an axis: its winding angle is atan2(x, y) of its ends, whose slope is 1 / distance.
TEST(LinkBands, SpreadIsThatOfTheLinearFormWhereItIsSmall) {
  const double y = 0.1, sigma = 1e-4;
  const std::vector<FramedCurve> curves = {Line({0, y, 0}, {1e-9 + 0.05, y, 0.1}, 2)};
  LinkOptions options;
  options.closure = Closure{ClosureKind::kNone, 0};
  options.axis = Axis{{0, 0, 0}, {0, 0, 1}};
  MatrixXd factor = MatrixXd::Zero(6, 1);
  factor(3, 0) = sigma;  // x of the far end
  const auto bands = MeasureLinkBands(curves, std::vector<MatrixXd>{factor}, options, {.draws = 4000});
  ASSERT_TRUE(bands.ok());
  const double slope = y / (y * y + 0.05 * 0.05) / (2 * std::numbers::pi);
  EXPECT_NEAR(bands.value().curves[0].object_link.standard_deviation, slope * sigma, 0.05 * slope * sigma);
}

// Curves that wind about each other and an axis, seen with an error of the stated covariance.
TEST(LinkBands, TruthLiesInsideAsOftenAsStated) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  constexpr int kNodes = 40, kTrials = 150;
  int inside68 = 0, inside95 = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<FramedCurve> truth, seen;
    std::vector<MatrixXd> factors;
    for (int k = 0; k < 2; ++k) {
      FramedCurve curve{Matrix3Xd(3, kNodes), {}};
      for (int i = 0; i < kNodes; ++i) {
        const double t = static_cast<double>(i) / kNodes, angle = 9 * t + 3 * k;
        curve.points.col(i) = Vector3d(0.03 * std::cos(angle), 0.03 * std::sin(angle), 0.4 * t);
      }
      truth.push_back(curve);
      // Errors that run along the curve.
      MatrixXd factor(3 * kNodes, 6);
      for (int i = 0; i < kNodes; ++i) {
        const double t = static_cast<double>(i) / kNodes;
        factor.middleRows<3>(3 * i) << 2e-3 * Eigen::Matrix3d::Identity(),
            4e-3 * t * Eigen::Matrix3d::Identity();
      }
      factors.push_back(factor);
      Eigen::VectorXd z(6);
      for (double& number : z) number = normal(random);
      const Eigen::VectorXd off = factor * z;
      curve.points += Eigen::Map<const Matrix3Xd>(off.data(), 3, kNodes);
      seen.push_back(curve);
    }
    LinkOptions options;
    options.axis = Axis{{0, 0, 0}, {0, 0, 1}};
    const auto bands =
        MeasureLinkBands(seen, factors, options, {.draws = 200, .seed = static_cast<std::uint32_t>(trial)});
    const double value = MeasureLink(truth, options).value().performance;
    ASSERT_TRUE(bands.ok());
    const LinkBand& band = bands.value().performance;
    inside68 += value > band.low68 && value < band.high68 ? 1 : 0;
    inside95 += value > band.low95 && value < band.high95 ? 1 : 0;
  }
  EXPECT_NEAR(inside68, 0.68 * kTrials, 0.12 * kTrials);
  EXPECT_NEAR(inside95, 0.95 * kTrials, 0.06 * kTrials);
}

FramedCurve WithNormals(FramedCurve curve, const Vector3d& normal) {
  curve.normals = normal.replicate(1, curve.points.cols());
  return curve;
}

// A straight ribbon's self-link is the turn of its tip against its base over 2 pi.
TEST(LinkBands, TurnsOfTheNormalsSpreadTheSelfLink) {
  constexpr int kNodes = 20;
  const double sigma = 0.1;
  const std::vector<FramedCurve> curves = {
      WithNormals(Line({0, 0, 0}, {0, 0, 0.5}, kNodes), Vector3d::UnitX())};
  const std::vector<MatrixXd> still = {MatrixXd::Zero(3 * kNodes, 1)};
  MatrixXd turn = MatrixXd::Zero(kNodes, 3);
  turn.col(1).setConstant(1);  // of all together: no twist
  for (int i = 0; i < kNodes; ++i) turn(i, 2) = sigma * i / (kNodes - 1);
  const std::vector<MatrixXd> turns = {turn};
  const auto bands = MeasureLinkBands(curves, still, {}, {.draws = 4000}, {}, turns);
  ASSERT_TRUE(bands.ok());
  EXPECT_TRUE(bands.value().normals_drawn);
  const double expected = sigma / (2 * std::numbers::pi);
  EXPECT_NEAR(bands.value().curves[0].self_link.standard_deviation, expected, 0.05 * expected);
  EXPECT_NEAR(bands.value().curves[0].writhe.standard_deviation, 0, 1e-9);
  const auto without = MeasureLinkBands(curves, still, {});
  ASSERT_TRUE(without.ok());
  EXPECT_FALSE(without.value().normals_drawn);
  EXPECT_NEAR(without.value().curves[0].self_link.standard_deviation, 0, 1e-9);
}

// A coil that may be turned as a whole: points and normals together, if G says so.
TEST(LinkBands, ARigidTurnLeavesTheSelfLinkAloneIfNormalsGoWithThePoints) {
  constexpr int kNodes = 60;
  const Vector3d turn(0.01, 0.006, -0.008);  // rad
  FramedCurve coil{Matrix3Xd(3, kNodes), Matrix3Xd(3, kNodes)};
  MatrixXd factor(3 * kNodes, 1);
  MatrixXd together(kNodes, 1);
  for (int i = 0; i < kNodes; ++i) {
    const double angle = 0.15 * i;
    coil.points.col(i) << 0.05 * std::cos(angle), 0.05 * std::sin(angle), 0.004 * angle;
    coil.normals.col(i) << std::cos(angle), std::sin(angle), 0;
    factor.middleRows<3>(3 * i) = turn.cross(Vector3d(coil.points.col(i)));
    const Vector3d along(-0.05 * std::sin(angle), 0.05 * std::cos(angle), 0.004);
    together(i, 0) = turn.dot(along.normalized());
  }
  const std::vector<FramedCurve> curves = {coil};
  const std::vector<MatrixXd> factors = {factor};
  const std::vector<MatrixXd> turns = {together};
  const auto with = MeasureLinkBands(curves, factors, {}, {.draws = 200}, {}, turns);
  const auto without = MeasureLinkBands(curves, factors, {}, {.draws = 200});
  ASSERT_TRUE(with.ok() && without.ok());
  const double wrong = without.value().curves[0].self_link.standard_deviation;
  EXPECT_GT(wrong, 1e-4);
  EXPECT_LT(with.value().curves[0].self_link.standard_deviation, 0.1 * wrong);
}

TEST(LinkBands, ACurveThatMeetsItselfIsUndecidedAndABendIsNot) {
  // A loop whose ends cross 1 mm apart.
  FramedCurve loop{Matrix3Xd(3, 41), {}};
  for (int i = 0; i <= 40; ++i) {
    const double angle = 2 * std::numbers::pi * (i / 40.0) * 1.1;
    loop.points.col(i) = Vector3d(0.1 * std::sin(angle), 0.1 * std::cos(angle), 1e-3 * i / 40.0);
  }
  MatrixXd factor = MatrixXd::Zero(123, 41);
  for (int i = 0; i < 41; ++i) factor(3 * i + 2, i) = 5e-4;
  const std::vector<FramedCurve> curves = {loop, Line({1, 0, 0}, {1, 0, 1}, 41)};
  const std::vector<MatrixXd> factors = {factor, MatrixXd::Identity(123, 123) * 1e-3};
  const auto found = FindUndecided(curves, factors, std::nullopt, 3);
  ASSERT_FALSE(found.empty());
  for (const UndecidedCrossing& crossing : found) {
    EXPECT_EQ(crossing.a, 0);
    EXPECT_EQ(crossing.b, 0);
    EXPECT_GT(crossing.node_b - crossing.node_a, 30);
  }
}

TEST(LinkBands, WhatCannotBeDrawnIsBadInput) {
  const std::vector<FramedCurve> curves = {Line({0, 0, 0}, {1, 0, 0}, 3)};
  const auto kind = [&](const std::vector<MatrixXd>& factors, int draws) {
    const auto bands = MeasureLinkBands(curves, factors, {}, {.draws = draws});
    return bands.ok() ? ErrorKind::kIo : bands.error().kind;
  };
  EXPECT_EQ(kind({}, 10), ErrorKind::kBadInput);
  EXPECT_EQ(kind({MatrixXd::Zero(6, 2)}, 10), ErrorKind::kBadInput);
  EXPECT_EQ(kind({MatrixXd::Constant(9, 2, std::nan(""))}, 10), ErrorKind::kBadInput);
  EXPECT_EQ(kind({MatrixXd::Zero(9, 2)}, 1), ErrorKind::kBadInput);
  const std::vector<MatrixXd> factors = {MatrixXd::Zero(9, 2)};
  for (const std::vector<MatrixXd>& turns : {std::vector<MatrixXd>{MatrixXd::Zero(2, 2)},
                                             {MatrixXd::Zero(3, 1)},
                                             {MatrixXd::Constant(3, 2, std::nan(""))},
                                             {MatrixXd::Zero(3, 2), MatrixXd::Zero(3, 2)}}) {
    EXPECT_FALSE(MeasureLinkBands(curves, factors, {}, {}, {}, turns).ok());
  }
}

}  // namespace
}  // namespace tendril
