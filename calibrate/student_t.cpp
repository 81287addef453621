#include "calibrate/student_t.h"

#include <cmath>
#include <initializer_list>
#include <limits>

#include "model/check.h"

namespace tendril {
namespace {

// Continued fraction of the incomplete beta function (Lentz's method; DLMF 8.17.22).
double BetaFraction(double a, double b, double x) {
  constexpr double kTiny = 1e-300;
  double c = 1;
  double d = 1 - (a + b) * x / (a + 1);
  d = 1 / (std::abs(d) < kTiny ? kTiny : d);
  double value = d;
  for (int m = 1; m <= 10000; ++m) {
    for (const double step : {m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)),
                              -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1))}) {
      d = 1 + step * d;
      d = 1 / (std::abs(d) < kTiny ? kTiny : d);
      c = 1 + step / c;
      if (std::abs(c) < kTiny) c = kTiny;
      value *= c * d;
    }
    if (std::abs(c * d - 1) < 1e-16) break;
  }
  return value;
}

double RegularisedBeta(double a, double b, double x) {
  if (x <= 0) return 0;
  if (x >= 1) return 1;
  const double front =
      std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x));
  return x < (a + 1) / (a + b + 2) ? front * BetaFraction(a, b, x) / a
                                   : 1 - front * BetaFraction(b, a, 1 - x) / b;
}

}  // namespace

double StudentTCdf(double t, double dof) {
  TENDRIL_CHECK(dof > 0);
  const double tail = 0.5 * RegularisedBeta(dof / 2, 0.5, dof / (dof + t * t));
  return t > 0 ? 1 - tail : tail;
}

double StudentTQuantile(double probability, double dof) {
  TENDRIL_CHECK(probability > 0 && probability < 1);
  if (probability == 0.5) return 0;
  if (probability > 0.5) return -StudentTQuantile(1 - probability, dof);
  // Negative side, where the tail keeps its digits: bracket, then bisect.
  double low = -1;
  while (StudentTCdf(low, dof) > probability && low > -std::numeric_limits<double>::max() / 4) low *= 2;
  double high = 0;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    if (middle <= low || middle >= high) break;
    (StudentTCdf(middle, dof) > probability ? high : low) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace tendril
