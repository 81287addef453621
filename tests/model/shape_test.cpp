// model/objects/shape.h: distances against sampled surfaces and their definitions, mass against closed forms
// and counting random points, principal frames, what stands for surfaces.
#include "model/objects/shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "model/geometry/rotation.h"

namespace tendril {
namespace {

using std::numbers::pi;

double Uniform(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

Eigen::Vector3d RandomPoint(std::mt19937_64& random, double half) {
  return {Uniform(random, -half, half), Uniform(random, -half, half), Uniform(random, -half, half)};
}

Eigen::Isometry3d RandomPose(std::mt19937_64& random) {
  Eigen::Isometry3d pose(ExpSo3(RandomPoint(random, 1.8)));
  pose.translation() = RandomPoint(random, 0.5);
  return pose;
}

Primitive Sphere(double radius) { return {PrimitiveKind::kSphere, radius, Eigen::Vector3d::Zero()}; }
Primitive Capsule(double radius, double half) { return {PrimitiveKind::kCapsule, radius, {0, 0, half}}; }
Primitive Cylinder(double radius, double half) { return {PrimitiveKind::kCylinder, radius, {0, 0, half}}; }
Primitive Box(double x, double y, double z) { return {PrimitiveKind::kBox, 0, {x, y, z}}; }

Primitive Moved(Primitive part, const Eigen::Isometry3d& pose) {
  part.object_from_primitive = pose;
  return part;
}

Shape OneOfEach() { return {Sphere(0.3), Capsule(0.2, 0.4), Cylinder(0.3, 0.2), Box(0.2, 0.3, 0.4)}; }

// Is a point of the primitive's own frame in it? As shape.h defines them.
bool Inside(const Primitive& part, const Eigen::Vector3d& p) {
  switch (part.kind) {
    case PrimitiveKind::kSphere:
      return p.norm() < part.radius;
    case PrimitiveKind::kCapsule: {
      const double beyond = std::max(0.0, std::abs(p.z()) - part.half.z());
      return p.x() * p.x() + p.y() * p.y() + beyond * beyond < part.radius * part.radius;
    }
    case PrimitiveKind::kCylinder:
      return p.head<2>().norm() < part.radius && std::abs(p.z()) < part.half.z();
    case PrimitiveKind::kBox:
      return (p.cwiseAbs() - part.half).maxCoeff() < 0;
    case PrimitiveKind::kHalfSpace:
      return p.z() < 0;
  }
  return false;
}

// The surface's point in a direction from the origin, by bisection of Inside.
Eigen::Vector3d SurfaceToward(const Primitive& part, const Eigen::Vector3d& direction) {
  double low = 0, high = 2;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (Inside(part, middle * direction) ? low : high) = middle;
  }
  return low * direction;
}

std::vector<Eigen::Vector3d> SampledSurface(const Primitive& part) {
  std::vector<Eigen::Vector3d> points;
  const int count = 20000;
  for (int i = 0; i < count; ++i) {  // a spiral, even on the sphere
    const double z = 1 - (2.0 * i + 1) / count, angle = pi * (3 - std::sqrt(5.0)) * i;
    const double across = std::sqrt(1 - z * z);
    points.push_back(SurfaceToward(part, {across * std::cos(angle), across * std::sin(angle), z}));
  }
  return points;
}

TEST(DistanceTo, IsThatToTheNearestOfManySurfacePoints) {
  std::mt19937_64 random(1);
  for (const Primitive& part : OneOfEach()) {
    const std::vector<Eigen::Vector3d> surface = SampledSurface(part);
    for (int i = 0; i < 100; ++i) {
      const Eigen::Vector3d p = RandomPoint(random, 0.8);
      const Eigen::Isometry3d pose = RandomPose(random);
      const SurfaceDistance found = DistanceTo(Moved(part, pose), pose * p);
      EXPECT_EQ(found.distance < 0, Inside(part, p));
      double nearest = std::numeric_limits<double>::infinity();
      for (const Eigen::Vector3d& q : surface) nearest = std::min(nearest, (p - q).norm());
      EXPECT_GE(nearest, std::abs(found.distance) - 1e-13) << static_cast<int>(part.kind);
      EXPECT_LE(nearest, std::abs(found.distance) + 0.01) << static_cast<int>(part.kind);
      // The foot lies on the surface: just inside on one side, just outside on the other.
      const Eigen::Vector3d normal = pose.linear().transpose() * found.normal;
      const Eigen::Vector3d foot = p - found.distance * normal;
      EXPECT_TRUE(Inside(part, foot - 1e-9 * normal)) << static_cast<int>(part.kind);
      EXPECT_FALSE(Inside(part, foot + 1e-9 * normal)) << static_cast<int>(part.kind);
    }
  }
}

TEST(DistanceTo, NormalsAreItsGradient) {
  std::mt19937_64 random(2);
  Shape shape = OneOfEach();
  shape.push_back({PrimitiveKind::kHalfSpace, 0, Eigen::Vector3d::Zero()});
  for (const Primitive& part : shape) {
    for (int i = 0; i < 300; ++i) {
      const Primitive moved = Moved(part, RandomPose(random));
      const Eigen::Vector3d p = RandomPoint(random, 1.0);
      const Eigen::Vector3d normal = DistanceTo(moved, p).normal;
      EXPECT_NEAR(normal.norm(), 1, 1e-14);
      const double step = 1e-6;
      Eigen::Vector3d gradient;
      for (int k = 0; k < 3; ++k) {
        const Eigen::Vector3d d = step * Eigen::Vector3d::Unit(k);
        gradient[k] = (DistanceTo(moved, p + d).distance - DistanceTo(moved, p - d).distance) / (2 * step);
      }
      EXPECT_LT((gradient - normal).norm(), 1e-7) << static_cast<int>(part.kind) << " at " << p.transpose();
    }
  }
}

TEST(DistanceTo, WhereManyNormalsAreRightOneIsGiven) {
  const double tiny = std::numeric_limits<double>::denorm_min();
  for (const Primitive& part : OneOfEach()) {
    for (const double x : {0.0, tiny, 1e-200, 1e-155, 1e-20}) {
      for (const double z : {0.0, 1e-200, 0.1, 0.2, 0.4, -0.4}) {
        const Eigen::Vector3d p(x, x, z);
        const SurfaceDistance found = DistanceTo(part, p);
        EXPECT_NEAR(found.normal.norm(), 1, 1e-14) << static_cast<int>(part.kind) << " " << p.transpose();
        // To leave along it takes the distance.
        const Eigen::Vector3d out = p + (1e-12 - found.distance) * found.normal;
        EXPECT_NEAR(DistanceTo(part, out).distance, 1e-12, 1e-15) << static_cast<int>(part.kind);
      }
    }
  }
  // Corners, rims and edges themselves, and a touch outside.
  for (const double beyond : {0.0, 1e-300, 1e-160, 1e-17, 1e-12}) {
    const SurfaceDistance corner = DistanceTo(Box(1, 1, 1), Eigen::Vector3d::Constant(1 + beyond));
    EXPECT_NEAR(corner.normal.norm(), 1, 1e-14);
    EXPECT_GE(corner.normal.minCoeff(), 0);
    EXPECT_NEAR(corner.distance, std::sqrt(3.0) * beyond, 1e-15);
    EXPECT_NEAR(DistanceTo(Cylinder(1, 1), {1 + beyond, 0, 1 + beyond}).normal.norm(), 1, 1e-14);
  }
}

TEST(DistanceTo, ScalesWithItsShape) {
  std::mt19937_64 random(3);
  for (const double scale : {1e-6, 1e6}) {
    for (const Primitive& part : OneOfEach()) {
      Primitive scaled = part;
      scaled.radius *= scale;
      scaled.half *= scale;
      const Eigen::Vector3d p = RandomPoint(random, 0.8);
      EXPECT_NEAR(DistanceTo(scaled, scale * p).distance, scale * DistanceTo(part, p).distance,
                  1e-15 * scale);
    }
  }
}

TEST(MassOf, CountsRandomPointsInEveryPart) {
  std::mt19937_64 random(4);
  Shape shape = OneOfEach();
  shape.push_back(Capsule(0.3, 0));
  for (Primitive& part : shape) part.object_from_primitive = RandomPose(random);
  const int count = 2000000;
  const double half = 1.2;
  double volume = 0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d p = RandomPoint(random, half);
    for (const Primitive& part : shape) {
      if (!Inside(part, part.object_from_primitive.inverse() * p)) continue;
      volume += 1;
      first += p;
      second += p * p.transpose();
    }
  }
  const Eigen::Vector3d centre = first / volume;
  const Eigen::Matrix3d spread = second / volume - centre * centre.transpose();
  const Eigen::Matrix3d inertia = spread.trace() * Eigen::Matrix3d::Identity() - spread;
  const MassProperties mass = MassOf(shape).value();
  EXPECT_NEAR(volume / count * std::pow(2 * half, 3) / mass.volume, 1, 0.02);
  EXPECT_LT((centre - mass.centre).norm(), 0.008);  // three standard errors
  EXPECT_LT((inertia - mass.inertia).norm(), 0.02 * mass.inertia.norm());
}

TEST(MassOf, PrimitivesFollowTheirClosedForms) {
  const MassProperties ball = MassOf({Sphere(2)}).value();
  EXPECT_NEAR(ball.volume, 32 * pi / 3, 1e-13);
  EXPECT_NEAR(ball.inertia(0, 0), 1.6, 1e-15);
  const MassProperties rod = MassOf({Cylinder(0.001, 1)}).value();
  EXPECT_NEAR(rod.inertia(0, 0), (3 * 1e-6 + 4) / 12, 1e-15);
  EXPECT_NEAR(rod.inertia(2, 2), 0.5e-6, 1e-21);
  const MassProperties box = MassOf({Box(0.5, 1, 1.5)}).value();
  EXPECT_NEAR(box.volume, 6, 1e-14);
  EXPECT_NEAR(box.inertia(0, 0), (4.0 + 9.0) / 12, 1e-15);
  EXPECT_NEAR(box.inertia(2, 2), (1.0 + 4.0) / 12, 1e-15);
  // A capsule without length is a ball; one is a cylinder and a ball cut in two, each by the parallel axes:
  // a half ball's centre lies 3/8 r from its flat side, and about that centre it has (2/5 - 9/64) r^2.
  EXPECT_NEAR(MassOf({Capsule(2, 0)}).value().inertia(1, 1), 1.6, 1e-15);
  const double r = 0.5, h = 2, tube = pi * r * r * 2 * h, halves = 4 * pi / 3 * r * r * r;
  const double across =
      tube * (3 * r * r + 4 * h * h) / 12 + halves * ((0.4 - 9.0 / 64) * r * r + std::pow(h + 0.375 * r, 2));
  const MassProperties capsule = MassOf({Capsule(r, h)}).value();
  EXPECT_NEAR(capsule.volume, tube + halves, 1e-13);
  EXPECT_NEAR(capsule.inertia(0, 0), across / (tube + halves), 1e-14);
}

TEST(MassOf, TwoHalvesOfABoxAreTheBox) {
  Shape halves = {Box(0.5, 1, 2), Box(0.5, 1, 2)};
  halves[0].object_from_primitive.translation() = Eigen::Vector3d(0.5, 0, 0);
  halves[1].object_from_primitive.translation() = Eigen::Vector3d(-0.5, 0, 0);
  const MassProperties parts = MassOf(halves).value(), whole = MassOf({Box(1, 1, 2)}).value();
  EXPECT_NEAR(parts.volume, whole.volume, 1e-14);
  EXPECT_LT((parts.inertia - whole.inertia).norm(), 1e-15);
}

TEST(MassOf, RefusesWhatHasNoMass) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Primitive table{PrimitiveKind::kHalfSpace, 0, Eigen::Vector3d::Zero()};
  for (const Shape& shape :
       {Shape{}, Shape{table}, Shape{Sphere(0)}, Shape{Sphere(nan)}, Shape{Capsule(1, -1)},
        Shape{Cylinder(1, 0)}, Shape{Box(1, 1, 0)}, Shape{Box(1, nan, 1)},
        Shape{Sphere(std::numeric_limits<double>::infinity())}, Shape{Sphere(1e-150)}}) {
    ASSERT_FALSE(MassOf(shape).ok());
    EXPECT_EQ(MassOf(shape).error().kind, ErrorKind::kBadInput);
    EXPECT_FALSE(Balanced(shape).ok());
  }
  EXPECT_NE(MassOf({Sphere(1), Sphere(-2)}).error().message.find("part 1: radius -2"), std::string::npos);
}

