#include "analysis/statistics/rates_differ.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "model/check.h"

namespace tendril {
namespace {

// Likelihoods that rounding made differ, count as equal: as R has it.
constexpr double kSame = 1 + 1e-7;

void Check(const Successes& s) { TENDRIL_CHECK(s.successes >= 0 && s.successes <= s.trials); }

// Of choosing k among n, by its logarithm.
double Choices(std::int64_t n, std::int64_t k) {
  const auto log_factorial = [](std::int64_t m) { return std::lgamma(static_cast<double>(m) + 1); };
  return log_factorial(n) - log_factorial(k) - log_factorial(n - k);
}

}  // namespace

double SameRateP(const std::vector<RatePair>& places) {
  std::int64_t seen = 0, least = 0;      // successes of `one`, in all; the fewest that there could be
  std::vector<double> likelihood = {1};  // of least, least + 1, ...
  for (const RatePair& place : places) {
    Check(place.one);
    Check(place.other);
    const std::int64_t all = place.one.successes + place.other.successes;
    const std::int64_t low = std::max<std::int64_t>(0, all - place.other.trials);
    const std::int64_t high = std::min(all, place.one.trials);
    const double whole = Choices(place.one.trials + place.other.trials, all);
    std::vector<double> with(likelihood.size() + static_cast<std::size_t>(high - low), 0.0);
    for (std::int64_t k = low; k <= high; ++k) {
      const double here =
          std::exp(Choices(place.one.trials, k) + Choices(place.other.trials, all - k) - whole);
      for (std::size_t i = 0; i < likelihood.size(); ++i) {
        with[i + static_cast<std::size_t>(k - low)] += here * likelihood[i];
      }
    }
    likelihood = std::move(with);
    least += low;
    seen += place.one.successes;
  }
  const double limit = likelihood[static_cast<std::size_t>(seen - least)] * kSame;
  double p = 0;
  for (const double each : likelihood) p += each <= limit ? each : 0;
  return std::min(p, 1.0);
}

double NoTrendP(const std::vector<Scored>& groups) {
  std::int64_t successes = 0, trials = 0, seen = 0;
  for (const Scored& group : groups) {
    Check(group.of);
    TENDRIL_CHECK(group.score >= 0);
    successes += group.of.successes;
    trials += group.of.trials;
    seen += group.score * group.of.successes;
  }
  if (trials == 0) return 1;
  // By successes so far and their scores' sum.
  std::map<std::pair<std::int64_t, std::int64_t>, double> likelihood = {{{0, 0}, 1.0}};
  double scores = 0;
  std::int64_t left = trials;  // in this group and behind
  for (const Scored& group : groups) {
    std::map<std::pair<std::int64_t, std::int64_t>, double> with;
    scores += static_cast<double>(group.score) * static_cast<double>(group.of.trials);
    const std::int64_t behind = left - group.of.trials;
    for (const auto& [at, chance] : likelihood) {
      const std::int64_t still = successes - at.first;
      const std::int64_t low = std::max<std::int64_t>(0, still - behind);
      const std::int64_t high = std::min(still, group.of.trials);
      for (std::int64_t k = low; k <= high; ++k) {
        const double here =
            std::exp(Choices(group.of.trials, k) + Choices(behind, still - k) - Choices(left, still));
        with[{at.first + k, at.second + group.score * k}] += here * chance;
      }
    }
    likelihood = std::move(with);
    left = behind;
  }
  const double mean = scores * static_cast<double>(successes) / static_cast<double>(trials);
  const double limit = std::abs(static_cast<double>(seen) - mean) / kSame;
  double p = 0;
  for (const auto& [at, chance] : likelihood) {
    if (std::abs(static_cast<double>(at.second) - mean) >= limit) p += chance;
  }
  return std::min(p, 1.0);
}

}  // namespace tendril
