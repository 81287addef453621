// analysis/link/link_tree.h: the same sums as all pairs, in fewer.
#include "analysis/link/link_tree.h"

#include <gtest/gtest.h>

#include "analysis/link/link_kernel.h"
#include "tests/support/link_curves.h"

namespace tendril::test {
namespace {

NodeArrays Arrays(const Strand& s) { return {s.x.data(), s.y.data(), s.z.data(), s.nodes()}; }

// A smooth closed curve that fills a ball about `centre` like a tangle of string.
Matrix3Xd Tangle(std::mt19937_64& random, int nodes, const Vector3d& centre) {
  std::normal_distribution<double> normal(0, 1);
  Eigen::Matrix<double, 3, 12> cosine, sine;
  for (int k = 0; k < 12; ++k) {
    for (int i = 0; i < 3; ++i) {
      cosine(i, k) = normal(random) / (3 + k);
      sine(i, k) = normal(random) / (3 + k);
    }
  }
  return Closed(nodes, [&](double t) {
    Vector3d p = centre;
    for (int k = 0; k < 12; ++k) {
      p += cosine.col(k) * std::cos((k + 1) * t) + sine.col(k) * std::sin((k + 1) * t);
    }
    return p;
  });
}

TEST(SumByTree, AgreesWithAllPairs) {
  std::mt19937_64 random(8);
  for (int trial = 0; trial < 12; ++trial) {
    const Vector3d apart = Vector3d(trial % 4, 0.3, 0.2);
    const Strand a = Close(Tangle(random, 700 + 50 * trial, {0, 0, 0}), kNone);
    const Strand b = Close(Tangle(random, 900, apart), kNone);
    const TreeSum tree = SumByTree(a, b);
    EXPECT_TRUE(tree.doubtful.empty());
    EXPECT_NEAR(tree.angle / (4 * kPi), SumSegmentAngles(Arrays(a), Arrays(b)).angle / (4 * kPi), 1e-12);
    EXPECT_NEAR(tree.angle / (4 * kPi), std::round(tree.angle / (4 * kPi)), 1e-12) << "closed curves";
    EXPECT_LT(tree.pairs, a.nodes() * b.nodes() / 2);
    const TreeSum own = SumOwnByTree(a, true);
    EXPECT_NEAR(own.angle / (2 * kPi), StrandWrithe(a, LinkMethod::kExact).value, 1e-12);
  }
}

// Rough, open, and of all lengths: nothing about the curves is smooth or far apart.
TEST(SumByTree, AgreesWithAllPairsOnRandomWalks) {
  std::mt19937_64 random(9);
  for (const int nodes : {2, 3, 34, 65, 200, 1000}) {
    for (int trial = 0; trial < 5; ++trial) {
      const Strand a = Close(RandomWalk(random, 400), kNone);
      Matrix3Xd walk = RandomWalk(random, nodes);
      walk.colwise() += Vector3d(0.5 * trial, 0, 0);
      const Strand b = Close(walk, kNone);
      EXPECT_NEAR(SumByTree(a, b).angle / (4 * kPi), SumSegmentAngles(Arrays(a), Arrays(b)).angle / (4 * kPi),
                  1e-12);
      EXPECT_NEAR(SumOwnByTree(b, false).angle / (2 * kPi), StrandWrithe(b, LinkMethod::kExact).value, 1e-12)
          << nodes;
    }
  }
}

TEST(SumByTree, CurvesFarApartCostTwoSolidAnglesPerNode) {
  std::mt19937_64 random(10);
  const Strand a = Close(Tangle(random, 3000, {0, 0, 0}), kNone);
  const Strand b = Close(Tangle(random, 2000, {50, 0, 0}), kNone);
  const TreeSum tree = SumByTree(a, b);
  EXPECT_EQ(tree.pairs, 1u);
  EXPECT_LE(tree.triangles, 2u * 5000u);
  EXPECT_NEAR(tree.angle, 0, 1e-12);
}

TEST(SumByTree, PairsThatTouchAreLeftToTheScalarForm) {
  std::mt19937_64 random(11);
  const Matrix3Xd walk = RandomWalk(random, 600);
  const Strand a = Close(walk, kNone);
  Matrix3Xd other = RandomWalk(random, 600);
  other.col(300) = 0.5 * (walk.col(100) + walk.col(101));  // in the middle of a segment
  const Strand b = Close(other, kNone);
  ASSERT_FALSE(SumByTree(a, b).doubtful.empty());
  const LinkValue fast = StrandLink(a, b, LinkMethod::kFast);
  const LinkValue exact = StrandLink(a, b, LinkMethod::kExact);
  EXPECT_EQ(fast.flags, exact.flags);
  EXPECT_EQ(fast.flags, LinkFlags{kTouching});
  EXPECT_NEAR(fast.value, exact.value, 1e-12);
}

}  // namespace
}  // namespace tendril::test