TEST(Balanced, BringsAnyUnionToItsPrincipalFrame) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 200; ++i) {
    Shape shape = OneOfEach();
    shape.resize(1 + random() % 4);
    for (Primitive& part : shape) part.object_from_primitive = RandomPose(random);
    const BalancedShape balanced = Balanced(shape).value();
    const MassProperties mass = MassOf(balanced.shape).value();
    const Eigen::Matrix3d axes = balanced.given_from_object.linear();
    EXPECT_LT(mass.centre.norm(), 1e-14);
    EXPECT_LT((mass.inertia - Eigen::Matrix3d(balanced.inertia.asDiagonal())).norm(), 1e-14);
    EXPECT_LT((axes.transpose() * axes - Eigen::Matrix3d::Identity()).norm(), 1e-14);
    EXPECT_NEAR(axes.determinant(), 1, 1e-14);
    EXPECT_NEAR(balanced.volume, MassOf(shape).value().volume, 1e-14);
    // The same surface, seen from the new frame.
    const Eigen::Vector3d p = RandomPoint(random, 1);
    for (std::size_t k = 0; k < shape.size(); ++k) {
      EXPECT_NEAR(DistanceTo(balanced.shape[k], p).distance,
                  DistanceTo(shape[k], balanced.given_from_object * p).distance, 1e-14);
    }
    // Doing it again changes nothing, to the bit.
    const BalancedShape again = Balanced(balanced.shape).value();
    EXPECT_EQ(again.given_from_object.matrix(), Eigen::Matrix4d::Identity());
    EXPECT_EQ(again.shape[0].object_from_primitive.matrix(),
              balanced.shape[0].object_from_primitive.matrix());
  }
}

