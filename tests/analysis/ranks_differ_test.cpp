// analysis/statistics/ranks_differ.h: published values, the definition, the ends.
#include "analysis/statistics/ranks_differ.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tendril {
namespace {

// Mann & Whitney 1947, tables: of 5 and 5 values, U <= 2 has 4 of 252 orders; of 3 and 4, U = 0 has 1 of 35;
// of 8 and 8, U <= 13 has 0.025.
TEST(CompareRanks, IsMannsAndWhitneysTable) {
  EXPECT_NEAR(CompareRanks({6, 7, 8, 9, 10}, {1, 2, 3, 4, 5}).p, 2.0 / 252, 1e-14);
  EXPECT_NEAR(CompareRanks({4, 7, 8, 9, 10}, {1, 2, 3, 5, 6}).p, 8.0 / 252, 1e-14);  // U = 2
  EXPECT_NEAR(CompareRanks({1, 2, 3}, {4, 5, 6, 7}).p, 2.0 / 35, 1e-14);
  const RanksDiffer eight = CompareRanks({1, 2, 3, 4, 5, 9.5, 10, 12}, {6, 7, 8, 9, 11, 13, 14, 15});
  EXPECT_DOUBLE_EQ(eight.share, 13.0 / 64);
  EXPECT_NEAR(eight.p, 2 * 0.025, 1e-3);
}

TEST(CompareRanks, IsTheShareOfAllOrders) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> draw;
  std::vector<double> values(10);
  for (double& value : values) value = draw(random);
  const auto share = [&](unsigned bits) {
    double larger = 0;
    for (unsigned a = 0; a < 10; ++a) {
      for (unsigned b = 0; b < 10; ++b) {
        if ((bits >> a & 1U) == 1 && (bits >> b & 1U) == 0 && values[a] > values[b]) ++larger;
      }
    }
    return larger / 24;
  };
  const unsigned seen = 0b1101001000;
  int all = 0, far = 0;
  for (unsigned bits = 0; bits < 1024; ++bits) {
    if (__builtin_popcount(bits) != 4) continue;
    ++all;
    if (std::abs(share(bits) - 0.5) >= std::abs(share(seen) - 0.5) - 1e-9) ++far;
  }
  std::vector<double> one, other;
  for (unsigned i = 0; i < 10; ++i) ((seen >> i & 1U) == 1 ? one : other).push_back(values[i]);
  const RanksDiffer differ = CompareRanks(one, other);
  EXPECT_NEAR(differ.share, share(seen), 1e-14);
  EXPECT_NEAR(differ.p, static_cast<double>(far) / all, 1e-13);
}

TEST(CompareRanks, SwapsWithItsSidesAndKnowsNothingOfNone) {
  const std::vector<double> a = {1, 5, 9, 2}, b = {3, 4, 11};
  EXPECT_NEAR(CompareRanks(a, b).share, 1 - CompareRanks(b, a).share, 1e-15);
  EXPECT_NEAR(CompareRanks(a, b).p, CompareRanks(b, a).p, 1e-14);
  EXPECT_EQ(CompareRanks({}, b).p, 1);
  EXPECT_EQ(CompareRanks(a, {}).share, 0.5);
  EXPECT_EQ(CompareRanks({2}, {2}).share, 0.5);
  EXPECT_NEAR(CompareRanks({2}, {2}).p, 1, 1e-15);
}

}  // namespace
}  // namespace tendril
