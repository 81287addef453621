// model/fold/fold.h: the closed form of one crease, published angles, the length constraint and its extremes.
#include "model/fold/fold.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace tendril {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

TEST(SolveFold, PublishedAnglesOfTheUntaperedTentacle) {
  TentacleDesign design;
  design.taper = 1;
  const Result<Fold> fold = SolveFold(design, 0.3);
  ASSERT_TRUE(fold.ok()) << fold.error().message;
  EXPECT_NEAR(fold.value().angle[1] / kDegree, 26.477, 1e-3);
  EXPECT_NEAR(fold.value().angle[0] / kDegree, 52.955, 1e-3);
}

TEST(SolveFold, OneCreaseFollowsItsClosedForm) {
  TentacleDesign design;
  design.holes = 2;
  for (const double pull : {1e-300, 1e-20, 1e-9, 0.3, 0.999, std::nextafter(1.0, 0.0), 1.0}) {
    const Result<Fold> fold = SolveFold(design, pull);
    ASSERT_TRUE(fold.ok()) << fold.error().message;
    const double exact = 2 * std::asin(std::sqrt(pull / 2));
    EXPECT_NEAR(fold.value().angle[0] / exact, 1, 1e-14) << "pull " << pull;
  }
}

}  // namespace
}  // namespace tendril
