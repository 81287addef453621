// model/rods/press.h: forces are minus the energy's gradient and make no momentum; crossings and rods side by
// side press as the header says, however fine they are cut; what rods do to each other keeps energy.
#include "model/rods/press.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "model/scene/stepper.h"

namespace tendril {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

constexpr double kStiffness = 1e4;

struct Random {
  std::mt19937 generator;
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> even{0, 1};
  explicit Random(unsigned seed) : generator(seed) {}
  Vector3d Draw() { return {normal(generator), normal(generator), normal(generator)}; }
  double Between(double low, double high) { return low + (high - low) * even(generator); }
};

// Two elements within reach of each other: any, or parallel, collinear, end to end, crossing axes, or one on
// the other.
std::pair<PressSide, PressSide> Pair(Random& random, int kind) {
  PressSide a, b;
  a.radius = 0.01 * std::pow(10, random.Between(-1, 0));
  b.radius = 0.01 * std::pow(10, random.Between(-1, 0));
  const double radii = a.radius + b.radius;
  a.rest_length = radii * std::pow(10, random.Between(-1.5, 1));
  b.rest_length = radii * std::pow(10, random.Between(-1.5, 1));
  const Vector3d along = random.Draw().normalized(), side = along.unitOrthogonal();
  a.start = 0.1 * random.Draw();
  a.end = a.start + random.Between(0.8, 1.2) * a.rest_length * along;
  const Vector3d on_a = a.start + random.Between(0, 1) * (a.end - a.start);
  const double length = random.Between(0.8, 1.2) * b.rest_length;
  const Vector3d way = kind == 0 || kind == 4 ? random.Draw().normalized() : along;
  const Vector3d off = kind == 0   ? Vector3d(random.Between(0, 1) * radii * random.Draw().normalized())
                       : kind == 1 ? Vector3d(random.Between(0.05, 0.95) * radii * side)
                                   : Vector3d(Vector3d::Zero());
  b.start = on_a + off - random.Between(0, 1) * length * way;
  if (kind == 3) b.start = a.end;
  b.end = b.start + length * way;
  if (kind == 5) b = a;
  return {a, b};
}
constexpr int kKinds = 6;

std::vector<Vector3d*> EndsOf(PressSide& a, PressSide& b) { return {&a.start, &a.end, &b.start, &b.end}; }

TEST(PressOf, ForcesAreMinusTheGradientOfTheEnergy) {
  Random random(3);
  int pressed = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    auto [a, b] = Pair(random, trial % 4);
    const int points = 1 + trial % 5;
    const Press press = PressOf(kStiffness, points, a, b);
    if (!press.presses) continue;
    ++pressed;
    const double radii = a.radius + b.radius;
    const double scale = kStiffness * std::sqrt(radii) * std::min(a.rest_length, b.rest_length);
    const Vector3d* const forces[] = {&press.a_start, &press.a_end, &press.b_start, &press.b_end};
    const std::vector<Vector3d*> ends = EndsOf(a, b);
    for (std::size_t end = 0; end < 4; ++end) {
      for (Index k = 0; k < 3; ++k) {
        const double at = (*ends[end])[k], h = 1e-6 * radii;
        (*ends[end])[k] = at + h;
        const double above = PressOf(kStiffness, points, a, b).energy;
        (*ends[end])[k] = at - h;
        const double below = PressOf(kStiffness, points, a, b).energy;
        (*ends[end])[k] = at;
        // Where a point comes within reach the force has a slope but no curvature.
        ASSERT_NEAR((*forces[end])[k], -(above - below) / (2 * h), 2e-6 * scale * radii)
            << trial << " end " << end << " component " << k;
      }
    }
  }
  EXPECT_GT(pressed, 2000);
}

