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
#include "model/rods/contact_plain.h"
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
      // Rolling along, in the elements' axes.
      for (Index i = 0; i < rods[r].spin.cols(); ++i) {
        rods[r].spin.col(i) = 30 * std::cos(40 * time) * Vector3d(0.1, 0.2 * std::sin(phase), 1);
      }
    }
  }
};

const std::vector<FixedBody>& Bar() {
  static const std::vector<FixedBody> bar = {{{-0.1, 0, 0.01}, {0.1, 0.02, 0}, 0.02}};
  return bar;
}

// The same bar as a solid, and a box that sways and turns.
std::vector<Solid> SolidsAt(double time) {
  std::vector<Solid> solids(2);
  solids[0].shape = {{PrimitiveKind::kCapsule, 0.02, {0, 0, 0.1}}};
  solids[0].pose.linear() =
      Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), Vector3d(0.2, 0.02, -0.01)).toRotationMatrix();
  solids[0].pose.translation() = Vector3d(0, 0.01, 0.005);
  solids[1].shape = {{PrimitiveKind::kBox, 0, {0.03, 0.02, 0.015}}};
  solids[1].pose.translation() = Vector3d(-0.03, 0.03, 0.01 + 0.01 * std::sin(30 * time));
  solids[1].pose.linear() = Eigen::AngleAxisd(2 * time, Vector3d::UnitY()).toRotationMatrix();
  solids[1].velocity = {0, 0, 0.3 * std::cos(30 * time)};
  solids[1].spin = {0, 2, 0};
  return solids;
}

Contact Sticky() {
  Contact contact{ContactLaw::kHertzSegments, 1e4, 0.01};
  contact.friction = 0.3;
  contact.static_friction = 0.5;
  return contact;
}

Matrix3Xd SpinsInLab(const Rod& rod) {
  Matrix3Xd spins(3, rod.elements());
  for (Index i = 0; i < spins.cols(); ++i) {
    spins.col(i) = rod.directors[static_cast<std::size_t>(i)].transpose() * rod.spin.col(i);
  }
  return spins;
}

void PutAll(ContactList& list, const std::vector<Rod>& rods, const std::vector<Solid>& solids = {}) {
  for (std::size_t r = 0; r < rods.size(); ++r) {
    const Matrix3Xd spins = SpinsInLab(rods[r]);
    list.Put(r, rods[r].position.data(), rods[r].velocity.data(), spins.data(), 1);
  }
  for (std::size_t s = 0; s < solids.size(); ++s) {
    list.PutSolid(s, solids[s].pose, solids[s].velocity, solids[s].spin);
  }
}

// Forces and couples of all rods, one after the other, then wrenches of solids.
struct Found {
  std::vector<Matrix3Xd> forces, couples;
};

Found None(const std::vector<Rod>& rods) {
  Found found;
  for (const Rod& rod : rods) {
    found.forces.emplace_back(Matrix3Xd::Zero(3, rod.position.cols()));
    found.couples.emplace_back(Matrix3Xd::Zero(3, rod.elements()));
  }
  return found;
}

Found In(const ContactList& list, const std::vector<Rod>& rods, std::size_t solids = 0) {
  Found found = None(rods);
  for (std::size_t r = 0; r < rods.size(); ++r) {
    list.AddForces(r, found.forces[r].data(), 1);
    list.AddCouples(r, found.couples[r].data(), 1);
  }
  for (std::size_t s = 0; s < solids; ++s) {
    found.forces.emplace_back(list.OnSolid(s).force);
    found.couples.emplace_back(list.OnSolid(s).torque);
  }
  return found;
}

Found AsPublished(const Contact& contact, const std::vector<Rod>& rods) {
  Found all = None(rods);
  for (std::size_t a = 0; a < rods.size(); ++a) {
    AddSelfContact(contact, rods[a], all.forces[a]);
    for (const FixedBody& body : Bar()) AddBodyContact(contact, rods[a], body, all.forces[a]);
    for (std::size_t b = 0; b < a; ++b) {
      AddRodContact(contact, rods[a], rods[b], all.forces[a], all.forces[b]);
    }
  }
  return all;
}

