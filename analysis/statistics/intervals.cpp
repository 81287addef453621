#include "analysis/statistics/intervals.h"

#include <boost/math/distributions/beta.hpp>
#include <boost/math/distributions/normal.hpp>
#include <cmath>

#include "model/check.h"

namespace tendril {
namespace {

void CheckCounts(std::int64_t successes, std::int64_t trials, double confidence) {
  TENDRIL_CHECK(successes >= 0 && successes <= trials);
  TENDRIL_CHECK(confidence > 0 && confidence < 1);
}

}  // namespace

Interval WilsonInterval(std::int64_t successes, std::int64_t trials, double confidence) {
  CheckCounts(successes, trials, confidence);
  if (trials == 0) return {0, 1};
  const double n = static_cast<double>(trials);
  const double rate = static_cast<double>(successes) / n;
  const double z =
      boost::math::quantile(boost::math::complement(boost::math::normal(), (1 - confidence) / 2));
  const double z2 = z * z;
  const double middle = rate + z2 / (2 * n);
  const double half = z * std::sqrt(rate * (1 - rate) / n + z2 / (4 * n * n));
  const double scale = 1 + z2 / n;
  // At the ends middle and half are equal but for rounding.
  return {successes == 0 ? 0 : (middle - half) / scale, successes == trials ? 1 : (middle + half) / scale};
}

Interval ClopperPearsonInterval(std::int64_t successes, std::int64_t trials, double confidence) {
  CheckCounts(successes, trials, confidence);
  if (trials == 0) return {0, 1};
  const double k = static_cast<double>(successes);
  const double n = static_cast<double>(trials);
  const double tail = (1 - confidence) / 2;
  using Beta = boost::math::beta_distribution<double>;
  return {successes == 0 ? 0 : boost::math::quantile(Beta(k, n - k + 1), tail),
          successes == trials ? 1 : boost::math::quantile(boost::math::complement(Beta(k + 1, n - k), tail))};
}

}  // namespace tendril
