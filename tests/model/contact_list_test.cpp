// model/rods/contact_list.h against the plain form, and how often a contact counts.
#include "model/rods/contact_list.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "model/machine.h"
#include "model/rods/rod_lanes.h"
#include "model/rods/rod_plain.h"

namespace tendril {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

// A rod laid along a helix about an axis, every node off by some noise.
Rod Coil(std::mt19937& random, const Vector3d& middle, int elements, double radius) {
  std::normal_distribution<double> normal;
  const auto draw = [&] { return Vector3d(normal(random), normal(random), normal(random)); };
  RodDesign design;
  design.elements = elements;
  design.length = 0.0075 * elements;
  design.base_radius = radius;
  design.taper = 0.5;
  Rod rod = MakeRod(design).value();
  const Eigen::Quaterniond turn = Eigen::Quaterniond::UnitRandom();
  for (Index i = 0; i <= elements; ++i) {
    const double angle = 0.15 * static_cast<double>(i);
    rod.position.col(i) = middle +
                          turn * Vector3d(0.05 * std::cos(angle), 0.05 * std::sin(angle), 0.004 * angle) +
                          2e-4 * draw();
    rod.velocity.col(i) = 0.3 * draw();
  }
  return rod;
}

std::vector<Rod> Tangle(unsigned seed) {
  std::mt19937 random(seed);
  std::srand(seed);
  std::uniform_real_distribution<double> place(-0.04, 0.04);
  std::vector<Rod> rods;
  for (const int elements : {100, 2, 37, 64, 9}) {
    rods.push_back(Coil(random, {place(random), place(random), place(random)}, elements, 0.012));
  }
  return rods;
}

const std::vector<FixedBody>& Bodies() {
  static const std::vector<FixedBody> bodies = {{{-0.1, 0, 0.01}, {0.1, 0.02, 0}, 0.02},
                                                {{0.02, -0.03, 0}, {0.02, -0.03, 0}, 0.03}};
  return bodies;
}

struct Forces {
  std::vector<Matrix3Xd> on_rods;
  double largest = 0;
};

Forces Plainly(const Contact& contact, const std::vector<Rod>& rods) {
  Forces all;
  for (const Rod& rod : rods) all.on_rods.emplace_back(Matrix3Xd::Zero(3, rod.elements() + 1));
  for (std::size_t a = 0; a < rods.size(); ++a) {
    AddSelfContact(contact, rods[a], all.on_rods[a]);
    for (const FixedBody& body : Bodies()) AddBodyContact(contact, rods[a], body, all.on_rods[a]);
    for (std::size_t b = 0; b < a; ++b)
      AddRodContact(contact, rods[a], rods[b], all.on_rods[a], all.on_rods[b]);
  }
  for (const Matrix3Xd& force : all.on_rods) all.largest = std::max(all.largest, force.cwiseAbs().maxCoeff());
  return all;
}

double WorstDifference(const ContactList& list, const Forces& expected) {
  double worst = 0;
  for (std::size_t r = 0; r < expected.on_rods.size(); ++r) {
    Matrix3Xd force = Matrix3Xd::Zero(3, expected.on_rods[r].cols());
    list.AddForces(r, force.data(), 1);
    worst = std::max(worst, (force - expected.on_rods[r]).cwiseAbs().maxCoeff());
  }
  return worst / expected.largest;
}

void PutAll(ContactList& list, const std::vector<Rod>& rods) {
  for (std::size_t r = 0; r < rods.size(); ++r)
    list.Put(r, rods[r].position.data(), rods[r].velocity.data(), 1);
}

TEST(ContactList, AgreesWithThePlainFormWhileRodsMove) {
  for (const int width : {2, 4, 8}) {
    if (width > MachineDoubles()) continue;
    UseRodKernel(width);
    for (const ContactLaw law :
         {ContactLaw::kHertzSegments, ContactLaw::kHertzEqual, ContactLaw::kHertzCenters}) {
      for (const double damping : {0.0, 0.3}) {
        const Contact contact{law, 1e4, damping};
        std::vector<Rod> rods = Tangle(7);
        ContactList list(contact, rods, Bodies(), {});
        int touched = 0;
        for (int step = 0; step < 60; ++step) {
          PutAll(list, rods);
          ASSERT_TRUE(list.Find());
          const Forces expected = Plainly(contact, rods);
          touched += expected.largest > 0 ? 1 : 0;
          EXPECT_LT(WorstDifference(list, expected), 1e-11)
              << "width " << width << " law " << static_cast<int>(law) << " step " << step;
          for (Rod& rod : rods) rod.position += 1e-4 * rod.velocity;
        }
        EXPECT_EQ(touched, 60);
        EXPECT_GT(list.lists(), 1);   // made anew,
        EXPECT_LT(list.lists(), 30);  // but not every time
        EXPECT_LT(list.least_share(), 1);
      }
    }
  }
  UseRodKernel(0);
}

TEST(ContactList, RodsFarFromTheOriginAndApartTouchNothing) {
  std::vector<Rod> rods = Tangle(3);
  for (std::size_t r = 0; r < rods.size(); ++r) {
    rods[r].position.colwise() += Vector3d(1e6 + 10.0 * static_cast<double>(r), 0, 0);
  }
  ContactList list({}, rods, {}, {.selves = false});
  PutAll(list, rods);
  ASSERT_TRUE(list.Find());
  EXPECT_TRUE(std::isinf(list.least_distance()));
  EXPECT_TRUE(list.NothingPassed().value());
}

TEST(ContactList, WhatIsNotFiniteIsSaid) {
  std::vector<Rod> rods = Tangle(3);
  ContactList list({}, rods, Bodies(), {});
  PutAll(list, rods);
  ASSERT_TRUE(list.Find());
  rods[0].position(1, 5) = std::nan("");
  PutAll(list, rods);
  EXPECT_FALSE(list.Find());
}

TEST(ContactList, ALeapOverAnotherRodIsNotedAsAPassage) {
  RodDesign design;
  design.elements = 20;
  design.length = 0.2;
  design.base_radius = 0.01;
  std::vector<Rod> rods = {MakeRod(design).value()};
  design.start = {-0.1, 0.019, 0.1};
  design.direction = Vector3d::UnitX();
  design.normal = Vector3d::UnitZ();
  rods.push_back(MakeRod(design).value());
  ContactList list({}, rods, {}, {});
  PutAll(list, rods);
  ASSERT_TRUE(list.Find());
  EXPECT_NEAR(list.least_distance(), 0.019, 1e-12);
  EXPECT_TRUE(list.NothingPassed().value());
  rods[1].position.row(1).setConstant(-0.019);
  PutAll(list, rods);
  EXPECT_TRUE(list.Find());
  EXPECT_FALSE(list.NothingPassed().value());
}

// Two rods that cross under an angle, the crossing at any place along their elements.
Vector3d CrossingForce(double place, int elements, double angle) {
  RodDesign design;
  design.elements = elements;
  design.length = 0.4;
  design.base_radius = 0.01;
  design.start = {-0.2 + place, 0, 0};
  design.direction = Vector3d::UnitX();
  design.normal = Vector3d::UnitZ();
  const Rod a = MakeRod(design).value();
  design.direction = {std::cos(angle), std::sin(angle), 0};
  design.start = Vector3d(0, 0, 0.0185) - 0.2 * design.direction;
  const Rod b = MakeRod(design).value();
  Matrix3Xd on_a = Matrix3Xd::Zero(3, elements + 1), on_b = on_a;
  AddRodContact({}, a, b, on_a, on_b);
  EXPECT_NEAR((on_a.rowwise().sum() + on_b.rowwise().sum()).norm(), 0, 1e-12);
  return on_b.rowwise().sum();
}

TEST(Contact, OneCrossingCountsOnceWhereverAndHoweverFineTheElements) {
  const double hertz = 1e4 * std::pow(0.0015, 1.5);
  for (const int elements : {2, 5, 20, 40, 100, 333}) {
    for (const double angle : {0.01, 0.5, 1.57}) {
      for (const double place : {0.0, 1e-12, 0.001, 0.002, 0.005, 0.01, 0.0123}) {
        const Vector3d force = CrossingForce(place, elements, angle);
        EXPECT_NEAR(force.z(), hertz, 1e-6 * hertz) << elements << " " << angle << " " << place;
        EXPECT_NEAR(force.head<2>().norm(), 0, 1e-6 * hertz);
      }
    }
  }
}

TEST(Contact, ParallelRodsCountByWhatLiesSideBySide) {
  RodDesign design;
  design.elements = 40;
  design.length = 0.4;
  design.base_radius = 0.01;
  const Rod a = MakeRod(design).value();
  for (const double shift : {0.0, 0.001, 0.005, 0.0099, 0.01, 0.2}) {
    design.start = {0.0185, 0, shift};
    const Rod b = MakeRod(design).value();
    Matrix3Xd on_a = Matrix3Xd::Zero(3, 41), on_b = on_a;
    AddRodContact({}, a, b, on_a, on_b);
    const double beside = (0.4 - shift) / 0.01;
    EXPECT_NEAR(on_b.row(0).sum(), beside * 1e4 * std::pow(0.0015, 1.5), 1e-9) << shift;
  }
}

// Hertz 1882: two bodies of reduced mass m that meet at speed v under F = k eps^(3/2) go (5 m v^2 / (4
// k))^(2/5) deep and part after 2.9432667 times that depth / v.
TEST(Contact, TwoStiffRodsThatMeetDoAsHertzSays) {
  RodDesign design;
  design.elements = 5;
  design.length = 0.05;
  design.base_radius = 0.01;
  design.youngs_modulus = 1e9;
  design.shear_modulus = 4e8;
  design.base = EndHold::kFree;
  design.start = {-0.025, 0, 0};
  design.direction = Vector3d::UnitX();
  design.normal = Vector3d::UnitZ();
  std::vector<Rod> rods = {MakeRod(design).value()};
  design.start = {0, -0.025, 0.02};
  design.direction = Vector3d::UnitY();
  rods.push_back(MakeRod(design).value());
  const double speed = 0.2, mass = 0.5 * rods[0].mass.sum(), stiffness = 1e4;
  rods[1].velocity.row(2).setConstant(-speed);
  const double depth = std::pow(5 * mass * speed * speed / (4 * stiffness), 0.4);
  ContactList list({.stiffness = stiffness}, rods, {}, {});
  PlainOptions options;
  options.time_step = 1e-6;
  double deepest = 0, lasted = 0;
  for (int step = 0; step < 40000; ++step) {
    StepPlain(rods, step * 1e-6, options, [&](double, std::span<Rod> at, std::span<Matrix3Xd> forces) {
      for (std::size_t r = 0; r < 2; ++r) list.Put(r, at[r].position.data(), at[r].velocity.data(), 1);
      ASSERT_TRUE(list.Find());
      for (std::size_t r = 0; r < 2; ++r) list.AddForces(r, forces[r].data(), 1);
      lasted += forces[0].norm() > 0 ? 1e-6 : 0;
    });
  }
  deepest = 0.02 - list.least_distance();
  EXPECT_NEAR(deepest, depth, 0.01 * depth);
  EXPECT_NEAR(lasted, 2.9432667 * depth / speed, 0.01 * lasted);
  // Equal masses change their speeds.
  const double first = rods[0].velocity.row(2).dot(rods[0].mass) / rods[0].mass.sum();
  const double second = rods[1].velocity.row(2).dot(rods[1].mass) / rods[1].mass.sum();
  EXPECT_NEAR(first, -speed, 0.01 * speed);
  EXPECT_NEAR(first + second, -speed, 1e-9 * speed);
}

}  // namespace
}  // namespace tendril