TEST(PressOf, MakesNoForceAndNoTorque) {
  Random random(4);
  for (int trial = 0; trial < 3000; ++trial) {
    const auto [a, b] = Pair(random, trial % kKinds);
    const Press press = PressOf(kStiffness, 1 + trial % 5, a, b);
    const double size = press.a_start.norm() + press.a_end.norm() + press.b_start.norm() + press.b_end.norm();
    const Vector3d force = press.a_start + press.a_end + press.b_start + press.b_end;
    const Vector3d torque = a.start.cross(press.a_start) + a.end.cross(press.a_end) +
                            b.start.cross(press.b_start) + b.end.cross(press.b_end);
    ASSERT_LE(force.norm(), 1e-13 * size + 1e-25) << trial;
    ASSERT_LE(torque.norm(), 1e-12 * size * (a.radius + a.start.norm()) + 1e-25) << trial;
  }
}

TEST(PressOf, EveryPlaceOfTwoElementsGivesFiniteNumbers) {
  Random random(5);
  for (int trial = 0; trial < 3000; ++trial) {
    auto [a, b] = Pair(random, trial % kKinds);
    if (trial % 7 == 0) b.end = b.start;  // shrunk to a point
    if (trial % 35 == 0) a.end = a.start;
    const Press press = PressOf(kStiffness, 1 + trial % 3, a, b);
    EXPECT_TRUE(std::isfinite(press.energy) && press.energy >= 0) << trial;
    EXPECT_TRUE((press.a_start + press.a_end + press.b_start + press.b_end).allFinite()) << trial;
    EXPECT_TRUE(press.normal_force.allFinite() && std::isfinite(press.stiffness)) << trial;
    EXPECT_TRUE(std::isfinite(press.a_share) && std::isfinite(press.b_share)) << trial;
    EXPECT_TRUE(press.stick_stiffness >= 0 && std::isfinite(press.stick_stiffness)) << trial;
  }
  const PressSide a{{0, 0, 0}, {0.01, 0, 0}, 0.005, 0.01};
  for (const double off : {0.0100001, 0.02, 1e9}) {
    PressSide b = a;
    b.start.z() = b.end.z() = off;
    const Press press = PressOf(kStiffness, 3, a, b);
    EXPECT_FALSE(press.presses);
    EXPECT_EQ(press.energy, 0);
  }
}

// A straight rod in pieces.
std::vector<PressSide> Chain(const Vector3d& middle, const Vector3d& along, double length, double radius,
                             int elements) {
  std::vector<PressSide> chain;
  for (int i = 0; i < elements; ++i) {
    const double from = (static_cast<double>(i) / elements - 0.5) * length;
    chain.push_back(
        {middle + from * along, middle + (from + length / elements) * along, radius, length / elements});
  }
  return chain;
}

struct Sum {
  double energy = 0;
  Vector3d on_b = Vector3d::Zero();
  std::vector<Vector3d> on_each = {};  // of b
};
Sum Press2(const std::vector<PressSide>& a, const std::vector<PressSide>& b, int points) {
  Sum sum;
  for (const PressSide& other : b) {
    Vector3d on_it = Vector3d::Zero();
    for (const PressSide& one : a) {
      const Press press = PressOf(kStiffness, points, one, other);
      sum.energy += press.energy;
      on_it += press.b_start + press.b_end;
    }
    sum.on_b += on_it;
    sum.on_each.push_back(on_it);
  }
  return sum;
}

