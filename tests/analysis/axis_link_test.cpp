// analysis/link: link with an object's axis, means over a gripper, closures.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "analysis/link/link.h"
#include "tests/support/link_curves.h"

namespace tendril::test {
namespace {

TEST(AxisLink, IsTheLimitOfAVeryLongStraightCurve) {
  std::mt19937_64 random(31);
  for (int trial = 0; trial < 30; ++trial) {
    const Matrix3Xd points = RandomWalk(random, 40);
    const Axis axis{points.col(20) + Vector3d(0.03, 0.02, -0.01), Vector3d(1, 2, -0.5 + 0.1 * trial)};
    const Vector3d along = axis.direction.normalized();
    for (const Closure& closure : {kNone, kRays, Closure{ClosureKind::kNetTangent, 5}}) {
      const Strand strand = Close(points, closure);
      const LinkValue exact = AxisLink(strand, axis);
      EXPECT_EQ(exact.flags, 0U);
      // With rays of its own the line is infinite: the same number from the solid angles.
      const Strand line = Close(Line(axis.point - along, axis.point + along, 1), kRays);
      EXPECT_NEAR(StrandLink(strand, line, LinkMethod::kExact).value, exact.value, 1e-12)
          << "trial " << trial;
      if (closure.kind == ClosureKind::kRays) continue;
      const Strand longer = Close(Line(axis.point - 1e6 * along, axis.point + 1e6 * along, 1), kNone);
      EXPECT_NEAR(StrandLink(strand, longer).value, exact.value, 1e-5);
    }
  }
}

TEST(AxisLink, CountsTurnsOfAHelixAndFlagsContact) {
  Matrix3Xd helix(3, 301);
  for (int i = 0; i <= 300; ++i) {
    const double t = 2 * kPi * 2.25 * i / 300;
    helix.col(i) = Vector3d(0.01 * t, 0.03 * std::cos(t), 0.03 * std::sin(t));
  }
  const Axis axis{{5, 0, 0}, {2, 0, 0}};
  EXPECT_NEAR(AxisLink(Close(helix, kNone), axis).value, 2.25, 1e-14);
  const Axis reversed{{5, 0, 0}, {-2, 0, 0}};
  EXPECT_NEAR(AxisLink(Close(helix, kNone), reversed).value, -2.25, 1e-14);

  EXPECT_EQ(AxisLink(Close(Line({0, -1, 0}, {0, 1, 0}, 1), kNone), axis).flags, LinkFlags{kTouchesAxis});
  EXPECT_EQ(AxisLink(Close(Line({0, 0, 2}, {0, 0, 1}, 3), kRays), axis).flags, LinkFlags{kRayMeetsAxis});
  EXPECT_EQ(AxisLink(Close(Line({0, 0, 1}, {3, 0, 1}, 3), kRays), axis).flags, LinkFlags{kRayAlongAxis});
  EXPECT_EQ(AxisLink(Close(Line({0, 0, 1}, {3, 0, 1}, 3), kRays), axis).value, 0);
}

TEST(MeasureLink, AveragesMagnitudesOverPairsAndCurves) {
  std::mt19937_64 random(2);
  std::vector<FramedCurve> curves;
  for (int i = 0; i < 4; ++i) curves.push_back({RandomWalk(random, 30), {}});
  LinkOptions options;
  options.axis = Axis{{0.1, 0, 0}, {0, 1, 0}};
  const auto report = MeasureLink(curves, options);
  ASSERT_TRUE(report.ok());
  ASSERT_EQ(report.value().pairs.size(), 6U);
  double mutual = 0, object = 0;
  for (const PairLink& pair : report.value().pairs) mutual += std::abs(pair.link.value) / 6;
  for (const CurveLink& curve : report.value().curves) object += std::abs(curve.object_link.value) / 4;
  EXPECT_NEAR(report.value().mutual_link, mutual, 1e-15);
  EXPECT_NEAR(report.value().object_link, object, 1e-15);
  EXPECT_NEAR(report.value().performance, mutual + object, 1e-15);
  for (const CurveLink& curve : report.value().curves) {
    EXPECT_TRUE(std::isnan(curve.self_link.value));
    EXPECT_EQ(curve.self_link.flags, LinkFlags{kNoNormals});
  }
}

TEST(MeasureLink, ACurveWithAHoleInItIsMissingNotZero) {
  std::mt19937_64 random(2);
  std::vector<FramedCurve> curves;
  for (int i = 0; i < 3; ++i) curves.push_back({RandomWalk(random, 30), {}});
  curves[1].points(2, 7) = std::nan("");
  LinkOptions options;
  options.axis = Axis{{0.1, 0, 0}, {0, 1, 0}};
  const auto report = MeasureLink(curves, options);
  ASSERT_TRUE(report.ok());
  EXPECT_TRUE(std::isnan(report.value().curves[1].object_link.value));
  EXPECT_EQ(report.value().curves[1].writhe.flags, LinkFlags{kMissing});
  EXPECT_TRUE(std::isnan(report.value().pairs[0].link.value));
  EXPECT_TRUE(std::isfinite(report.value().pairs[1].link.value));
  EXPECT_TRUE(std::isnan(report.value().mutual_link));
  EXPECT_TRUE(std::isnan(report.value().performance));
}

TEST(CloseCurve, RefusesWhatHasNoShape) {
  EXPECT_FALSE(CloseCurve(Matrix3Xd::Zero(3, 0), kNone).ok());
  EXPECT_FALSE(CloseCurve(Matrix3Xd::Zero(3, 1), kNone).ok());
  EXPECT_FALSE(CloseCurve(Matrix3Xd::Zero(3, 5), kRays).ok());
  EXPECT_FALSE(CloseCurve(Circle(12), {ClosureKind::kEndToEnd, 3}).ok()) << "ends coincide";
  const auto two = CloseCurve(Line({0, 0, 0}, {0, 0, 2}, 1), {ClosureKind::kNextTangent, 3});
  ASSERT_TRUE(two.ok());
  EXPECT_EQ(two.value().z.back(), 8);
  EXPECT_EQ(two.value().z.front(), -6);
}

TEST(ParseClosure, ReadsTheFiveAndNamesWhatIsWrong) {
  EXPECT_EQ(ParseClosure("rays").value().kind, ClosureKind::kRays);
  EXPECT_EQ(ParseClosure("none").value().kind, ClosureKind::kNone);
  const auto finite = ParseClosure("net_tangent:1e3");
  ASSERT_TRUE(finite.ok());
  EXPECT_EQ(finite.value().kind, ClosureKind::kNetTangent);
  EXPECT_EQ(finite.value().arc_lengths, 1000);
  EXPECT_EQ(ClosureText(finite.value()), "net_tangent:1000");
  for (const char* bad : {"", "ray", "rays:3", "next_tangent", "next_tangent:", "end_to_end:-1",
                          "end_to_end:0", "end_to_end:nan", "end_to_end:inf", "net_tangent:3x"}) {
    const auto closure = ParseClosure(bad);
    ASSERT_FALSE(closure.ok()) << bad;
    EXPECT_EQ(closure.error().kind, ErrorKind::kBadInput);
  }
}

}  // namespace
}  // namespace tendril::test
