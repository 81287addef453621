// model/rods/contact_list.h from step to step: lists outlast steps, whatever is put between, and cost no
// memory.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "model/machine.h"
#include "model/rods/contact_list.h"
#include "model/rods/rod_lanes.h"
#include "tests/support/allocation_count.h"

namespace tendril {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using testing_support::allocations;

constexpr double kStep = 2e-5;

// Coils that lie in each other, swaying, turning and breathing by some 0.3 m/s; the last moves four times as
// fast.
struct Swaying {
  std::vector<Rod> rods;
  std::vector<Vector3d> middles, ways, axes;

  explicit Swaying(unsigned seed, std::vector<int> elements = {60, 60, 60, 24, 24}) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const auto draw = [&] { return Vector3d(normal(random), normal(random), normal(random)); };
    for (std::size_t r = 0; r < elements.size(); ++r) {
      RodDesign design;
      design.elements = elements[r];
      design.length = 0.0075 * elements[r];
      design.base_radius = 0.012;
      design.taper = 0.5;
      rods.push_back(MakeRod(design).value());
      middles.push_back(0.02 * draw());
      ways.push_back((r + 1 == elements.size() ? 1.2 : 0.3) * draw());
      axes.push_back(draw().normalized());
    }
  }

  void MoveTo(double time) {
    for (std::size_t r = 0; r < rods.size(); ++r) {
      const double phase = static_cast<double>(r);
      const Vector3d side = axes[r].unitOrthogonal(), up = axes[r].cross(side);
      const double swing = std::sin(40 * time) / 40;
      for (Index i = 0; i < rods[r].position.cols(); ++i) {
        const double along = static_cast<double>(i), angle = 0.15 * along + phase + 6 * swing;
        const double radius = 0.05 + 0.1 * swing * std::sin(0.2 * along);
        const Vector3d at = middles[r] + swing * ways[r] +
                            radius * (std::cos(angle) * side + std::sin(angle) * up) +
                            0.0006 * along * axes[r];
        rods[r].velocity.col(i) = (at - rods[r].position.col(i)) / kStep;
        rods[r].position.col(i) = at;
      }
    }
  }
};

const std::vector<FixedBody>& Bar() {
  static const std::vector<FixedBody> bar = {{{-0.1, 0, 0.01}, {0.1, 0.02, 0}, 0.02}};
  return bar;
}

void PutAll(ContactList& list, const std::vector<Rod>& rods) {
  for (std::size_t r = 0; r < rods.size(); ++r) {
    list.Put(r, rods[r].position.data(), rods[r].velocity.data(), 1);
  }
}

std::vector<Matrix3Xd> ForcesOf(const ContactList& list, const std::vector<Rod>& rods) {
  std::vector<Matrix3Xd> all;
  for (std::size_t r = 0; r < rods.size(); ++r) {
    all.emplace_back(Matrix3Xd::Zero(3, rods[r].position.cols()));
    list.AddForces(r, all.back().data(), 1);
  }
  return all;
}

std::vector<Matrix3Xd> Plainly(const Contact& contact, const std::vector<Rod>& rods) {
  std::vector<Matrix3Xd> all;
  for (const Rod& rod : rods) all.emplace_back(Matrix3Xd::Zero(3, rod.position.cols()));
  for (std::size_t a = 0; a < rods.size(); ++a) {
    AddSelfContact(contact, rods[a], all[a]);
    for (const FixedBody& body : Bar()) AddBodyContact(contact, rods[a], body, all[a]);
    for (std::size_t b = 0; b < a; ++b) AddRodContact(contact, rods[a], rods[b], all[a], all[b]);
  }
  return all;
}

double Largest(const std::vector<Matrix3Xd>& forces) {
  double largest = 0;
  for (const Matrix3Xd& force : forces) largest = std::max(largest, force.cwiseAbs().maxCoeff());
  return largest;
}

double WorstDifference(const std::vector<Matrix3Xd>& a, const std::vector<Matrix3Xd>& b) {
  double worst = 0;
  for (std::size_t r = 0; r < a.size(); ++r) worst = std::max(worst, (a[r] - b[r]).cwiseAbs().maxCoeff());
  return worst;
}

