// analysis/statistics/rates_differ.h: published values, chances as they are promised, the ends.
#include "analysis/statistics/rates_differ.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tendril {
namespace {

// Fisher 1935, The Design of Experiments: the lady who tastes tea has 3 of 4 right. One table of 70 has 4 of
// 4, 16 have 3: 17/70 on either side.
TEST(SameRate, IsFishersTestOfTheLadyTastingTea) {
  EXPECT_NEAR(SameRateP({{{3, 4}, {1, 4}}}), 34.0 / 70, 1e-14);
  EXPECT_NEAR(SameRateP({{{4, 4}, {0, 4}}}), 2.0 / 70, 1e-14);
}

// Fisher 1962 (as in R's ?fisher.test): convictions of 2 of 17 dizygotic and 10 of 13 monozygotic twins;
// one-sided 0.0004651809, two-sided 0.0005367241.
TEST(SameRate, OfConvictionsOfTwinsIsAsPublished) {
  EXPECT_NEAR(SameRateP({{{2, 17}, {10, 13}}}), 0.0005367241, 1e-10);
}

// Mantel 1963, penicillin given to rabbits at once or 1.5 h later, at five doses: R's
// mantelhaen.test(Rabbits, exact = TRUE), S = 16, p = 0.03994. Two of the doses tell nothing.
TEST(SameRate, OverPlacesIsMantelsAndHaenszelsExactTestOfTheRabbits) {
  const std::vector<RatePair> rabbits = {
      {{0, 6}, {0, 5}}, {{3, 6}, {0, 6}}, {{6, 6}, {2, 6}}, {{5, 6}, {6, 6}}, {{2, 2}, {5, 5}}};
  EXPECT_NEAR(SameRateP(rabbits), 0.03994, 5e-6);
  EXPECT_NEAR(SameRateP({rabbits[1], rabbits[2], rabbits[3]}), SameRateP(rabbits), 1e-12);
}

// Agresti, Categorical Data Analysis, table 3.7 (malformations by the mother's drinks a day 0, 0.5, 1.5, 4,
// 7): exact one-sided 0.0168. Far too many trials for any approximation to be needed, far too few successes
// for it to hold: z^2 = 6.57 would be 0.010.
TEST(NoTrend, OfMalformationsByAlcoholIsAsPublished) {
  const std::vector<Scored> groups = {
      {0, {48, 17114}}, {1, {38, 14502}}, {3, {5, 793}}, {8, {1, 127}}, {14, {1, 38}}};
  EXPECT_NEAR(NoTrendP(groups), 0.0168, 5e-4);
}

// Against the definition: every way in which the successes can fall, one by one.
TEST(NoTrend, IsTheShareOfAllArrangements) {
  const int score[] = {0, 0, 0, 1, 1, 2, 2, 2, 2, 5};
  const std::vector<Scored> groups = {{0, {3, 3}}, {1, {1, 2}}, {2, {1, 4}}, {5, {0, 1}}};
  const int seen = 0 + 1 + 2;
  int all = 0, far = 0;
  const double mean = 5 * (3 * 0 + 2 * 1 + 4 * 2 + 5) / 10.0;
  for (unsigned bits = 0; bits < 1024; ++bits) {
    int count = 0, sum = 0;
    for (unsigned i = 0; i < 10; ++i) {
      if ((bits >> i & 1U) == 0) continue;
      ++count;
      sum += score[i];
    }
    if (count != 5) continue;
    ++all;
    if (std::abs(sum - mean) >= std::abs(seen - mean) - 1e-9) ++far;
  }
  EXPECT_NEAR(NoTrendP(groups), static_cast<double>(far) / all, 1e-13);
}

TEST(NoTrend, OfTwoGroupsOfEqualSizeIsFishersTest) {
  for (int k = 0; k <= 8; ++k) {
    EXPECT_NEAR(NoTrendP({{0, {k, 8}}, {3, {5, 8}}}), SameRateP({{{k, 8}, {5, 8}}}), 1e-12) << k;
  }
}

// What is promised: if rates are equal, p is at most alpha no more often than alpha.
TEST(RateTests, CryWolfNoMoreOftenThanTheySay) {
  std::mt19937_64 random(1);
  std::binomial_distribution<int> draw(10, 0.4);
  int wolf_pair = 0, wolf_trend = 0;
  const int studies = 4000;
  for (int i = 0; i < studies; ++i) {
    const int k[] = {draw(random), draw(random), draw(random), draw(random)};
    wolf_pair += SameRateP({{{k[0], 10}, {k[1], 10}}, {{k[2], 10}, {k[3], 10}}}) <= 0.05 ? 1 : 0;
    wolf_trend +=
        NoTrendP({{0, {k[0], 10}}, {1, {k[1], 10}}, {2, {k[2], 10}}, {3, {k[3], 10}}}) <= 0.05 ? 1 : 0;
  }
  const double three_sigma = 3 * std::sqrt(0.05 * 0.95 / studies);
  EXPECT_LT(1.0 * wolf_pair / studies, 0.05 + three_sigma);
  EXPECT_LT(1.0 * wolf_trend / studies, 0.05 + three_sigma);
  EXPECT_GT(wolf_pair, 0.015 * studies);  // nor are they mute
  EXPECT_GT(wolf_trend, 0.02 * studies);
}

TEST(RateTests, WhereNothingCouldComeOutOtherwiseNothingIsSaid) {
  EXPECT_EQ(SameRateP({}), 1);
  EXPECT_EQ(NoTrendP({}), 1);
  EXPECT_EQ(NoTrendP({{0, {0, 0}}, {1, {0, 0}}}), 1);
  EXPECT_NEAR(SameRateP({{{0, 10}, {0, 7}}}), 1, 1e-12);
  EXPECT_NEAR(SameRateP({{{10, 10}, {7, 7}}}), 1, 1e-12);
  EXPECT_NEAR(SameRateP({{{3, 5}, {0, 0}}}), 1, 1e-12);
  EXPECT_NEAR(NoTrendP({{0, {0, 9}}, {4, {0, 9}}}), 1, 1e-12);
  EXPECT_NEAR(NoTrendP({{2, {3, 9}}, {2, {8, 9}}}), 1, 1e-12);
}

}  // namespace
}  // namespace tendril
