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
  design.base = EndHold::kFree;
  design.taper = 0.5;
  Rod rod = MakeRod(design).value();
  const Eigen::Quaterniond turn = Eigen::Quaterniond::UnitRandom();
  for (Index i = 0; i <= elements; ++i) {
    const double angle = 0.15 * static_cast<double>(i);
    rod.position.col(i) = middle +
                          turn * Vector3d(0.05 * std::cos(angle), 0.05 * std::sin(angle), 0.004 * angle) +
                          2e-4 * draw();
    rod.velocity.col(i) = 0.3 * draw();
    if (i < elements) rod.spin.col(i) = 5 * draw();
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

// One of each kind among the rods, some of them turning and moving.
std::vector<Solid> Solids() {
  std::vector<Solid> solids(3);
  Primitive bar{PrimitiveKind::kCapsule, 0.02, {0, 0, 0.1}};
  bar.object_from_primitive.linear() =
      Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), Vector3d(0.2, 0.02, -0.01)).toRotationMatrix();
  bar.object_from_primitive.translation() = Vector3d(0, 0.01, 0.005);
  const Primitive ball{PrimitiveKind::kSphere, 0.03};
  solids[0].shape = {bar, ball};
  solids[0].pose.translation() = Vector3d(0.01, -0.02, 0);
  solids[0].velocity = {0.1, -0.2, 0.05};
  solids[0].spin = {1, 2, -0.5};
  solids[1].shape = {{PrimitiveKind::kBox, 0, {0.03, 0.02, 0.01}},
                     {PrimitiveKind::kCylinder, 0.02, {0, 0, 0.03}}};
  solids[1].pose.translation() = Vector3d(-0.03, 0.03, 0.02);
  solids[1].spin = {0, 0, 3};
  solids[1].friction = 0.6;
  solids[1].static_friction = 0.9;
  solids[2].shape = {{PrimitiveKind::kHalfSpace}};
  solids[2].pose.translation().z() = -0.06;
  return solids;
}

struct Loads {
  std::vector<RodLoads> rods;
  std::vector<Wrench> solids;
  double largest = 0, largest_couple = 0;

  Loads(const std::vector<Rod>& on, std::size_t solid_count) : solids(solid_count) {
    for (const Rod& rod : on) {
      rods.push_back({Matrix3Xd::Zero(3, rod.elements() + 1), Matrix3Xd::Zero(3, rod.elements())});
    }
  }
  void Measure() {
    for (const RodLoads& load : rods) {
      largest = std::max(largest, load.force.cwiseAbs().maxCoeff());
      largest_couple = std::max(largest_couple, load.couple.cwiseAbs().maxCoeff());
    }
  }
};

Loads AsPublished(const Contact& contact, const std::vector<Rod>& rods) {
  Loads all(rods, 0);
  for (std::size_t a = 0; a < rods.size(); ++a) {
    AddSelfContact(contact, rods[a], all.rods[a].force);
    for (const FixedBody& body : Bodies()) AddBodyContact(contact, rods[a], body, all.rods[a].force);
    for (std::size_t b = 0; b < a; ++b) {
      AddRodContact(contact, rods[a], rods[b], all.rods[a].force, all.rods[b].force);
    }
  }
  all.Measure();
  return all;
}

double WorstDifference(const ContactList& list, const Loads& expected) {
  double worst = 0;
  for (std::size_t r = 0; r < expected.rods.size(); ++r) {
    Matrix3Xd force = Matrix3Xd::Zero(3, expected.rods[r].force.cols());
    Matrix3Xd couple = Matrix3Xd::Zero(3, expected.rods[r].couple.cols());
    list.AddForces(r, force.data(), 1);
    list.AddCouples(r, couple.data(), 1);
    worst = std::max(worst, (force - expected.rods[r].force).cwiseAbs().maxCoeff() / expected.largest);
    if (expected.largest_couple == 0) continue;
    worst =
        std::max(worst, (couple - expected.rods[r].couple).cwiseAbs().maxCoeff() / expected.largest_couple);
  }
  for (std::size_t s = 0; s < expected.solids.size(); ++s) {
    const Wrench found = list.OnSolid(s);
    worst = std::max(worst, (found.force - expected.solids[s].force).norm() / expected.largest);
    worst = std::max(worst, (found.torque - expected.solids[s].torque).norm() / expected.largest);
  }
  return worst;
}

void PutAll(ContactList& list, const std::vector<Rod>& rods) {
  for (std::size_t r = 0; r < rods.size(); ++r) {
    Matrix3Xd spins(3, rods[r].elements());
    for (Index i = 0; i < spins.cols(); ++i) {
      spins.col(i) = rods[r].directors[static_cast<std::size_t>(i)].transpose() * rods[r].spin.col(i);
    }
    list.Put(r, rods[r].position.data(), rods[r].velocity.data(), spins.data(), 1);
  }
}

constexpr double kStep = 1e-4;

