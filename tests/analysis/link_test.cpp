// analysis/link: linking numbers of pairs known from knot theory, closed forms, invariants, the rules at the
// edges.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "analysis/link/link.h"
#include "analysis/link/link_kernel.h"
#include "tests/support/link_curves.h"

namespace tendril::test {
namespace {

TEST(StrandLink, HopfLinkIsOneAndItsSignFollowsTheOrientations) {
  const Matrix3Xd circle = Circle(40);
  // Runs up through the circle, which is counterclockwise seen from above.
  const Matrix3Xd other =
      Closed(37, [](double t) { return Vector3d(1 - std::cos(t), 0.05, -std::sin(t)); }).rowwise().reverse();
  EXPECT_NEAR(std::abs(Link(circle, other)), 1, 1e-13);
  EXPECT_NEAR(Link(circle, other) + Link(circle, other.rowwise().reverse()), 0, 1e-13);
  EXPECT_NEAR(Link(circle, other) - Link(other, circle), 0, 1e-13);
  // A curve that winds counterclockwise about an axis that it sees pointing up links it by +1.
  EXPECT_NEAR(AxisLink(Close(circle, kNone), {Vector3d(0.1, 0.2, 7), Vector3d(0, 0.1, 2)}).value, 1, 1e-14);
  const Matrix3Xd up = Line({0, 0, -1}, {0, 0, 1}, 3);
  EXPECT_NEAR(StrandLink(Close(circle, kNone), Close(up, kRays)).value, 1, 1e-13);
}

TEST(StrandLink, TorusLinksAtAllScales) {
  for (const int n : {1, 2, 3, 7, 12}) {
    for (const double scale : {1e-6, 1.0, 1e6, 1e-38, 1e28}) {
      const Matrix3Xd a = TorusStrand(n, 0, 240, scale), b = TorusStrand(n, 1, 300, scale);
      EXPECT_NEAR(Link(a, b), n, 1e-12) << "n " << n << " scale " << scale;
      const Matrix3Xd mirror_a = Vector3d(1, 1, -1).asDiagonal() * a;
      const Matrix3Xd mirror_b = Vector3d(1, 1, -1).asDiagonal() * b;
      EXPECT_NEAR(Link(mirror_a, mirror_b), -n, 1e-12) << "n " << n << " scale " << scale;
    }
  }
}

TEST(StrandLink, LinkedCurvesOfLinkZero) {
  // Borromean rings: three ellipses in three planes.
  const auto ellipse = [](int turn) {
    return Closed(60, [turn](double t) {
      Vector3d p(2 * std::cos(t), std::sin(t), 0);
      for (int k = 0; k < turn; ++k) p = Vector3d(p.z(), p.x(), p.y());
      return p;
    });
  };
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(Link(ellipse(i), ellipse((i + 1) % 3)), 0, 1e-13);
  // Whitehead link: a ring, and a loop that goes through it and back, whose two ends hook into each other.
  std::vector<Vector3d> loop;
  const auto along = [](double angle, double y) {
    return Vector3d(1.5 + 1.5 * std::cos(angle), y, 1.5 * std::sin(angle));
  };
  for (int i = 0; i <= 60; ++i) loop.push_back(along(0.4 + (2 * kPi - 0.8) * i / 60, 0.1));
  for (const Vector3d& p : {Vector3d(3, 0.1, -0.6), Vector3d(3.15, 0, -0.5), Vector3d(3.15, 0, 0.2),
                            Vector3d(2.85, 0, 0.2), Vector3d(2.85, 0, -0.5), Vector3d(3, -0.1, -0.6)}) {
    loop.push_back(p);
  }
  for (int i = 60; i >= 0; --i) loop.push_back(along(0.4 + (2 * kPi - 0.8) * i / 60, -0.1));
  for (const Vector3d& p : {Vector3d(3, -0.1, 0.5), Vector3d(3, -0.1, -0.2), Vector3d(3, 0.1, -0.2),
                            Vector3d(3, 0.1, 0.5), loop.front()}) {
    loop.push_back(p);
  }
  Matrix3Xd hooked(3, static_cast<Eigen::Index>(loop.size()));
  for (size_t i = 0; i < loop.size(); ++i) hooked.col(static_cast<Eigen::Index>(i)) = loop[i];
  EXPECT_NEAR(Link(Circle(50), hooked), 0, 1e-13);
  EXPECT_NEAR(std::abs(Link(Circle(50), Closed(60, [&](double t) { return along(t, 0.1); }))), 1, 1e-13);
  // Coplanar, apart or nested.
  EXPECT_EQ(Link(Circle(30), Circle(21, 0.5)), 0);
}

TEST(StrandLink, RandomClosedPolygonsLinkByWholeNumbers) {
  std::mt19937_64 random(11);
  int not_zero = 0;
  for (int trial = 0; trial < 200; ++trial) {
    Matrix3Xd a = RandomWalk(random, 23, 1), b = RandomWalk(random, 40, 1);
    a.rightCols(1) = a.leftCols(1);
    b.rightCols(1) = b.leftCols(1);
    const double link = Link(a, b);
    EXPECT_NEAR(link, std::round(link), 1e-12) << "trial " << trial;
    not_zero += std::round(link) != 0;
  }
  EXPECT_GT(not_zero, 30);
}

TEST(StrandLink, DoesNotDependOnFrameDirectionOrRefinement) {
  std::mt19937_64 random(5);
  for (int trial = 0; trial < 20; ++trial) {
    const Matrix3Xd a = RandomWalk(random, 30), b = RandomWalk(random, 25);
    for (const Closure& closure : {kNone, kRays, Closure{ClosureKind::kEndToEnd, 10}}) {
      const double link = Link(a, b, closure);
      const Eigen::Matrix3d turn =
          Eigen::Quaterniond(0.3, -0.5, 0.7, trial * 0.1).normalized().toRotationMatrix();
      EXPECT_NEAR(Link(turn * a, turn * b, closure), link, 1e-12);
      EXPECT_NEAR(Link(1e-6 * a, 1e-6 * b, closure), link, 1e-12);
      EXPECT_NEAR(Link(1e6 * a, 1e6 * b, closure), link, 1e-12);
      EXPECT_NEAR(Link(a.rowwise().reverse(), b, closure), -link, 1e-12);
      EXPECT_NEAR(Link(b, a, closure), link, 1e-12);
      EXPECT_NEAR(Link(-a, -b, closure), -link, 1e-12);
      Matrix3Xd fine(3, 2 * a.cols() - 1);  // a midpoint in every segment
      for (Eigen::Index i = 0; i < fine.cols(); ++i) fine.col(i) = 0.5 * (a.col(i / 2) + a.col((i + 1) / 2));
      EXPECT_NEAR(Link(fine, b, closure), link, 1e-11);
    }
  }
}

TEST(StrandLink, AMillionMetresAwayItIsTheLinkOfTheRoundedNodes) {
  std::mt19937_64 random(6);
  const Vector3d far(1e6, -2e6, 5e5);
  for (int trial = 0; trial < 10; ++trial) {
    const Matrix3Xd a = RandomWalk(random, 60).colwise() + far, b = RandomWalk(random, 60).colwise() + far;
    // The same nodes, moved back without rounding (the differences are exact).
    const Matrix3Xd a_near = a.colwise() - far, b_near = b.colwise() - far;
    EXPECT_NEAR(Link(a, b, kRays), Link(a_near, b_near, kRays), 1e-10);
    EXPECT_NEAR(Link(a, b, kNone), Link(a_near, b_near, kNone), 1e-12);
  }
}

// The Gauss integral by its definition: midpoints on smooth curves that stay apart, where the rule converges
// exponentially (closed curves).
TEST(StrandLink, IsTheGaussIntegral) {
  const auto first = [](double t) { return Vector3d(std::cos(t), std::sin(t), 0.3 * std::sin(2 * t)); };
  const auto second = [](double t) {
    return Vector3d(1 + 0.9 * std::cos(t), 0.2 * std::sin(3 * t), 0.9 * std::sin(t));
  };
  const auto slope = [](const std::function<Vector3d(double)>& at, double t) {
    return Vector3d((at(t + 1e-5) - at(t - 1e-5)) / 2e-5);
  };
  const int n = 400;
  double integral = 0;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const double s = 2 * kPi * i / n, t = 2 * kPi * j / n;
      const Vector3d r = first(s) - second(t);
      integral += slope(first, s).cross(slope(second, t)).dot(r) / std::pow(r.norm(), 3);
    }
  }
  integral *= std::pow(2 * kPi / n, 2) / (4 * kPi);
  EXPECT_NEAR(Link(Closed(100, first), Closed(100, second)), integral, 1e-8);
  EXPECT_GT(std::abs(integral), 0.5);
}

