// calibrate/student_t.h: published quantiles, the closed forms of one and two degrees of freedom.
#include "calibrate/student_t.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace tendril {
namespace {

TEST(StudentT, MatchesPublishedQuantiles) {
  // NIST/SEMATECH e-Handbook, table 1.3.6.7.2, upper 2.5 % (three decimals).
  EXPECT_NEAR(StudentTQuantile(0.975, 5), 2.571, 5e-4);
  EXPECT_NEAR(StudentTQuantile(0.975, 11), 2.201, 5e-4);
  EXPECT_NEAR(StudentTQuantile(0.975, 19), 2.093, 5e-4);
  EXPECT_NEAR(StudentTQuantile(0.95, 11), 1.796, 5e-4);
  EXPECT_NEAR(StudentTQuantile(0.999, 3), 10.215, 5e-4);
}

TEST(StudentT, OneDegreeIsCauchyAndTwoHasAClosedForm) {
  for (const double p : {1e-6, 0.01, 0.3, 0.6, 0.975, 0.9999}) {
    const double cauchy = std::tan(std::numbers::pi * (p - 0.5));
    EXPECT_NEAR(StudentTQuantile(p, 1), cauchy, 1e-8 * std::abs(cauchy));
    const double two = (2 * p - 1) / std::sqrt(2 * p * (1 - p));
    EXPECT_NEAR(StudentTQuantile(p, 2), two, 1e-8 * std::abs(two));
  }
}

TEST(StudentT, ManyDegreesAreNormal) { EXPECT_NEAR(StudentTQuantile(0.975, 1e8), 1.959963984540054, 1e-6); }

TEST(StudentT, QuantileAndCdfAreInverse) {
  for (const double dof : {0.5, 1.0, 3.0, 7.5, 40.0}) {
    for (const double p : {1e-4, 0.2, 0.5, 0.8, 0.9999}) {
      EXPECT_NEAR(StudentTCdf(StudentTQuantile(p, dof), dof), p, 1e-10) << dof << " " << p;
    }
  }
}

}  // namespace
}  // namespace tendril