TEST(Balanced, LeavesWhatIsBalancedAsItIs) {
  for (const Shape& shape :
       {Shape{Box(0.3, 0.2, 0.1)}, Shape{Box(0.1, 0.2, 0.3)}, Shape{Cylinder(1e-3, 1)}, Shape{Sphere(1)}}) {
    const BalancedShape balanced = Balanced(shape).value();
    EXPECT_EQ(balanced.given_from_object.matrix(), Eigen::Matrix4d::Identity());
    EXPECT_EQ(balanced.inertia, MassOf(shape).value().inertia.diagonal());
  }
}

TEST(Balanced, TurnsNoFartherThanItMust) {
  // A box turned by 0.3 rad goes back by 0.3, its axes in their old order.
  Shape shape = {Box(0.3, 0.1, 0.2)};
  const Eigen::Vector3d turn(0.1, 0.2, -0.2);
  shape[0].object_from_primitive.linear() = ExpSo3(turn);
  EXPECT_LT((LogSo3(Eigen::Matrix3d(Balanced(shape).value().given_from_object.linear())) - turn).norm(),
            1e-13);
}

TEST(SurfaceSpheres, LieInTheirPartAndTouchItsSurface) {
  std::mt19937_64 random(6);
  Shape parts = OneOfEach();
  for (const Primitive& part : {Capsule(1e-3, 1), Capsule(1, 0), Cylinder(1e-3, 1), Cylinder(1, 1e-3),
                                Box(1e-6, 1, 1), Box(1, 1e-6, 1e-6)}) {
    parts.push_back(part);
  }
  for (Primitive part : parts) {
    part.object_from_primitive = RandomPose(random);
    for (const SurfaceSphere& sphere : SurfaceSpheres({part})) {
      EXPECT_NEAR(DistanceTo(part, sphere.centre).distance, -sphere.radius, 1e-14);
    }
  }
}