// An open pair, by quadrature on the segments themselves.
TEST(StrandLink, OpenSegmentsAgreeWithQuadrature) {
  const Vector3d p1(0, 0, 0), p2(1, 0.2, 0.1), p3(0.3, 1.4, 2), p4(0.6, -1.1, 1.2);
  const int n = 1500;
  double integral = 0;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const Vector3d r = (p1 + (p2 - p1) * (i + 0.5) / n) - (p3 + (p4 - p3) * (j + 0.5) / n);
      integral += (p2 - p1).cross(p4 - p3).dot(r) / std::pow(r.norm(), 3);
    }
  }
  integral /= 4 * kPi * n * n;
  EXPECT_NEAR(Link(Line(p1, p2, 1), Line(p3, p4, 1)), integral, 1e-6 * std::abs(integral) + 1e-9);
}

TEST(StrandLink, RaysAreTheLimitOfLongSegments) {
  std::mt19937_64 random(9);
  for (int trial = 0; trial < 20; ++trial) {
    const Matrix3Xd a = RandomWalk(random, 12), b = RandomWalk(random, 12);
    const LinkValue rays = StrandLink(Close(a, kRays), Close(b, kRays), LinkMethod::kExact);
    const double writhe = StrandWrithe(Close(a, kRays)).value;
    for (const double reach : {1e2, 1e4, 1e6}) {
      const Closure finite{ClosureKind::kNextTangent, reach};
      EXPECT_NEAR(Link(a, b, finite), rays.value, 3 / reach + 1e-9)
          << "trial " << trial << " reach " << reach;
      EXPECT_NEAR(StrandWrithe(Close(a, finite)).value, writhe, 3 / reach + 1e-9) << "trial " << trial;
    }
  }
}