TEST(ContactList, PublishedLawsAgreeWithThePlainFormWhileRodsMove) {
  for (const int width : {2, 4, 8}) {
    if (width > MachineDoubles()) continue;
    UseRodKernel(width);
    for (const ContactLaw law : {ContactLaw::kHertzEqual, ContactLaw::kHertzCenters}) {
      for (const double damping : {0.0, 0.3}) {
        const Contact contact{law, 1e4, damping};
        std::vector<Rod> rods = Tangle(7);
        ContactList list(contact, rods, Bodies(), {}, {});
        for (int step = 0; step < 60; ++step) {
          PutAll(list, rods);
          ASSERT_TRUE(list.Find(kStep));
          const Loads expected = AsPublished(contact, rods);
          ASSERT_GT(expected.largest, 0);
          EXPECT_LT(WorstDifference(list, expected), 1e-11)
              << "width " << width << " law " << static_cast<int>(law) << " step " << step;
          for (Rod& rod : rods) rod.position += kStep * rod.velocity;
        }
        EXPECT_GT(list.lists(), 1);   // made anew,
        EXPECT_LT(list.lists(), 30);  // but not every time
        EXPECT_LT(list.least_share(), 1);
      }
    }
  }
  UseRodKernel(0);
}

TEST(ContactList, PressingAndFrictionAgreeWithThePlainFormWhileRodsAndSolidsMove) {
  for (const int width : {2, 4, 8}) {
    if (width > MachineDoubles()) continue;
    UseRodKernel(width);
    for (const int points : {1, 3}) {
      for (const bool moves : {false, true}) {
        Contact contact{ContactLaw::kHertzSegments, 1e4};
        contact.points = points;
        if (moves) contact.damping = 0.3, contact.friction = 0.3, contact.static_friction = 0.5;
        std::vector<Rod> rods = Tangle(7);
        std::vector<Solid> solids = Solids();
        if (!moves) solids[1].friction = solids[1].static_friction = -1;
        ContactList list(contact, rods, {}, solids, {});
        PlainContact plain(contact, {});
        for (int step = 0; step < 60; ++step) {
          PutAll(list, rods);
          for (std::size_t s = 0; s < solids.size(); ++s) {
            list.PutSolid(s, solids[s].pose, solids[s].velocity, solids[s].spin);
          }
          ASSERT_TRUE(list.Find(kStep));
          Loads expected(rods, solids.size());
          plain.Add(rods, solids, kStep, expected.rods, expected.solids);
          expected.Measure();
          ASSERT_GT(expected.largest, 0);
          ASSERT_EQ(expected.largest_couple > 0, moves);
          EXPECT_LT(WorstDifference(list, expected), 1e-10)
              << "width " << width << " points " << points << " moves " << moves << " step " << step;
          for (Rod& rod : rods) rod.position += kStep * rod.velocity;
          for (Solid& solid : solids) {
            solid.pose.translation() += kStep * solid.velocity;
            const double angle = kStep * solid.spin.norm();
            if (angle > 0) {
              solid.pose.linear() = Eigen::AngleAxisd(angle, solid.spin.normalized()) * solid.pose.linear();
            }
          }
        }
        EXPECT_GT(list.lists(), 1);
        EXPECT_LT(list.lists(), 30);
        EXPECT_EQ(plain.StoredBySprings() > 0, moves);
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
  ContactList list({}, rods, {}, Solids(), {.selves = false, .bodies = false});
  PutAll(list, rods);
  ASSERT_TRUE(list.Find(kStep));
  EXPECT_TRUE(std::isinf(list.least_distance()));
  EXPECT_TRUE(list.NothingPassed().value());
}

TEST(ContactList, WhatIsNotFiniteIsSaid) {
  std::vector<Rod> rods = Tangle(3);
  ContactList list({}, rods, {}, Solids(), {});
  PutAll(list, rods);
  ASSERT_TRUE(list.Find(kStep));
  rods[0].position(1, 5) = std::nan("");
  PutAll(list, rods);
  EXPECT_FALSE(list.Find(kStep));
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
  ContactList list({}, rods, {}, {}, {});
  PutAll(list, rods);
  ASSERT_TRUE(list.Find(kStep));
  EXPECT_GE(list.least_distance(), 0.019);
  EXPECT_LT(list.least_distance(), 0.02);
  EXPECT_TRUE(list.NothingPassed().value());
  rods[1].position.row(1).setConstant(-0.019);
  PutAll(list, rods);
  EXPECT_TRUE(list.Find(kStep));
  EXPECT_FALSE(list.NothingPassed().value());
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
  Contact contact{.stiffness = stiffness};
  contact.points = 8;
  ContactList list(contact, rods, {}, {}, {});
  PlainOptions options;
  options.time_step = 1e-6;
  double deepest = 0, lasted = 0;
  for (int step = 0; step < 40000; ++step) {
    StepPlain(rods, step * 1e-6, options, [&](double, std::span<Rod> at, std::span<Matrix3Xd> forces) {
      for (std::size_t r = 0; r < 2; ++r)
        list.Put(r, at[r].position.data(), at[r].velocity.data(), nullptr, 1);
      ASSERT_TRUE(list.Find(kStep));
      for (std::size_t r = 0; r < 2; ++r) list.AddForces(r, forces[r].data(), 1);
      lasted += forces[0].norm() > 0 ? 1e-6 : 0;
    });
  }
  deepest = 0.02 - list.least_distance();
  EXPECT_NEAR(deepest, depth, 0.02 * depth);
  EXPECT_NEAR(lasted, 2.9432667 * depth / speed, 0.02 * lasted);
  // Equal masses change their speeds.
  const double first = rods[0].velocity.row(2).dot(rods[0].mass) / rods[0].mass.sum();
  const double second = rods[1].velocity.row(2).dot(rods[1].mass) / rods[1].mass.sum();
  EXPECT_NEAR(first, -speed, 0.01 * speed);
  EXPECT_NEAR(first + second, -speed, 1e-9 * speed);
}

}  // namespace
}  // namespace tendril
