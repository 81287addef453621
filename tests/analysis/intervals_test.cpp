// analysis/statistics/intervals.h: published values, exact coverage, the ends.
#include "analysis/statistics/intervals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace tendril {
namespace {

// Newcombe 1998, Statistics in Medicine 17, 857-872, table I.
TEST(Intervals, AreThoseOfNewcombesTable) {
  struct Row {
    int successes, trials;
    double wilson_low, wilson_high, exact_low, exact_high;
  };
  for (const Row& row : {Row{81, 263, .2553, .3662, .2527, .3676}, Row{15, 148, .0624, .1605, .0578, .1617},
                         Row{0, 20, 0, .1611, 0, .1684}, Row{1, 29, .0061, .1718, .0009, .1776}}) {
    const Interval wilson = WilsonInterval(row.successes, row.trials);
    const Interval exact = ClopperPearsonInterval(row.successes, row.trials);
    EXPECT_NEAR(wilson.low, row.wilson_low, 5.1e-5) << row.successes << "/" << row.trials;
    EXPECT_NEAR(wilson.high, row.wilson_high, 5.1e-5) << row.successes << "/" << row.trials;
    EXPECT_NEAR(exact.low, row.exact_low, 5.1e-5) << row.successes << "/" << row.trials;
    EXPECT_NEAR(exact.high, row.exact_high, 5.1e-5) << row.successes << "/" << row.trials;
  }
}

double Probability(int k, int n, double rate) {
  return std::exp(std::lgamma(n + 1.0) - std::lgamma(k + 1.0) - std::lgamma(n - k + 1.0) +
                  k * std::log(rate) + (n - k) * std::log1p(-rate));
}

// The definition: at the upper end, seeing k or fewer has probability 2.5 %; at the lower, k or more.
TEST(Intervals, ClopperPearsonsTailsAreWhatTheyPromise) {
  for (const int n : {1, 2, 7, 30, 200}) {
    for (int k = 0; k <= n; k += n > 30 ? 17 : 1) {
      const Interval interval = ClopperPearsonInterval(k, n);
      double below = 0;
      double above = 0;
      for (int i = 0; i <= k && k < n; ++i) below += Probability(i, n, interval.high);
      for (int i = k; i <= n && k > 0; ++i) above += Probability(i, n, interval.low);
      if (k < n) {
        EXPECT_NEAR(below, 0.025, 1e-10) << k << "/" << n;
      }
      if (k > 0) {
        EXPECT_NEAR(above, 0.025, 1e-10) << k << "/" << n;
      }
    }
  }
}

TEST(Intervals, ClopperPearsonCoversAtLeastAsStatedAndWilsonOnAverage) {
  const int n = 25;
  double wilson_sum = 0;
  const int rates = 100;
  for (int i = 0; i < rates; ++i) {
    const double rate = 0.005 + 0.01 * i;
    double exact = 0;
    double wilson = 0;
    for (int k = 0; k <= n; ++k) {
      const Interval c = ClopperPearsonInterval(k, n);
      const Interval w = WilsonInterval(k, n);
      if (c.low <= rate && rate <= c.high) exact += Probability(k, n, rate);
      if (w.low <= rate && rate <= w.high) wilson += Probability(k, n, rate);
    }
    EXPECT_GE(exact, 0.95) << rate;
    wilson_sum += wilson;
  }
  EXPECT_NEAR(wilson_sum / rates, 0.95, 0.01);
}

TEST(Intervals, AreSymmetricUnderExchangeOfSuccessAndFailure) {
  for (const int n : {1, 5, 1000000}) {
    for (const int k : {0, 1, n / 3, n}) {
      for (const auto& interval : {WilsonInterval, ClopperPearsonInterval}) {
        const Interval one = interval(k, n, 0.95);
        const Interval other = interval(n - k, n, 0.95);
        EXPECT_NEAR(one.low, 1 - other.high, 1e-13) << k << "/" << n;
        EXPECT_LE(one.low, static_cast<double>(k) / n);
        EXPECT_GE(one.high, static_cast<double>(k) / n);
      }
    }
  }
}

TEST(Intervals, EndsAreExactAndNoTrialSaysNothing) {
  for (const auto& interval : {WilsonInterval, ClopperPearsonInterval}) {
    EXPECT_EQ(interval(0, 0, 0.95).low, 0);
    EXPECT_EQ(interval(0, 0, 0.95).high, 1);
    EXPECT_EQ(interval(0, 1000000, 0.95).low, 0);
    EXPECT_EQ(interval(1000000, 1000000, 0.95).high, 1);
  }
  // "Rule of three": 0 of n excludes rates above -ln(0.025)/n.
  EXPECT_NEAR(ClopperPearsonInterval(0, 1000000).high, -std::log(0.025) / 1e6, 1e-11);
}

}  // namespace
}  // namespace tendril