TEST(StrandLink, ErrorBoundHoldsAgainstWiderNumbers) {
  std::mt19937_64 random(21);
  for (int trial = 0; trial < 50; ++trial) {
    // Close neighbours: the hard case.
    const Matrix3Xd a = RandomWalk(random, 20);
    const Matrix3Xd b = a + std::pow(10.0, -1 - trial % 9) * RandomWalk(random, 20);
    const LinkValue link = StrandLink(Close(a, kNone), Close(b, kNone), LinkMethod::kExact);
    long double sum = 0;
    const auto wide = [](const Vector3d& v) { return Vec3<long double>{v.x(), v.y(), v.z()}; };
    for (int i = 0; i < 19; ++i) {
      for (int j = 0; j < 19; ++j) {
        sum +=
            SegmentSegmentAngle(wide(a.col(i)), wide(a.col(i + 1)), wide(b.col(j)), wide(b.col(j + 1))).angle;
      }
    }
    const double truth = static_cast<double>(sum / (4 * std::numbers::pi_v<long double>));
    EXPECT_LE(std::abs(link.value - truth), link.error) << "trial " << trial;
    if (link.flags == 0) {
      EXPECT_LT(link.error, 1e-3) << "trial " << trial;
    }
  }
}

// The widely used sum of four arc sines, as published (Klenin and Langowski 2000): kept to see where it
// fails.
double ArcSineForm(const Vector3d& p1, const Vector3d& p2, const Vector3d& p3, const Vector3d& p4) {
  const Vector3d r12 = p2 - p1, r34 = p4 - p3, r13 = p3 - p1, r14 = p4 - p1, r23 = p3 - p2, r24 = p4 - p2;
  const Vector3d n[] = {r13.cross(r14).normalized(), r14.cross(r24).normalized(), r24.cross(r23).normalized(),
                        r23.cross(r13).normalized()};
  double sum = 0;
  for (int k = 0; k < 4; ++k) sum += std::asin(n[k].dot(n[(k + 1) % 4]));
  return r34.cross(r12).dot(r13) < 0 ? -sum : sum;
}