TEST(ContactSteps, NothingThatPressesIsLeftOutWhileListsAreKept) {
  for (const int width : {2, 4, 8}) {
    if (width > MachineDoubles()) continue;
    UseRodKernel(width);
    for (const ContactLaw law :
         {ContactLaw::kHertzSegments, ContactLaw::kHertzEqual, ContactLaw::kHertzCenters}) {
      const Contact contact{law, 1e4, 0.01};
      Swaying scene(11);
      scene.MoveTo(0);
      ContactList list(contact, scene.rods, Bar(), {});
      for (int step = 0; step < 1500; ++step) {
        scene.MoveTo(kStep * step);
        PutAll(list, scene.rods);
        ASSERT_TRUE(list.Find());
        if (step % 7 != 0) continue;
        const std::vector<Matrix3Xd> expected = Plainly(contact, scene.rods);
        EXPECT_GT(Largest(expected), 0);
        EXPECT_LT(WorstDifference(ForcesOf(list, scene.rods), expected), 1e-11 * Largest(expected))
            << "width " << width << " law " << static_cast<int>(law) << " step " << step;
      }
      EXPECT_GT(list.lists(), 3);
      EXPECT_LT(list.lists(), 100);
    }
  }
  UseRodKernel(0);
}

TEST(ContactSteps, AfterForgettingOnlyWhatIsPutCounts) {
  const Contact contact{ContactLaw::kHertzSegments, 1e4, 0.01};
  Swaying scene(5), other(5);
  scene.MoveTo(0);
  other.MoveTo(0);
  ContactList old(contact, scene.rods, Bar(), {}), fresh(contact, scene.rods, Bar(), {});
  for (int step = 0; step < 200; ++step) {
    scene.MoveTo(kStep * step);
    PutAll(old, scene.rods);
    ASSERT_TRUE(old.Find());
  }
  old.ForgetList();
  for (int step = 200; step < 600; ++step) {
    scene.MoveTo(kStep * step);
    PutAll(old, scene.rods);
    PutAll(fresh, scene.rods);
    ASSERT_TRUE(old.Find());
    ASSERT_TRUE(fresh.Find());
    ASSERT_EQ(WorstDifference(ForcesOf(old, scene.rods), ForcesOf(fresh, scene.rods)), 0) << step;
  }
}

TEST(ContactSteps, RodsSideBySideFindTheSameToTheBit) {
  const Contact contact{ContactLaw::kHertzSegments, 1e4, 0.01};
  Swaying scene(3, {40, 40, 40});
  scene.MoveTo(0);
  ContactList one_by_one(contact, scene.rods, Bar(), {}), lanes(contact, scene.rods, Bar(), {});
  const std::vector<std::size_t> members = {0, 1, 2};
  std::vector<double> positions(3 * 41 * 8, std::nan("")), velocities = positions;  // lanes 3 to 7 are unused
  for (int step = 0; step < 200; ++step) {
    scene.MoveTo(kStep * step);
    for (std::size_t i = 0; i < 3 * 41; ++i) {
      for (std::size_t r = 0; r < 3; ++r) {
        positions[8 * i + r] = scene.rods[r].position.data()[i];
        velocities[8 * i + r] = scene.rods[r].velocity.data()[i];
      }
    }
    PutAll(one_by_one, scene.rods);
    lanes.PutLanes(members, positions.data(), velocities.data());
    ASSERT_TRUE(one_by_one.Find());
    ASSERT_TRUE(lanes.Find());
    std::vector<double> forces(positions.size(), 0.0);
    lanes.AddLaneForces(members, forces.data());
    const std::vector<Matrix3Xd> expected = ForcesOf(one_by_one, scene.rods);
    for (std::size_t i = 0; i < 3 * 41; ++i) {
      for (std::size_t r = 0; r < 3; ++r) ASSERT_EQ(forces[8 * i + r], expected[r].data()[i]);
    }
  }
}

TEST(ContactSteps, NothingIsAllocatedOnceWarm) {
  Swaying scene(11);
  scene.MoveTo(0);
  ContactList list({ContactLaw::kHertzSegments, 1e4, 0.01}, scene.rods, Bar(), {});
  Matrix3Xd force = Matrix3Xd::Zero(3, 61);
  const double period = 2 * std::numbers::pi / 40;
  const auto allocated = [&] {
    const long before = allocations;
    for (int step = 0; 5 * kStep * step < period; ++step) {
      scene.MoveTo(5 * kStep * step);
      PutAll(list, scene.rods);
      EXPECT_TRUE(list.Find());
      for (std::size_t r = 0; r < scene.rods.size(); ++r) list.AddForces(r, force.data(), 1);
    }
    return allocations - before;
  };
  EXPECT_GT(allocated(), 0);
  const long lists = list.lists();
  EXPECT_EQ(allocated(), 0);
  EXPECT_GT(list.lists(), lists + 3);
}

}  // namespace
}  // namespace tendril