TEST(PressOf, ACrossingIsHertzsForceWhereverItLiesOnTheElements) {
  const double one_radius = 0.012, other_radius = 0.008, radii = one_radius + other_radius;
  for (const double angle : {90.0, 60.0, 30.0}) {
    const double turned = angle * std::numbers::pi / 180;
    for (const double share : {1e-3, 0.01, 0.05}) {
      const double depth = share * radii;
      const double expected = kStiffness * std::pow(depth, 1.5) * (1 - 1.75 * share) / std::sin(turned);
      for (const auto& [s, t] : {std::pair{0.0, 0.0}, {0.25, 0.1}, {0.5, 0.5}, {0.07, 0.39}}) {
        // Elements 0.6 of the radii's sum long; s and t of an element off the middle of one.
        const double element = 0.6 * radii;
        const Vector3d b_along(std::cos(turned), std::sin(turned), 0);
        const auto a = Chain({s * element, 0, 0}, Vector3d::UnitX(), 7 * element, one_radius, 7);
        const auto b = Chain(t * element * b_along + Vector3d(0, 0, radii - depth), b_along, 7 * element,
                             other_radius, 7);
        const Sum sum = Press2(a, b, share < 0.005 ? 240 : 60);
        EXPECT_NEAR(sum.on_b.z(), expected, 0.01 * expected) << angle << ", " << share << ", " << s;
        EXPECT_LT(sum.on_b.head<2>().norm(), 1e-3 * expected);
      }
    }
  }
}

TEST(PressOf, RodsSideBySidePressInProportionToDepthAndLength) {
  const double radius = 0.01, radii = 2 * radius, element = 0.01;
  for (const double share : {1e-4, 1e-3, 0.01}) {
    for (const double shift : {0.0, 0.3, 0.5}) {
      for (const int points : {1, 3}) {
        const auto a = Chain(Vector3d::Zero(), Vector3d::UnitX(), 20 * element, radius, 20);
        const auto b =
            Chain({shift * element, 0, (1 - share) * radii}, Vector3d::UnitX(), 20 * element, radius, 20);
        const Sum sum = Press2(a, b, points);
        const double expected = 0.75 * kStiffness / std::sqrt(2 * radii) * share * radii * element;
        for (std::size_t i = 6; i < 14; ++i) {
          EXPECT_NEAR(sum.on_each[i].z(), expected, 0.02 * expected) << share << ", " << shift << ", " << i;
          EXPECT_LT(std::abs(sum.on_each[i].x()), 1e-9 * expected);
        }
      }
    }
  }
}

// An element with twice as many points is two halves with as many each; more and more points are one rod.
TEST(PressOf, EnergyIsTheSameHoweverElementsAreCut) {
  Random random(6);
  for (int trial = 0; trial < 500; ++trial) {
    const auto [a, b] = Pair(random, trial % 2);
    const auto halves = [](const PressSide& whole) {
      std::vector<PressSide> two(2, whole);
      two[0].end = two[1].start = 0.5 * (whole.start + whole.end);
      two[0].rest_length = two[1].rest_length = 0.5 * whole.rest_length;
      return two;
    };
    const double whole = PressOf(kStiffness, 8, a, b).energy;
    ASSERT_NEAR(Press2(halves(a), halves(b), 4).energy, whole, 1e-11 * whole) << trial;
    const double fine = PressOf(kStiffness, 400, a, b).energy, finer = PressOf(kStiffness, 800, a, b).energy;
    const double size = kStiffness * std::pow(a.radius + b.radius, 2.5);
    ASSERT_NEAR(fine, finer, 1e-3 * finer + 1e-9 * size) << trial;
  }
}

// A rod is dragged along another, at a right angle, at a skew or nearly parallel, right through its length:
// what it took to come in is given back going out. (Forces between closest points that count where they are a
// local minimum, as this law had before, jump while rods slide along each other, and kept no energy.)
TEST(PressOf, ARodDraggedPastAnotherGivesBackItsWork) {
  const double radius = 0.01, element = 0.012;
  for (const double angle : {1.5, 0.4, 0.05, 1e-3, 0.0}) {
    for (const int points : {1, 2}) {
      const auto a = Chain(Vector3d::Zero(), Vector3d::UnitX(), 6 * element, radius, 6);
      const Vector3d along(std::cos(angle), std::sin(angle), 0);
      const auto at = [&](double way) {
        return Chain({way, 0.3 * way + 0.002, 0.018}, along, 5 * element, radius, 5);
      };
      const int steps = 2000;
      const double from = -0.12, step = 0.24 / steps;
      double work = 0, largest = 0, worst = 0;
      for (int k = 0; k < steps; ++k) {
        const Vector3d move(step, 0.3 * step, 0);
        work -= Press2(a, at(from + (k + 0.5) * step), points).on_b.dot(move);
        if (k % 20 != 0) continue;
        const double energy = Press2(a, at(from + (k + 1) * step), points).energy;
        largest = std::max(largest, energy);
        worst = std::max(worst, std::abs(energy - work));
      }
      EXPECT_GT(largest, 1e-5);
      EXPECT_LT(worst, 1e-3 * largest) << angle;
      EXPECT_LT(std::abs(work), 5e-5 * largest) << angle;
      EXPECT_EQ(Press2(a, at(from), points).energy, 0);
      EXPECT_EQ(Press2(a, at(-from), points).energy, 0);
    }
  }
}

