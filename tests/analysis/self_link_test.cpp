// analysis/link: writhe, twist and self-link against closed forms and each other.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "analysis/link/link.h"
#include "tests/support/link_curves.h"

namespace tendril::test {
namespace {

TEST(StrandWrithe, LongHelixPerTurn) {
  const double radius = 0.05, pitch = 0.04;
  const auto helix = [&](int turns, double hand) {
    const int per_turn = 120;
    Matrix3Xd points(3, turns * per_turn + 1);
    for (int i = 0; i < points.cols(); ++i) {
      const double t = 2 * kPi * i / per_turn;
      points.col(i) = Vector3d(radius * std::cos(t), hand * radius * std::sin(t), pitch * t / (2 * kPi));
    }
    return StrandWrithe(Close(points, kNone)).value;
  };
  // Source: Fuller 1971; the ends' share drops out of the slope.
  const double exact = 1 - pitch / std::sqrt(pitch * pitch + 4 * kPi * kPi * radius * radius);
  EXPECT_NEAR((helix(80, 1) - helix(40, 1)) / 40, exact, 1e-3);
  EXPECT_NEAR(helix(20, 1) + helix(20, -1), 0, 1e-12);
}

TEST(StrandWrithe, IsZeroInAPlaneAndForAMirrorSymmetricKnot) {
  EXPECT_EQ(StrandWrithe(Close(Circle(50), kNone)).value, 0);
  EXPECT_EQ(StrandWrithe(Close(Circle(50), kNone)).flags, 0U);
  EXPECT_EQ(StrandWrithe(Close(Line({0, 0, 0}, {1, 2, 3}, 1), kRays)).value, 0);
  // A closed curve that a quarter turn with reflection maps to itself: the figure-eight knot's symmetric
  // form.
  const Matrix3Xd knot = Closed(400, [](double t) {
    return Vector3d(0.6 * std::cos(t) + std::cos(3 * t), 0.6 * std::sin(t) + std::sin(3 * t),
                    0.7 * std::sin(4 * t))
        .eval();
  });
  const Matrix3Xd mirrored = Vector3d(1, 1, -1).asDiagonal() * knot;
  EXPECT_NEAR(StrandWrithe(Close(knot, kNone)).value + StrandWrithe(Close(mirrored, kNone)).value, 0, 1e-12);
}

// Calugareanu, White, Fuller: link with the offset curve = twist + writhe, a whole number on closed curves.
// A trefoil tied tight: the Fourier sum with its symmetry, whose length per thickness (least radius of a
// circle through two points, tangent at one) was driven down by descent to 17.66 diameters; the ideal's
// is 16.37. Its writhe settles far sooner than its length. Published for the ideal: 3.39.
TEST(StrandWrithe, TightTrefoil) {
  constexpr double kAcross[] = {1.07153798,  -1.0,        0.04756134,  -0.42618821, -0.04000583,
                                -0.19956635, -0.03233362, -0.07631323, -0.01108067, -0.01785351};
  constexpr double kAlong[] = {-0.32844514, -0.31767748, -0.23181337, -0.12973269, -0.04492449};
  const Matrix3Xd knot = Closed(600, [&](double t) {
    Vector3d p(0, 0, 0);
    for (int k = 0; k < 10; ++k) {
      const double turns = k % 2 == 0 ? 1 + 1.5 * k : -0.5 - 1.5 * k;  // 1, -2, 4, -5, 7, ...
      p.x() += kAcross[k] * std::cos(turns * t);
      p.y() += kAcross[k] * std::sin(turns * t);
    }
    for (int m = 0; m < 5; ++m) p.z() += kAlong[m] * std::sin(3 * (m + 1) * t);
    return p;
  });
  const Strand strand = Close(knot, kNone);
  EXPECT_NEAR(std::abs(StrandWrithe(strand, LinkMethod::kExact).value), 3.39, 0.01);
  Matrix3Xd mirror = knot;
  mirror.row(2) *= -1;
  EXPECT_NEAR(StrandWrithe(Close(mirror, kNone)).value, -StrandWrithe(strand).value, 1e-12);
}

TEST(SelfLink, IsTwistPlusWritheOnClosedCurves) {
  std::mt19937_64 random(17);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 30; ++trial) {
    double amplitude[18];
    for (double& c : amplitude) c = normal(random);
    const Matrix3Xd points = Closed(160, [&](double t) {
      Vector3d p = Vector3d::Zero();
      for (int k = 0; k < 3; ++k) {
        p += Vector3d(amplitude[6 * k], amplitude[6 * k + 1], amplitude[6 * k + 2]) * std::cos((k + 1) * t) /
             (k + 1);
        p += Vector3d(amplitude[6 * k + 3], amplitude[6 * k + 4], amplitude[6 * k + 5]) *
             std::sin((k + 1) * t) / (k + 1);
      }
      return p;
    });
    FramedCurve curve{points, Matrix3Xd(3, points.cols())};
    for (Eigen::Index i = 0; i < points.cols(); ++i) {
      const double t = 2 * kPi * static_cast<double>(i % 160) / 160;
      const Vector3d tangent = points.col((i + 1) % 160) - points.col((i + 159) % 160);
      const Vector3d any = tangent.unitOrthogonal();
      curve.normals.col(i) = Eigen::AngleAxisd(3 * t, tangent.normalized()) * any;
    }
    LinkOptions options;
    options.closure = kNone;
    options.self_offset = 1e-6;
    // A crossing of the seam of unitOrthogonal would make a wild ribbon; it stays a ribbon.
    const auto report = MeasureLink({&curve, 1}, options);
    ASSERT_TRUE(report.ok());
    const CurveLink& one = report.value().curves[0];
    const double sum = one.twist + one.writhe.value;
    EXPECT_NEAR(one.self_link.value, std::round(one.self_link.value), 1e-9) << "trial " << trial;
    EXPECT_NEAR(sum, one.self_link.value, 1e-10) << "trial " << trial;
  }
}

TEST(SelfLink, IsTwistPlusWritheOnOpenCurvesClosedByRays) {
  // A twisted ribbon along a right-handed helix, and the plain twisted strip.
  for (const double radius : {0.0, 0.05}) {
    const int n = 400;
    FramedCurve curve{Matrix3Xd(3, n + 1), Matrix3Xd(3, n + 1)};
    for (int i = 0; i <= n; ++i) {
      const double t = 6 * kPi * i / n;
      curve.points.col(i) = Vector3d(radius * std::cos(t), radius * std::sin(t), 0.03 * t);
      curve.normals.col(i) = Vector3d(std::cos(1.5 * t), std::sin(1.5 * t), 0.001);
    }
    LinkOptions options;
    options.self_offset = 1e-7;
    const auto report = MeasureLink({&curve, 1}, options);
    ASSERT_TRUE(report.ok());
    const CurveLink& one = report.value().curves[0];
    EXPECT_NEAR(one.self_link.value, one.twist + one.writhe.value, 1e-5) << "radius " << radius;
    EXPECT_EQ(one.self_link.flags, 0U);
    if (radius == 0) {
      EXPECT_NEAR(one.twist, 4.5, 1e-12);
    }
    EXPECT_GT(one.self_link.value, 3);
  }
}

}  // namespace
}  // namespace tendril::test
