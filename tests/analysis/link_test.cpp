// analysis/link: linking numbers known from knot theory, closed forms, invariants, the rules at the edges.
#include "analysis/link/link.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "analysis/link/link_kernel.h"

namespace tendril {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;
constexpr double kPi = std::numbers::pi;
constexpr Closure kNone{ClosureKind::kNone, 0};
constexpr Closure kRays{ClosureKind::kRays, 0};

// A closed polygon on a periodic curve: the last node is the first one, to the bit.
Matrix3Xd Closed(int n, const std::function<Vector3d(double)>& at) {
  Matrix3Xd points(3, n + 1);
  for (int i = 0; i < n; ++i) points.col(i) = at(2 * kPi * i / n);
  points.col(n) = points.col(0);
  return points;
}

Matrix3Xd Line(const Vector3d& from, const Vector3d& to, int segments) {
  Matrix3Xd points(3, segments + 1);
  for (int i = 0; i <= segments; ++i) points.col(i) = from + (to - from) * i / segments;
  return points;
}

Matrix3Xd RandomWalk(std::mt19937_64& random, int n, double step = 0.1) {
  std::normal_distribution<double> normal(0, step);
  Matrix3Xd points(3, n);
  points.col(0) = Vector3d(normal(random), normal(random), normal(random));
  for (int i = 1; i < n; ++i) {
    points.col(i) = points.col(i - 1) + Vector3d(normal(random), normal(random), normal(random));
  }
  return points;
}

Strand Close(const Matrix3Xd& points, const Closure& closure) {
  auto strand = CloseCurve(points, closure);
  EXPECT_TRUE(strand.ok()) << (strand.ok() ? "" : strand.error().message);
  return std::move(strand).value();
}

double Link(const Matrix3Xd& a, const Matrix3Xd& b, const Closure& closure = kNone) {
  const LinkValue fast = StrandLink(Close(a, closure), Close(b, closure), LinkMethod::kFast);
  const LinkValue exact = StrandLink(Close(a, closure), Close(b, closure), LinkMethod::kExact);
  EXPECT_NEAR(fast.value, exact.value, 1e-12) << "the two methods part";
  EXPECT_EQ(fast.flags, exact.flags);
  return exact.value;
}

Matrix3Xd Circle(int n, double scale = 1) {
  return Closed(n, [=](double t) { return Vector3d(scale * std::cos(t), scale * std::sin(t), 0); });
}

// Strand k of the torus link T(2, 2n), each winding once the long way and n times the short way.
Matrix3Xd TorusStrand(int n, int k, int nodes, double scale) {
  return Closed(nodes, [=](double t) {
    const double small = n * t + kPi * k;
    const double radius = scale * (2 + 0.7 * std::cos(small));
    return Vector3d(radius * std::cos(t), radius * std::sin(t), -0.7 * scale * std::sin(small));
  });
}

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
}  // namespace tendril
