#pragma once
// Do success rates differ, or are they told apart by luck alone? Exact tests of a few trials each.
//
// All are conditional on how many successes there are in all: what is left to luck is where they fall. They
// are two-sided, and hold for any numbers of trials, rates of 0 and 1 included. Trials are independent.

#include <cstdint>
#include <vector>

namespace tendril {

// One group of trials.
struct Successes {
  std::int64_t successes = 0, trials = 0;  // 0 <= successes <= trials
};

// Both at one place, say at one distance.
struct RatePair {
  Successes one, other;
};

// Whether `one` succeeds as often as `other`, place by place: the chance that luck alone makes the
// successes of `one`, summed over places, at most as likely as they were. Of one place it is Fisher's exact
// test; of more, the exact form of Mantel's and Haenszel's. 1 where nothing could have come out otherwise.
//   source  Fisher 1935; Gart 1970; R's fisher.test and mantelhaen.test(exact = TRUE) sum the same
double SameRateP(const std::vector<RatePair>& places);

// Groups in a row that have scores, say distances.
struct Scored {
  int score = 0;  // >= 0; only differences and their ratios matter
  Successes of;
};

// Whether rates rise or fall with the score: the chance that luck alone puts sum(score * successes) at least
// as far from its mean. The exact form of Cochran's and Armitage's test of a trend.
//   source  Armitage 1955; Agresti, Categorical Data Analysis, 3.4
double NoTrendP(const std::vector<Scored>& groups);

}  // namespace tendril
