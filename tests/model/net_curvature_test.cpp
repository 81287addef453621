// model/geometry/net_curvature.h: arcs, closed forms of a nearly straight chain's sigma, and whole curves
// drawn.
#include "model/geometry/net_curvature.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

namespace tendril {
namespace {

// `nodes` nodes a step apart, which turn by `turn` at each one between, in a plane that `in_lab` lays.
CurveSeries Arc(int nodes, double step, double turn,
                const Eigen::Isometry3d& in_lab = Eigen::Isometry3d::Identity()) {
  FramedCurve curve;
  curve.points.resize(3, nodes);
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  for (int i = 0; i < nodes; ++i) {
    curve.points.col(i) = in_lab * at;
    at += step * Eigen::Vector3d(std::cos(turn * i), std::sin(turn * i), 0);
  }
  return {.name = "arc",
          .time = Eigen::VectorXd::Zero(1),
          .curves = {curve},
          .sigma = {},
          .interpolated = {},
          .covariance_factor = {}};
}

TEST(NetCurvature, OfAnArcIsItsTurnOverItsLengthWhereverItLies) {
  Eigen::Isometry3d in_lab = Eigen::Isometry3d::Identity();
  in_lab.translation() << 1, -2, 3;
  in_lab.linear() = Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, -0.5).normalized()).toRotationMatrix();
  for (const double turn : {1e-6, 0.1, 0.6, 2.0}) {
    const NetCurvature net = NetCurvatureOf(Arc(9, 0.01, turn, in_lab));
    EXPECT_NEAR(net.value[0] / (turn / 0.01), 1, 1e-7) << turn;
    EXPECT_TRUE(std::isnan(net.sigma[0]));  // no covariance
    EXPECT_NEAR(NetCurvatureOf(Arc(9, 0.01, turn, in_lab), 3, 6).value[0] / (turn / 0.01), 1, 1e-7);
  }
}

TEST(NetCurvature, SigmaOfAHardlyBentChainIsThatOfItsSecondDifference) {
  constexpr double kStep = 0.02;
  constexpr double kSigma = 1e-5;
  CurveSeries chain = Arc(3, kStep, 1e-4);
  chain.covariance_factor = {kSigma * Eigen::MatrixXd::Identity(9, 9)};
  // (y0 - 2 y1 + y2) / step^2
  EXPECT_NEAR(NetCurvatureOf(chain).sigma[0], std::sqrt(6.0) * kSigma / (kStep * kStep), 1e-5);
  // Of more nodes only the ends' segments tell: (y_n - y_n-1 - y_1 + y_0) / step over n - 1 steps.
  CurveSeries longer = Arc(9, kStep, 1e-4);
  longer.covariance_factor = {kSigma * Eigen::MatrixXd::Identity(27, 27)};
  EXPECT_NEAR(NetCurvatureOf(longer).sigma[0], 2 * kSigma / (7 * kStep * kStep), 1e-5);
  // What moves or turns the chain as a whole is no error of its curvature.
  Eigen::MatrixXd rigid(27, 4);
  for (int i = 0; i < 9; ++i) {
    const Eigen::Vector3d p = longer.curves[0].points.col(i);
    rigid.block<3, 3>(3 * i, 0) = 1e-4 * Eigen::Matrix3d::Identity();
    rigid.block<3, 1>(3 * i, 3) = 1e-3 * Eigen::Vector3d(-p.y(), p.x(), 0);
  }
  longer.covariance_factor = {rigid};
  EXPECT_NEAR(NetCurvatureOf(longer).sigma[0], 0, 1e-6);
}

TEST(NetCurvature, SigmaIsTheScatterOfWholeCurvesDrawn) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  for (const double turn : {0.02, 0.3, 0.9}) {
    CurveSeries chain = Arc(7, 0.015, turn);
    for (int i = 0; i < 7; ++i) chain.curves[0].points(2, i) = 0.004 * std::sin(1.3 * i);  // out of a plane
    const Eigen::MatrixXd factor =
        Eigen::MatrixXd::NullaryExpr(21, 5, [&] { return 1e-4 * normal(random); });  // neighbours go together
    chain.covariance_factor = {factor};
    constexpr int kDraws = 4000;
    CurveSeries drawn = chain;
    for (int d = 0; d < kDraws; ++d) {
      const Eigen::VectorXd step =
          factor * Eigen::VectorXd::NullaryExpr(factor.cols(), [&] { return normal(random); });
      FramedCurve curve = chain.curves[0];
      curve.points += Eigen::Map<const Eigen::Matrix3Xd>(step.data(), 3, 7);
      drawn.curves.push_back(curve);
      drawn.covariance_factor.push_back(factor);
    }
    const NetCurvature all = NetCurvatureOf(drawn);  // all about one axis
    const Eigen::VectorXd off = all.value.tail(kDraws).array() - all.value[0];
    EXPECT_NEAR(std::sqrt(off.squaredNorm() / kDraws) / all.sigma[0], 1, 0.05) << turn;
  }
}

TEST(NetCurvature, WhatWasNotSeenHasNone) {
  CurveSeries chain = Arc(5, 0.01, 0.2);
  chain.curves.push_back(chain.curves[0]);
  chain.curves[1].points.col(4).setConstant(NAN);
  chain.covariance_factor.assign(2, 1e-5 * Eigen::MatrixXd::Identity(15, 15));
  const NetCurvature net = NetCurvatureOf(chain);
  EXPECT_TRUE(std::isfinite(net.value[0]) && net.sigma[0] > 0);
  EXPECT_TRUE(std::isnan(net.value[1]) && std::isnan(net.sigma[1]));
  EXPECT_GT(NetCurvatureOf(chain, 0, 3).sigma[1], 0);             // the nodes that count were
  EXPECT_TRUE(std::isnan(NetCurvatureOf(chain, 0, 1).value[0]));  // a segment has no bend
  EXPECT_EQ(NetCurvatureOf({}).value.size(), 0);
  // A straight chain turns about no axis: 0, and no sigma that would say how sure.
  CurveSeries straight = Arc(5, 0.01, 0);
  straight.covariance_factor = {1e-5 * Eigen::MatrixXd::Identity(15, 15)};
  EXPECT_EQ(NetCurvatureOf(straight).value[0], 0);
  EXPECT_TRUE(std::isnan(NetCurvatureOf(straight).sigma[0]));
}

}  // namespace
}  // namespace tendril