TEST(SurfaceSpheres, AreAsManyAsTheHeaderSays) {
  EXPECT_EQ(SurfaceSpheres({Sphere(1)}).size(), 1u);
  EXPECT_EQ(SurfaceSpheres({Capsule(1, 0)}).size(), 1u);
  EXPECT_EQ(SurfaceSpheres({Capsule(1, 1)}).size(), 5u);
  EXPECT_EQ(SurfaceSpheres({Capsule(1e-9, 1)}).size(), 33u);
  EXPECT_EQ(SurfaceSpheres({Cylinder(1, 0.5)}).size(), 2u * 73);
  EXPECT_EQ(SurfaceSpheres({Cylinder(1, 2)}).size(), 2u * 73 + 5);
  EXPECT_EQ(SurfaceSpheres({Box(0.1, 0.1, 0.1)}).size(), 98u);
  for (const Primitive& box : {Box(1, 2, 3), Box(1, 1, 1e-6), Box(1e-6, 1e-6, 1), Box(1, 1, 30)}) {
    const std::size_t count = SurfaceSpheres({box}).size();
    EXPECT_LE(count, 100u);
    EXPECT_GE(count, 60u) << box.half.transpose();
  }
  EXPECT_EQ(SurfaceSpheres(OneOfEach()).size(),
            1u + 9 + 2 * 73 + SurfaceSpheres({Box(0.2, 0.3, 0.4)}).size());
  EXPECT_TRUE(SurfaceSpheres({{PrimitiveKind::kHalfSpace, 0, Eigen::Vector3d::Zero()}}).empty());
}

