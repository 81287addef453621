// model/rods/friction.h, alone and between what touches (contact_plain.h): Coulomb's law, its memory, and
// that it never gives out more than it took in.
#include "model/rods/friction.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "model/rods/contact_plain.h"

namespace tendril {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

constexpr double kStep = 1e-4;

double Stored(const Stick& stick, const FrictionOf& friction) {
  return 0.5 * friction.stiffness * stick.stretch.squaredNorm();
}

TEST(FrictionForce, WhatSticksStoresAsASpringAndGivesItBack) {
  const FrictionOf friction{0.5, 0.5, 1000, 0};
  Stick stick;
  const double speed = 0.01;
  double work = 0;
  for (const double way : {1.0, -1.0}) {
    for (int step = 0; step < 100; ++step) {
      const Vector3d before = -friction.stiffness * stick.stretch;
      const Vector3d velocity(way * speed, 0, 0);
      const Vector3d force =
          FrictionForce(stick, friction, Vector3d::UnitZ(), 10, velocity, Vector3d::Zero(), kStep);
      EXPECT_FALSE(stick.slides);
      work += 0.5 * (before + force).dot(velocity) * kStep;
    }
    if (way > 0) {
      EXPECT_NEAR(stick.stretch.x(), 100 * kStep * speed, 1e-15);
      EXPECT_NEAR(-work, 0.5 * 1000 * std::pow(100 * kStep * speed, 2), 1e-15);
    }
  }
  EXPECT_NEAR(stick.stretch.norm(), 0, 1e-15);
  EXPECT_NEAR(work, 0, 1e-18);
}

TEST(FrictionForce, WhatSlidesIsHeldByMuTimesTheNormalForceAgainstItsWay) {
  for (const double damping : {0.0, 5.0}) {
    const FrictionOf friction{0.3, 0.3, 1000, damping};
    const Vector3d normal = Vector3d(1, -2, 3).normalized(), way = normal.unitOrthogonal();
    Stick stick;
    Vector3d force;
    for (int step = 0; step < 1000; ++step) {
      // Whatever is along the normal is none of it.
      force = FrictionForce(stick, friction, normal, 2, 0.5 * way + 3 * normal, Vector3d::Zero(), kStep);
    }
    EXPECT_TRUE(stick.slides);
    EXPECT_LT((force + 0.3 * 2 * way).norm(), 1e-12);
    EXPECT_NEAR(stick.stretch.norm(), 0.6 / 1000, 1e-15);
    EXPECT_NEAR(stick.stretch.dot(normal), 0, 1e-15);
  }
}

// Sticks up to the static limit, breaks down to the kinetic one, slides, and sticks anew where it turns back.
TEST(FrictionForce, BreaksAtTheStaticLimitAndSticksAnewWhereItTurnsBack) {
  const FrictionOf friction{0.3, 0.6, 1000, 0};
  const double load = 2;
  Stick stick;
  double largest = 0;
  const auto pull = [&](double speed) {
    return FrictionForce(stick, friction, Vector3d::UnitZ(), load, {speed, 0, 0}, Vector3d::Zero(), kStep)
        .x();
  };
  int broke = -1;
  for (int step = 0; step < 400; ++step) {
    const double force = -pull(0.05);
    largest = std::max(largest, force);
    if (broke < 0 && stick.slides) broke = step;
    if (broke >= 0) {
      EXPECT_NEAR(force, 0.3 * load, 1e-12) << step;
    }
  }
  // Within one step's spring of the limit.
  EXPECT_LE(largest, 0.6 * load * (1 + 1e-12));
  EXPECT_GT(largest, 0.6 * load - 1000 * kStep * 0.05);
  EXPECT_NEAR(broke, 0.6 * load / (1000 * kStep * 0.05), 1.5);
  // Turned back: unloads through nothing to the static limit on the other side.
  double before = 0.3 * load, back = 0;
  for (int step = 0; step < 600; ++step) {
    const double force = -pull(-0.05);
    if (step == 150) {
      EXPECT_FALSE(stick.slides);
    }
    if (step < 350) {
      EXPECT_NEAR(before - force, 1000 * kStep * 0.05, 1e-12) << step;
    }
    before = force;
    back = std::min(back, force);
  }
  EXPECT_TRUE(stick.slides);
  EXPECT_LT(back, -0.6 * load + 1000 * kStep * 0.05);
  EXPECT_NEAR(before, -0.3 * load, 1e-12);
}

TEST(FrictionForce, OfNoNormalForceIsNoneAndOfNoStiffnessIsFinite) {
  Stick stick{{1e-3, 0, 0}, false};
  EXPECT_EQ(
      FrictionForce(stick, {0.3, 0.6, 1000, 1}, Vector3d::UnitZ(), 0, {1, 2, 3}, Vector3d::Zero(), kStep)
          .norm(),
      0);
  EXPECT_EQ(stick.stretch.norm(), 0);
  for (const double damping : {0.0, 2.0}) {
    const Vector3d force = FrictionForce(stick, {0.3, 0.6, 0, damping}, Vector3d::UnitZ(), 1, {1, 2, 3},
                                         Vector3d::Zero(), kStep);
    EXPECT_LE(force.norm(), 0.6);
  }
  EXPECT_TRUE(stick.stretch.allFinite());
}

// The work on both bodies in a step, where the surfaces move against each other by velocity * time, and the
// change of what the spring stores: never above 0, however loads, surfaces, spins and velocities change.
TEST(FrictionForce, NeverGivesOutMoreThanItTookIn) {
  std::mt19937 random(17);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> even(0, 1);
  const auto draw = [&] { return Vector3d(normal(random), normal(random), normal(random)); };
  const auto wide = [&](double from, double to) { return from * std::pow(to / from, even(random)); };
  int slid = 0, stuck = 0;
  for (int run = 0; run < 10000; ++run) {
    const double kinetic = even(random);
    const FrictionOf friction{kinetic, kinetic * (1 + even(random)), wide(1, 1e5),
                              run % 3 == 0 ? 0 : wide(1e-3, 1e3)};
    Stick stick;
    Vector3d surface = draw().normalized(), velocity = draw();
    const double speed = wide(1e-4, 10), spinning = wide(1e-3, 3e3), load = wide(1e-4, 10);
    double given = 0, size = 0;
    for (int step = 0; step < 100; ++step) {
      if (step % 5 == 0) velocity = speed * draw();
      surface = (surface + (run % 2 == 0 ? 0.05 : 1.0) * draw()).normalized();
      const double before = Stored(stick, friction), pressed = load * std::max(0.0, normal(random) + 1);
      const Vector3d force =
          FrictionForce(stick, friction, surface, pressed, velocity, spinning * draw(), kStep);
      (stick.slides ? slid : stuck) += 1;
      const double work = force.dot(velocity) * kStep, change = Stored(stick, friction) - before;
      given += work + change;
      size += std::abs(work) + std::abs(change);
      ASSERT_LE(work + change, 1e-13 * (std::abs(work) + before)) << run << ", " << step;
      ASSERT_LE(force.norm(), friction.at_rest * pressed * (1 + 1e-12));
      ASSERT_LE(std::abs(force.dot(surface)), 1e-12 * force.norm());
    }
    ASSERT_LE(given, 1e-12 * size) << run;
  }
  EXPECT_GT(slid, 10000);
  EXPECT_GT(stuck, 10000);
}

TEST(FrictionForce, TurnsWithBodiesThatTurnTogether) {
  const FrictionOf friction{0.5, 0.5, 1000, 0};
  const Vector3d axis = Vector3d(1, 2, -1).normalized();
  const double spin = 20, step = 1e-5;
  const Vector3d normal = Vector3d::UnitZ(), stretch(3e-4, -1e-4, 0);
  Stick stick{stretch, false};
  const int steps = static_cast<int>(2 * std::numbers::pi / (spin * step));
  for (int k = 1; k <= steps; ++k) {
    const Eigen::AngleAxisd turned(k * spin * step, axis);
    const Vector3d force =
        FrictionForce(stick, friction, turned * normal, 1, Vector3d::Zero(), spin * axis, step);
    ASSERT_LT((force + 1000 * (turned * stretch)).norm(), 1e-3 * 1000 * stretch.norm()) << k;
  }
}

// Two pairs of rods, with one element against another each, and a solid beneath.
std::vector<Rod> Rods(std::mt19937& random, int elements, double spread) {
  std::normal_distribution<double> normal;
  const auto draw = [&] { return Vector3d(normal(random), normal(random), normal(random)); };
  std::vector<Rod> rods;
  for (int r = 0; r < 3; ++r) {
    RodDesign design;
    design.elements = elements;
    design.length = 0.02 * elements;
    design.base_radius = 0.01 + 0.002 * r;
    design.base = EndHold::kFree;
    design.direction = draw();
    design.normal = design.direction.unitOrthogonal();
    design.start = spread * draw() - 0.5 * design.length * design.direction.normalized();
    Rod rod = MakeRod(design).value();
    for (Index i = 0; i < rod.velocity.cols(); ++i) rod.velocity.col(i) = draw();
    for (Index i = 0; i < rod.spin.cols(); ++i) rod.spin.col(i) = 50 * draw();
    rods.push_back(rod);
  }
  return rods;
}

std::vector<Solid> Solids() {
  std::vector<Solid> solids(2);
  solids[0].shape = {{PrimitiveKind::kBox, 0, {0.02, 0.01, 0.015}}, {PrimitiveKind::kSphere, 0.016}};
  solids[0].pose.linear() = Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  solids[0].velocity = {0.3, -1, 0.5};
  solids[0].spin = {20, -10, 30};
  solids[1].shape = {{PrimitiveKind::kCylinder, 0.02, {0, 0, 0.01}}};
  solids[1].pose.translation() = Vector3d(0.02, 0.01, -0.01);
  solids[1].spin = {0, 40, 0};
  solids[1].friction = 0.8;
  solids[1].static_friction = 1;
  return solids;
}

Contact Rough(double damping) {
  Contact contact;
  contact.friction = 0.4;
  contact.static_friction = 0.6;
  contact.damping = damping;
  contact.points = 2;
  return contact;
}

std::vector<RodLoads> NoLoads(const std::vector<Rod>& rods) {
  std::vector<RodLoads> loads;
  for (const Rod& rod : rods) {
    loads.push_back({Matrix3Xd::Zero(3, rod.elements() + 1), Matrix3Xd::Zero(3, rod.elements())});
  }
  return loads;
}

Vector3d SpinInLab(const Rod& rod, Index i) {
  return rod.directors[static_cast<std::size_t>(i)].transpose() * rod.spin.col(i);
}

void Move(std::vector<Rod>& rods, std::vector<Solid>& solids) {
  for (Rod& rod : rods) {
    rod.position += kStep * rod.velocity;
    for (Index i = 0; i < rod.elements(); ++i) {
      Eigen::Matrix3d& q = rod.directors[static_cast<std::size_t>(i)];
      const Vector3d spin = SpinInLab(rod, i);
      q = q * Eigen::AngleAxisd(kStep * spin.norm(), spin.normalized()).toRotationMatrix().transpose();
    }
  }
  for (Solid& solid : solids) {
    solid.pose.translation() += kStep * solid.velocity;
    solid.pose.linear() =
        Eigen::AngleAxisd(kStep * solid.spin.norm(), solid.spin.normalized()) * solid.pose.linear();
  }
}

// Power of loads on everything that moves, W.
double Power(const std::vector<Rod>& rods, const std::vector<RodLoads>& loads,
             const std::vector<Solid>& solids, const std::vector<Wrench>& wrenches) {
  double power = 0;
  for (std::size_t r = 0; r < rods.size(); ++r) {
    power += loads[r].force.cwiseProduct(rods[r].velocity).sum();
    for (Index i = 0; i < rods[r].elements(); ++i) {
      power += loads[r].couple.col(i).dot(SpinInLab(rods[r], i));
    }
  }
  for (std::size_t s = 0; s < solids.size(); ++s) {
    power += wrenches[s].force.dot(solids[s].velocity) + wrenches[s].torque.dot(solids[s].spin);
  }
  return power;
}

// What damping and friction do to rods and solids together, beside the energy of pressing.
TEST(PlainContact, FrictionAndDampingOfRodsAndSolidsGiveOutNoEnergy) {
  std::mt19937 random(5);
  int touched = 0;
  for (int run = 0; run < 400; ++run) {
    std::vector<Rod> rods = Rods(random, 2, 0.01);
    std::vector<Solid> solids = Solids();
    Contact contact = Rough(run % 2 == 0 ? 0 : 0.5), smooth = contact;
    smooth.friction = smooth.static_friction = smooth.damping = 0;
    PlainContact with(contact, {}), without(smooth, {});
    std::vector<Solid> smooth_solids = solids;
    for (int step = 0; step < 25; ++step) {
      std::vector<RodLoads> loads = NoLoads(rods), pressing = loads;
      std::vector<Wrench> wrenches(2), smooth_wrenches(2);
      const double before = with.StoredBySprings();
      with.Add(rods, solids, kStep, loads, wrenches);
      smooth_solids = solids;
      for (Solid& solid : smooth_solids) solid.friction = solid.static_friction = -1;
      without.Add(rods, smooth_solids, kStep, pressing, smooth_wrenches);
      const double by_both = Power(rods, loads, solids, wrenches) * kStep;
      const double by_press = Power(rods, pressing, solids, smooth_wrenches) * kStep;
      const double change = with.StoredBySprings() - before;
      ASSERT_LE(by_both - by_press + change, 1e-12 * (std::abs(by_both) + std::abs(by_press) + before))
          << run << ", " << step;
      touched += change != 0 ? 1 : 0;
      Move(rods, solids);
    }
  }
  EXPECT_GT(touched, 5000);
}

TEST(PlainContact, FrictionKeepsMomentumAndAngularMomentum) {
  std::mt19937 random(8);
  for (int run = 0; run < 200; ++run) {
    std::vector<Rod> rods = Rods(random, 3, 0.01);
    std::vector<Solid> solids = Solids();
    PlainContact contact(Rough(0.3), {});
    for (int step = 0; step < 3; ++step, Move(rods, solids)) {
      std::vector<RodLoads> loads = NoLoads(rods);
      std::vector<Wrench> wrenches(2);
      contact.Add(rods, solids, kStep, loads, wrenches);
      Vector3d force = Vector3d::Zero(), torque = Vector3d::Zero();
      double size = 0;
      for (std::size_t r = 0; r < rods.size(); ++r) {
        force += loads[r].force.rowwise().sum();
        torque += loads[r].couple.rowwise().sum();
        size += loads[r].force.cwiseAbs().sum();
        for (Index i = 0; i < loads[r].force.cols(); ++i) {
          torque += Vector3d(rods[r].position.col(i)).cross(Vector3d(loads[r].force.col(i)));
        }
      }
      for (std::size_t s = 0; s < 2; ++s) {
        force += wrenches[s].force;
        torque += wrenches[s].torque + solids[s].pose.translation().cross(wrenches[s].force);
      }
      ASSERT_LE(force.norm(), 1e-13 * size) << run;
      ASSERT_LE(torque.norm(), 1e-14 * size) << run;
    }
  }
}

TEST(PlainContact, OrderOfRodsAndSolidsDoesNotCount) {
  std::mt19937 random(21);
  double sizes = 0;
  for (int run = 0; run < 100; ++run) {
    std::vector<Rod> rods = Rods(random, 3, 0.01);
    std::vector<Solid> solids = Solids();
    PlainContact contact(Rough(0.3), {}), reversed(Rough(0.3), {});
    for (int step = 0; step < 5; ++step, Move(rods, solids)) {
      std::vector<RodLoads> loads = NoLoads(rods);
      std::vector<Wrench> wrenches(2);
      contact.Add(rods, solids, kStep, loads, wrenches);
      const std::vector<Rod> rods_back(rods.rbegin(), rods.rend());
      const std::vector<Solid> solids_back(solids.rbegin(), solids.rend());
      std::vector<RodLoads> loads_back = NoLoads(rods_back);
      std::vector<Wrench> wrenches_back(2);
      reversed.Add(rods_back, solids_back, kStep, loads_back, wrenches_back);
      for (std::size_t r = 0; r < 3; ++r) {
        const double size = loads[r].force.cwiseAbs().maxCoeff();
        sizes += size;
        EXPECT_LE((loads[r].force - loads_back[2 - r].force).cwiseAbs().maxCoeff(), 1e-11 * size + 1e-14);
        EXPECT_LE((loads[r].couple - loads_back[2 - r].couple).cwiseAbs().maxCoeff(), 1e-13 * size + 1e-14);
      }
      for (std::size_t s = 0; s < 2; ++s) {
        const double size = wrenches[s].force.norm();
        EXPECT_LE((wrenches[s].force - wrenches_back[1 - s].force).norm(), 1e-11 * size + 1e-14);
        EXPECT_LE((wrenches[s].torque - wrenches_back[1 - s].torque).norm(), 1e-12 * size + 1e-14);
      }
    }
  }
  EXPECT_GT(sizes, 0);
}

}  // namespace
}  // namespace tendril