TEST(StrandLink, TheArcSineFormAgreesWhereItIsDefined) {
  std::mt19937_64 random(77);
  std::normal_distribution<double> normal;
  const auto point = [&] { return Vector3d(normal(random), normal(random), normal(random)); };
  const auto narrow = [](const Vector3d& v) { return Vec3<double>{v.x(), v.y(), v.z()}; };
  const auto wide = [](const Vector3d& v) { return Vec3<long double>{v.x(), v.y(), v.z()}; };
  for (int trial = 0; trial < 2000; ++trial) {
    const Vector3d p1 = point(), p2 = point(), p3 = point(), p4 = point();
    EXPECT_NEAR(SegmentSegmentAngle(narrow(p1), narrow(p2), narrow(p3), narrow(p4)).angle,
                ArcSineForm(p1, p2, p3, p4), 1e-6);
  }
  // Side by side, almost parallel: its unit normals' products round above 1.
  int undefined = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const Vector3d p1 = point(), along = point(), aside = 1e-3 * point();
    const Vector3d p2 = p1 + along, p3 = p1 + aside, p4 = p3 + along + 1e-9 * point();
    const double ours = SegmentSegmentAngle(narrow(p1), narrow(p2), narrow(p3), narrow(p4)).angle;
    const long double truth = SegmentSegmentAngle(wide(p1), wide(p2), wide(p3), wide(p4)).angle;
    EXPECT_NEAR(ours, static_cast<double>(truth), 1e-8);
    undefined += std::isnan(ArcSineForm(p1, p2, p3, p4)) ? 1 : 0;
  }
  EXPECT_GT(undefined, 20);
}

TEST(StrandLink, ParallelRaysAreFlagged) {
  const Matrix3Xd a = Line({0, 0, 0}, {0, 0, -0.7}, 10), b = Line({0.2, 0.1, 0}, {0.2, 0.1, -0.7}, 8);
  const LinkValue link = StrandLink(Close(a, kRays), Close(b, kRays));
  EXPECT_EQ(link.value, 0);
  EXPECT_EQ(link.flags, LinkFlags{kParallelRays});
  EXPECT_EQ(StrandLink(Close(a, kNone), Close(b, kNone)).flags, 0U);
  // Opposite ways: a base ray beside a tip ray, no doubt about anything.
  const Matrix3Xd back = b.rowwise().reverse();
  EXPECT_EQ(StrandLink(Close(a, kRays), Close(back, kRays)).flags, LinkFlags{kParallelRays});
}

// Straight tentacles tilted to the axis: all tip rays meet in one apex; by rounding alone the link would be
// +-0.5 or 0. With 8 around the carrier, opposite ones lie in a plane with the axis, others meet all the
// same.
TEST(StrandLink, TentaclesTiltedToOneApexAreFlaggedAndZero) {
  std::vector<Matrix3Xd> tentacles;
  for (int k = 0; k < 8; ++k) {
    const double azimuth = kPi / 8 + kPi / 4 * k, tilt = 5 * kPi / 180;
    const Vector3d out(std::cos(azimuth), std::sin(azimuth), 0);
    const Vector3d start = 0.12 * out;
    tentacles.push_back(
        Line(start, start - 0.72 * (std::sin(tilt) * out + std::cos(tilt) * Vector3d::UnitZ()), 48));
  }
  for (size_t i = 0; i < 8; ++i) {
    for (size_t j = i + 1; j < 8; ++j) {
      const LinkValue link = StrandLink(Close(tentacles[i], kRays), Close(tentacles[j], kRays));
      EXPECT_TRUE(link.flags & kMeetingRays) << i << " " << j;
      EXPECT_NEAR(link.value, 0, 1e-9) << i << " " << j;
    }
  }
}

