#pragma once
// How sure is a success rate? Intervals for a binomial proportion from k successes in n trials.

#include <cstdint>

namespace tendril {

struct Interval {
  double low = 0;
  double high = 1;
};

// Wilson's score interval: near the stated coverage on average, also for few trials and rates near 0 and 1.
// 0 and 1 are exact ends at k = 0 and k = n. n = 0 gives [0, 1].
//   0 <= k <= n; confidence in (0, 1)
//   source  Wilson 1927; Newcombe 1998, method 3
Interval WilsonInterval(std::int64_t successes, std::int64_t trials, double confidence = 0.95);

// Clopper and Pearson's interval: covers at least as often as stated, whatever the true rate; wider.
//   source  Clopper & Pearson 1934, by beta quantiles; Newcombe 1998, method 5
Interval ClopperPearsonInterval(std::int64_t successes, std::int64_t trials, double confidence = 0.95);

}  // namespace tendril