Found Plainly(PlainContact& plain, const std::vector<Rod>& rods, const std::vector<Solid>& solids) {
  const Found none = None(rods);
  std::vector<RodLoads> loads;
  for (std::size_t r = 0; r < rods.size(); ++r) loads.push_back({none.forces[r], none.couples[r]});
  std::vector<Wrench> wrenches(solids.size());
  plain.Add(rods, solids, kStep, loads, wrenches);
  Found found;
  for (const RodLoads& load : loads) {
    found.forces.push_back(load.force);
    found.couples.push_back(load.couple);
  }
  for (const Wrench& wrench : wrenches) {
    found.forces.emplace_back(wrench.force);
    found.couples.emplace_back(wrench.torque);
  }
  return found;
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
double WorstDifference(const Found& a, const Found& b) {
  return std::max(WorstDifference(a.forces, b.forces), WorstDifference(a.couples, b.couples));
}

TEST(ContactSteps, NothingThatTouchesAsPublishedIsLeftOutWhileListsAreKept) {
  for (const int width : {2, 4, 8}) {
    if (width > MachineDoubles()) continue;
    UseRodKernel(width);
    for (const ContactLaw law : {ContactLaw::kHertzEqual, ContactLaw::kHertzCenters}) {
      const Contact contact{law, 1e4, 0.01};
      Swaying scene(11);
      scene.MoveTo(0);
      ContactList list(contact, scene.rods, Bar(), {}, {});
      for (int step = 0; step < 1500; ++step) {
        scene.MoveTo(kStep * step);
        PutAll(list, scene.rods);
        ASSERT_TRUE(list.Find(kStep));
        if (step % 7 != 0) continue;
        const Found expected = AsPublished(contact, scene.rods);
        EXPECT_GT(Largest(expected.forces), 0);
        EXPECT_LT(WorstDifference(In(list, scene.rods), expected), 1e-11 * Largest(expected.forces))
            << "width " << width << " law " << static_cast<int>(law) << " step " << step;
      }
      EXPECT_GT(list.lists(), 3);
      EXPECT_LT(list.lists(), 100);
    }
  }
  UseRodKernel(0);
}

// Springs carry what happened at every step before, so both forms go through all of them.
TEST(ContactSteps, NothingThatPressesOrSticksIsLeftOutWhileListsAreKept) {
  constexpr int kSteps = 1000;
  std::vector<Found> expected;
  Swaying scene(11, {40, 40, 16});
  scene.MoveTo(0);
  {
    PlainContact plain(Sticky(), {});
    for (int step = 0; step < kSteps; ++step) {
      scene.MoveTo(kStep * step);
      Found found = Plainly(plain, scene.rods, SolidsAt(kStep * step));
      if (step % 50 == 49) expected.push_back(std::move(found));
    }
    ASSERT_GT(plain.StoredBySprings(), 0);
  }
  for (const int width : {2, 4, 8}) {
    if (width > MachineDoubles()) continue;
    UseRodKernel(width);
    Swaying again(11, {40, 40, 16});
    again.MoveTo(0);
    ContactList list(Sticky(), again.rods, {}, SolidsAt(0), {});
    for (int step = 0; step < kSteps; ++step) {
      again.MoveTo(kStep * step);
      PutAll(list, again.rods, SolidsAt(kStep * step));
      ASSERT_TRUE(list.Find(kStep));
      if (step % 50 != 49) continue;
      const Found& plainly = expected[static_cast<std::size_t>(step / 50)];
      const Found found = In(list, again.rods, 2);
      EXPECT_GT(Largest(plainly.couples), 0);
      EXPECT_LT(WorstDifference(found.forces, plainly.forces), 1e-9 * Largest(plainly.forces))
          << "width " << width << " step " << step;
      EXPECT_LT(WorstDifference(found.couples, plainly.couples), 1e-9 * Largest(plainly.couples))
          << "width " << width << " step " << step;
    }
    EXPECT_GT(list.lists(), 3);
    EXPECT_LT(list.lists(), 100);
  }
  UseRodKernel(0);
}

TEST(ContactSteps, AfterForgettingOnlyWhatIsPutCounts) {
  const Contact contact{ContactLaw::kHertzSegments, 1e4, 0.01};
  Swaying scene(5);
  scene.MoveTo(0);
  ContactList old(contact, scene.rods, {}, SolidsAt(0), {}), fresh(contact, scene.rods, {}, SolidsAt(0), {});
  for (int step = 0; step < 200; ++step) {
    scene.MoveTo(kStep * step);
    PutAll(old, scene.rods, SolidsAt(kStep * step));
    ASSERT_TRUE(old.Find(kStep));
  }
  old.ForgetList();
  for (int step = 200; step < 600; ++step) {
    scene.MoveTo(kStep * step);
    for (ContactList* list : {&old, &fresh}) {
      PutAll(*list, scene.rods, SolidsAt(kStep * step));
      ASSERT_TRUE(list->Find(kStep));
    }
    ASSERT_EQ(WorstDifference(In(old, scene.rods, 2), In(fresh, scene.rods, 2)), 0) << step;
  }
}

// What sticks is part of the state: it is kept when lists are forgotten, saved, and restored elsewhere.
TEST(ContactSteps, SpringsOutlastForgettingAndGoOnInAnotherListToTheBit) {
  Swaying scene(5);
  scene.MoveTo(0);
  const Contact contact = Sticky();
  ContactList old(contact, scene.rods, {}, SolidsAt(0), {}), kept(contact, scene.rods, {}, SolidsAt(0), {});
  const auto step_both = [&](int step, ContactList& one, ContactList& other) {
    scene.MoveTo(kStep * step);
    for (ContactList* list : {&one, &other}) {
      PutAll(*list, scene.rods, SolidsAt(kStep * step));
      EXPECT_TRUE(list->Find(kStep));
    }
  };
  for (int step = 0; step < 333; ++step) step_both(step, old, kept);
  old.ForgetList();
  ContactList restored(contact, scene.rods, {}, SolidsAt(0), {});
  const std::vector<double> saved = old.Save();
  ASSERT_TRUE(restored.Restore(saved));
  for (int step = 333; step < 600; ++step) {
    step_both(step, old, restored);
    const Found one = In(old, scene.rods, 2), other = In(restored, scene.rods, 2);
    ASSERT_EQ(WorstDifference(one, other), 0) << step;
    // One that forgot nothing does the same but for the order of sums.
    PutAll(kept, scene.rods, SolidsAt(kStep * step));
    ASSERT_TRUE(kept.Find(kStep));
    EXPECT_LT(WorstDifference(one, In(kept, scene.rods, 2)), 1e-9 * Largest(one.forces)) << step;
  }
  EXPECT_EQ(restored.Save(), old.Save());
  // What is not of such a list is refused: cut short, or with springs that nobody has counted.
  ContactList other(contact, scene.rods, {}, SolidsAt(0), {});
  for (const std::size_t size : {std::size_t{0}, std::size_t{5}, saved.size() / 2, saved.size() - 1}) {
    EXPECT_FALSE(other.Restore(std::span(saved).first(size))) << size;
  }
  std::vector<double> longer = saved;
  longer.push_back(0);
  EXPECT_FALSE(other.Restore(longer));
}

TEST(ContactSteps, RodsSideBySideFindTheSameToTheBit) {
  Swaying scene(3, {40, 40, 40});
  scene.MoveTo(0);
  ContactList one_by_one(Sticky(), scene.rods, {}, SolidsAt(0), {}),
      lanes(Sticky(), scene.rods, {}, SolidsAt(0), {});
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
    const std::vector<Solid> solids = SolidsAt(kStep * step);
    PutAll(one_by_one, scene.rods, solids);
    lanes.PutLanes(members, positions.data(), velocities.data());
    const std::span<double> spins = lanes.LaneSpins(members);
    ASSERT_EQ(spins.size(), 3u * 40 * 8);
    for (std::size_t r = 0; r < 3; ++r) {
      const Matrix3Xd of_rod = SpinsInLab(scene.rods[r]);
      for (std::size_t i = 0; i < 3 * 40; ++i) spins[8 * i + r] = of_rod.data()[i];
    }
    for (std::size_t s = 0; s < 2; ++s) {
      lanes.PutSolid(s, solids[s].pose, solids[s].velocity, solids[s].spin);
    }
    ASSERT_TRUE(one_by_one.Find(kStep));
    ASSERT_TRUE(lanes.Find(kStep));
    const std::span<const double> forces = lanes.LaneForces(members), couples = lanes.LaneCouples(members);
    const Found expected = In(one_by_one, scene.rods);
    ASSERT_GT(Largest(expected.couples), 0);
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t i = 0; i < 3 * 41; ++i) ASSERT_EQ(forces[8 * i + r], expected.forces[r].data()[i]);
      for (std::size_t i = 0; i < 3 * 40; ++i) ASSERT_EQ(couples[8 * i + r], expected.couples[r].data()[i]);
    }
    for (std::size_t s = 0; s < 2; ++s) {
      ASSERT_EQ(lanes.OnSolid(s).force, one_by_one.OnSolid(s).force);
      ASSERT_EQ(lanes.OnSolid(s).torque, one_by_one.OnSolid(s).torque);
    }
  }
}

