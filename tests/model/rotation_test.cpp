// model/geometry/rotation.h: exp and log against long double and each other, at 0, 1e-12 and pi +- 1e-9.
#include "model/geometry/rotation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace tendril {
namespace {

using Vector3l = Eigen::Matrix<long double, 3, 1>;

Eigen::Vector3d RandomAxis(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
}

TEST(Rotation, LogUndoesExpAtEveryAngle) {
  std::mt19937_64 random(3);
  const double pi = std::numbers::pi;
  for (const double angle :
       {0.0, 1e-300, 1e-160, 1e-12, 1e-5, 1e-4, 1e-3, 1.0, 2.0, 3.0, pi - 1e-9, pi - 1e-12}) {
    for (int i = 0; i < 50; ++i) {
      const Eigen::Vector3d v = angle * RandomAxis(random);
      EXPECT_LE((LogSo3(ExpSo3Quaternion(v)) - v).norm(), 3e-15 * angle) << angle;
      EXPECT_LE((LogSo3(ExpSo3(v)) - v).norm(), 5e-15 * angle) << angle;
    }
  }
}

TEST(Rotation, BeyondPiTheShorterWayIsTaken) {
  std::mt19937_64 random(4);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d axis = RandomAxis(random);
    const double angle = std::numbers::pi + 1e-9;
    const Eigen::Vector3d expected = (angle - 2 * std::numbers::pi) * axis;
    EXPECT_LT((LogSo3(ExpSo3(angle * axis)) - expected).norm(), 1e-14);
    EXPECT_LT((LogSo3(ExpSo3Quaternion(angle * axis)) - expected).norm(), 1e-14);
  }
}

TEST(Rotation, ExactlyPiGivesOneOfTheTwoVectors) {
  Eigen::Matrix3d half_turn = Eigen::Matrix3d::Identity();
  half_turn(0, 0) = half_turn(2, 2) = -1;
  const Eigen::Vector3d v = LogSo3(half_turn);
  EXPECT_NEAR(std::abs(v.y()), std::numbers::pi, 1e-15);
  EXPECT_EQ(v.x(), 0);
  EXPECT_EQ(v.z(), 0);
}

TEST(Rotation, ExpTurnsPointsAsRodriguesSaysInLongDouble) {
  std::mt19937_64 random(5);
  for (const double angle : {1e-12, 1e-4, 0.7, 3.1415926}) {
    const Eigen::Vector3d axis = RandomAxis(random);
    const Eigen::Vector3d point = RandomAxis(random);
    const Vector3l k = (angle * axis).cast<long double>().normalized();
    const Vector3l p = point.cast<long double>();
    const long double t = (angle * axis).cast<long double>().norm();
    const Vector3l turned = p * std::cos(t) + k.cross(p) * std::sin(t) + k * k.dot(p) * (1 - std::cos(t));
    EXPECT_LT((ExpSo3(angle * axis) * point - turned.cast<double>()).norm(), 1e-15);
  }
}

}  // namespace
}  // namespace tendril