TEST(SurfaceSpheres, ReachAsFarAsTheShapeInEveryDirection) {
  // A table from any side meets a sphere, corner or rim where it would meet the shape: exactly for boxes and
  // capsules, within the 64-sided rim's 1 - cos(pi / 64) for cylinders.
  std::mt19937_64 random(7);
  for (const Primitive& part : OneOfEach()) {
    const double slack = part.kind == PrimitiveKind::kCylinder ? part.radius * (1 - std::cos(pi / 64)) : 0;
    for (int i = 0; i < 200; ++i) {
      const Eigen::Vector3d n = RandomPoint(random, 1).normalized();
      const double across = part.radius * n.head<2>().norm(), along = part.half.z() * std::abs(n.z());
      double support = part.half.dot(n.cwiseAbs());
      if (part.kind == PrimitiveKind::kSphere || part.kind == PrimitiveKind::kCapsule)
        support = along + part.radius;
      if (part.kind == PrimitiveKind::kCylinder) support = along + across;
      double farthest = 0;
      for (const SurfaceSphere& sphere : SurfaceSpheres({part})) {
        farthest = std::max(farthest, sphere.centre.dot(n) + sphere.radius);
      }
      EXPECT_LE(farthest, support + 1e-14);
      EXPECT_GE(farthest, support - slack - 1e-14);
    }
  }
}

TEST(ReachOf, IsTheFarthestSurfacePoint) {
  std::mt19937_64 random(8);
  EXPECT_EQ(ReachOf({}), 0);
  EXPECT_TRUE(std::isinf(ReachOf({{PrimitiveKind::kHalfSpace, 0, Eigen::Vector3d::Zero()}})));
  Shape all;
  double most = 0;
  for (Primitive part : OneOfEach()) {
    const std::vector<Eigen::Vector3d> surface = SampledSurface(part);
    part.object_from_primitive = RandomPose(random);
    double farthest = 0;
    for (const Eigen::Vector3d& p : surface) {
      farthest = std::max(farthest, (part.object_from_primitive * p).norm());
    }
    EXPECT_GE(ReachOf({part}), farthest - 1e-13);
    EXPECT_LE(ReachOf({part}), farthest + 0.01);
    all.push_back(part);
    most = std::max(most, ReachOf({part}));
    EXPECT_EQ(ReachOf(all), most);
  }
}

}  // namespace
}  // namespace tendril
