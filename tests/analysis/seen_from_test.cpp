// analysis/link/seen_from.h: links are those with the object where it is; what rides along stands still.
#include "analysis/link/seen_from.h"

#include <gtest/gtest.h>

#include <cmath>

#include "analysis/link/link_series.h"

namespace tendril {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

// A coil of so many turns about the z axis, and an object that tumbles away with it.
struct Ride {
  std::vector<CurveSeries> curves;
  std::vector<Isometry3d> poses;
};

Ride Tumbling(double turns) {
  Ride ride;
  CurveSeries& coil = ride.curves.emplace_back();
  coil.name = "coil";
  coil.time = Eigen::VectorXd::LinSpaced(6, 0, 0.5);
  Isometry3d first = Isometry3d::Identity();
  first.linear() = Eigen::AngleAxisd(0.3, Vector3d(1, 2, 2) / 3).toRotationMatrix();  // its own axes
  for (int f = 0; f < 6; ++f) {
    Isometry3d moved(Eigen::AngleAxisd(0.7 * f, Vector3d(2, -1, 2) / 3));
    moved.translation() = Vector3d(0.3 * f, 0, -0.1 * f * f);
    ride.poses.push_back(moved * first);
    FramedCurve& curve = coil.curves.emplace_back();
    curve.points.resize(3, 200);
    for (int i = 0; i < 200; ++i) {
      const double along = i / 199.0, angle = 2 * M_PI * turns * along;
      curve.points.col(i) = moved * Vector3d(0.05 * std::cos(angle), 0.05 * std::sin(angle), 0.3 * along);
    }
  }
  return ride;
}

TEST(SeenFrom, WhatRidesAlongStandsStill) {
  const Ride ride = Tumbling(2);
  const std::vector<CurveSeries> seen = SeenFrom(ride.poses, ride.curves);
  ASSERT_EQ(seen.size(), 1U);
  EXPECT_EQ(seen[0].name, "coil");
  EXPECT_EQ(seen[0].time, ride.curves[0].time);
  for (const FramedCurve& curve : seen[0].curves) {
    EXPECT_LT((curve.points - ride.curves[0].curves[0].points).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_EQ(curve.normals.cols(), 0);
  }
}

TEST(SeenFrom, LinksWithAnObjectThatMovesStayWhatTheyWere) {
  const Ride ride = Tumbling(2);
  LinkOptions options;
  options.axis = Axis{{0, 0, 0}, {0, 0, 1}};
  const auto seen = MeasureLinkSeries(SeenFrom(ride.poses, ride.curves), options);
  const auto naive = MeasureLinkSeries(ride.curves, options);
  ASSERT_TRUE(seen.ok() && naive.ok());
  const double first = seen.value().AtPullZero().object_link;
  EXPECT_GT(std::abs(first), 1.5);
  for (const LinkReport& frame : seen.value().frames) EXPECT_NEAR(frame.object_link, first, 1e-9);
  EXPECT_LT(std::abs(naive.value().AtEnd().object_link), 1) << "about an axis that it has long left";
}

}  // namespace
}  // namespace tendril