TEST(ContactSteps, NothingIsAllocatedOnceWarm) {
  Swaying scene(11);
  scene.MoveTo(0);
  ContactList list(Sticky(), scene.rods, {}, SolidsAt(0), {});
  Matrix3Xd force = Matrix3Xd::Zero(3, 61), couple = Matrix3Xd::Zero(3, 60);
  const double period = 2 * std::numbers::pi / 40;
  const auto allocated = [&] {
    long counted = 0;
    for (int step = 0; 5 * kStep * step < period; ++step) {
      scene.MoveTo(5 * kStep * step);
      const std::vector<Solid> solids = SolidsAt(5 * kStep * step);
      PutAll(list, scene.rods, solids);
      const long before = allocations;
      for (std::size_t s = 0; s < 2; ++s) {
        list.PutSolid(s, solids[s].pose, solids[s].velocity, solids[s].spin);
      }
      EXPECT_TRUE(list.Find(kStep));
      for (std::size_t r = 0; r < scene.rods.size(); ++r) {
        list.AddForces(r, force.data(), 1);
        list.AddCouples(r, couple.data(), 1);
      }
      counted += allocations - before;
    }
    return counted;
  };
  EXPECT_GT(allocated(), 0);
  const long lists = list.lists();
  EXPECT_EQ(allocated(), 0);
  EXPECT_GT(list.lists(), lists + 3);
}

}  // namespace
}  // namespace tendril
