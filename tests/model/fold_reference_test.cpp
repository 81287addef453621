// model/fold against an implementation of its own (tests/scripts/fold_reference.py, in Python, bisection and
// plain matrices): holes of five designs at three pulls.
#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>

#include "model/fold/facet_chain.h"
#include "model/fold/fold.h"

namespace tendril {
namespace {

TEST(FoldReference, HolesLieWhereAnotherImplementationPutsThem) {
  std::ifstream file(TENDRIL_SOURCE_DIR "/tests/data/fold/reference.csv");
  std::string line;
  ASSERT_TRUE(std::getline(file, line));
  ASSERT_EQ(line, "taper,spacing_ratio,alpha_deg,beta_deg,pull,hole,x,y,z");
  int compared = 0;
  for (; std::getline(file, line); ++compared) {
    std::array<double, 9> value{};
    std::stringstream cells(line);
    std::string cell;
    for (double& v : value) {
      ASSERT_TRUE(std::getline(cells, cell, ','));
      v = std::stod(cell);
    }
    TentacleDesign design;
    design.taper = value[0];
    design.spacing_ratio = value[1];
    design.alpha = value[2] * std::numbers::pi / 180;
    design.beta = value[3] * std::numbers::pi / 180;
    const auto layout = LayOut(design);
    ASSERT_TRUE(layout.ok()) << layout.error().message;
    const auto fold = SolveFold(design, value[4]);
    ASSERT_TRUE(fold.ok()) << fold.error().message;
    const FacetChain chain = FoldChain(layout.value(), fold.value().angle);
    const TendonCurve curve = TendonCurveOf(layout.value(), chain, fold.value().angle);
    const Eigen::Vector3d expected(value[6], value[7], value[8]);
    // 48 creases of rounding over 0.75 m, in both programs.
    EXPECT_LT((curve.holes.col(static_cast<int>(value[5])) - expected).norm(), 1e-13) << line;
  }
  EXPECT_EQ(compared, 90);
}

}  // namespace
}  // namespace tendril