double PressedEnergy(const std::vector<Rod>& rods, const SimulationPlan& plan) {
  const auto side = [](const Rod& rod, Index i) {
    return PressSide{rod.position.col(i), rod.position.col(i + 1), rod.radius[i], rod.rest_length[i]};
  };
  double energy = 0;
  for (std::size_t a = 0; a < rods.size(); ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      for (Index i = 0; i < rods[a].elements(); ++i) {
        const Index first = a == b ? FirstThatMayTouch(rods[a], i, ContactLaw::kHertzSegments) : 0;
        for (Index j = first; j < rods[b].elements(); ++j) {
          energy += PressOf(kStiffness, plan.contact_points, side(rods[a], i), side(rods[b], j)).energy;
        }
      }
    }
  }
  return energy;
}

// Four free rods that snap into coils about each other and stay entangled, with nothing that takes energy.
TEST(Press, AnUndampedTangleKeepsItsEnergyAtTheStandardStep) {
  Scene scene;
  scene.gravity.setZero();
  scene.contact.stiffness = kStiffness;
  for (int k = 0; k < 4; ++k) {
    SceneRod rod;
    rod.name = std::to_string(k);
    rod.design.length = 0.6;
    rod.design.elements = 60;
    rod.design.base_radius = 0.01;
    rod.design.base = EndHold::kFree;
    rod.design.start = {0.03 * (k % 2), 0.03 * (k / 2), -0.02 * k};
    rod.rest_curvature = {k % 2 == 0 ? 12.0 : -14.0, 9.0 + k, 3};
    rod.velocity = {k % 2 == 0 ? 0.1 : -0.1, k / 2 == 0 ? 0.1 : -0.1, 0};
    scene.rods.push_back(rod);
  }
  const SimulationPlan plan = PlanScene(scene).value();
  ASSERT_TRUE(plan.rod_contact && plan.self_contact);
  Stepper stepper(scene, plan, MakeRods(scene, 0).value(), plan.time_step);
  const double step = plan.time_step;
  double start = 0, worst = 0, pressed = 0;
  for (int look = 0; look <= 100; ++look) {
    const double time = 0.01 * look;
    const auto kicks = static_cast<std::int64_t>(std::llround(time / step));
    const auto diverged = stepper.AdvanceTo(kicks);
    ASSERT_FALSE(diverged) << diverged->Sentence();
    const std::vector<Rod> rods = stepper.At(static_cast<double>(kicks) * step);
    const double press = PressedEnergy(rods, plan);
    double energy = press;
    for (const Rod& rod : rods) energy += EnergyOf(rod).total();
    if (look == 0) start = energy;
    worst = std::max(worst, std::abs(energy / start - 1));
    pressed = std::max(pressed, press / start);
  }
  RecordProperty("worst", std::to_string(worst));
  EXPECT_GT(start, 0.005);
  EXPECT_GT(pressed, 1e-3) << "hardly anything touched";
  EXPECT_LT(worst, 0.01) << "step " << step << " pressed " << pressed;
}

}  // namespace
}  // namespace tendril