TEST(StrandLink, CrossingAndTouchingBodiesAreTheMeanOfBothSidesWithAFlag) {
  const Matrix3Xd a = Line({-1, 0, 0}, {1, 0, 0}, 1);
  const auto at_height = [&](double h) { return Line({0.1, -1, h}, {-0.2, 1, h}, 1); };
  const LinkValue crossing = StrandLink(Close(a, kNone), Close(at_height(0), kNone));
  EXPECT_EQ(crossing.flags, LinkFlags{kCoplanarCrossing});
  EXPECT_EQ(crossing.value, 0);
  EXPECT_NEAR(std::abs(Link(a, at_height(1e-9)) - Link(a, at_height(-1e-9))), 1, 1e-8)
      << "a passage counts 1";
  EXPECT_NEAR(Link(a, at_height(1e-9)) + Link(a, at_height(-1e-9)), 0, 1e-12);

  const LinkFlags touching{kTouching};
  EXPECT_EQ(StrandLink(Close(a, kNone), Close(Line({0.3, 0, 0}, {0.3, 1, 2}, 1), kNone)).flags, touching);
  EXPECT_EQ(StrandLink(Close(a, kNone), Close(Line({1, 0, 0}, {3, 1, 2}, 1), kNone)).flags, touching);
  EXPECT_EQ(StrandLink(Close(a, kNone), Close(Line({0.5, 0, 0}, {2, 0, 0}, 1), kNone)).flags, touching)
      << "overlap";
  EXPECT_EQ(StrandLink(Close(a, kNone), Close(a, kNone)).flags, touching) << "itself";
  // In one plane or line, but apart: nothing to flag.
  EXPECT_EQ(StrandLink(Close(a, kNone), Close(Line({1.5, 0, 0}, {2, 0, 0}, 1), kNone)).flags, 0U);
  EXPECT_EQ(StrandLink(Close(a, kNone), Close(Line({0, 1, 0}, {0, 2, 0}, 1), kNone)).flags, 0U);
  EXPECT_EQ(StrandLink(Close(a, kNone), Close(Line({-1, 1, 0}, {1, 1, 0}, 1), kNone)).flags, 0U);
}

TEST(StrandLink, SegmentsWithoutLengthChangeNothing) {
  std::mt19937_64 random(3);
  const Matrix3Xd a = RandomWalk(random, 10), b = RandomWalk(random, 10);
  Matrix3Xd stuttering(3, 20);
  for (int i = 0; i < 20; ++i) stuttering.col(i) = a.col(i / 2);
  EXPECT_NEAR(Link(stuttering, b, kRays), Link(a, b, kRays), 1e-13);
  const LinkValue writhe = StrandWrithe(Close(stuttering, kRays));
  EXPECT_NEAR(writhe.value, StrandWrithe(Close(a, kRays)).value, 1e-13);
  EXPECT_EQ(writhe.flags, 0U);
}

TEST(StrandLink, ARayThatHitsABodyIsTheMeanOfBothSides) {
  const Matrix3Xd a = Line({0, 0, 0}, {0, 0, -1}, 2);  // its tip ray runs down the z axis
  const auto beside = [&](double x) { return Line({x, -1, -3}, {x, 1, -3}, 1); };
  const auto link = [&](double x) { return StrandLink(Close(a, kRays), Close(beside(x), kNone)); };
  EXPECT_EQ(link(0).flags, LinkFlags{kRayOnBody});
  EXPECT_EQ(link(0).value, 0);
  EXPECT_NEAR(std::abs(link(1e-7).value - link(-1e-7).value), 1, 1e-6);
  EXPECT_EQ(link(1e-7).flags, 0U);
}

// The program picks the widest kernel of its machine; the narrower ones must be right on others.
TEST(LinkKernel, AllWidthsAgreeWithTheScalarForm) {
  std::mt19937_64 random(41);
  for (const int nodes : {2, 3, 4, 5, 8, 9, 10, 17, 33, 100}) {
    for (int trial = 0; trial < 5; ++trial) {
      const Matrix3Xd a = RandomWalk(random, 2 + trial * 7, 1), b = RandomWalk(random, nodes, 1);
      const Strand first = Close(a, kNone), second = Close(b, kNone);
      const double exact = StrandLink(first, second, LinkMethod::kExact).value;
      const double writhe = StrandWrithe(second, LinkMethod::kExact).value;
      const NodeArrays x{first.x.data(), first.y.data(), first.z.data(), first.nodes()};
      const NodeArrays y{second.x.data(), second.y.data(), second.z.data(), second.nodes()};
      for (int width = 2; width <= LinkKernelWidth(); width *= 2) {
        const AngleSum sum = SumSegmentAngles(x, y, width);
        EXPECT_FALSE(sum.suspicious);
        EXPECT_NEAR(sum.angle / (4 * kPi), exact, 1e-12) << "width " << width << " nodes " << nodes;
        EXPECT_NEAR(SumOwnSegmentAngles(y, width).angle / (2 * kPi), writhe, 1e-12) << "width " << width;
        EXPECT_TRUE(SumSegmentAngles(y, y, width).suspicious) << "touches itself everywhere";
      }
    }
  }
}

}  // namespace
}  // namespace tendril::test
