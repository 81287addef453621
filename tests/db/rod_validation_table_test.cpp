// All of the table of docs/validation.md: errors, orders of convergence, what is kept.
#include <gtest/gtest.h>

#include <map>

#include "tests/support/rod_validation.h"

namespace tendril::testing_support {
namespace {

// The largest relative error of each case.
const std::map<std::string, double> kErrors = {{"elastica", 4e-4},
                                               {"heavy_elastica", 3e-3},
                                               {"thick_cantilever", 3e-4},
                                               {"tip_couple", 1e-3},
                                               {"bend45", 6e-4},
                                               {"column", 6e-4},
                                               {"helix", 2e-4},
                                               {"first_mode", 1e-3},
                                               {"twist_buckling", 5e-4},
                                               {"ring", 2e-3},
                                               {"localised_helix", 1e-2},
                                               {"plectoneme", 1e-4},
                                               {"impact", 1e-3},
                                               {"free_rod", 0},
                                               {"capstan", 2e-2},
                                               {"incline", 5e-3},
                                               {"rolling", 1e-3},
                                               {"stick_slip", 2e-2},
                                               {"tangle", 0},
                                               {"sinking", 2e-3},
                                               {"pendulum", 1e-4},
                                               {"collision", 0},
                                               {"held", 0},
                                               {"overhand", 3e-2}};

// The largest figure where the reference is 0.
const std::map<std::string, double> kLeft = {{"gap / L", 1e-8},
                                             {"its change in the last tenth, rad", 3e-3},
                                             {"profile off, rms / rms", 0.02},
                                             {"largest deviation on the way, turns", 1e-4},
                                             {"energy swing at 100 us", 1e-3},
                                             {"energy swing at 50 us", 3e-4},
                                             {"energy swing at 25 us", 7e-5},
                                             {"momentum drift", 1e-12},
                                             {"angular momentum drift", 1e-11},
                                             {"box: creep at 0.995 mu, m/s", 1e-9},
                                             {"rod: creep at 0.995 mu, m/s", 1e-9},
                                             {"largest rise of energy / energy at the start", 1e-3},
                                             {"way in 60 s, m", 1e-4},
                                             {"turn in 60 s, rad", 1e-3}};

TEST(RodValidation, TheWholeTableHolds) {
  int compared = 0;
  for (const ValidationCase& one : ValidationCases()) {
    if (one.by_name_alone) continue;
    for (const Figure& f : one.run(false)) {
      SCOPED_TRACE(std::string(one.name) + ", " + f.quantity + ", " + f.level);
      EXPECT_TRUE(std::isfinite(f.ours));
      compared += std::isfinite(f.reference) ? 1 : 0;
      if (f.level == "paper's loads") continue;  // they keep no energy: docs/rods.md
      if (f.reference == 0) {
        EXPECT_LT(std::abs(f.ours), kLeft.at(f.quantity));
      } else if (std::isfinite(f.reference)) {
        EXPECT_LT(f.Error(), kErrors.at(one.name));
      }
      if (std::isfinite(f.order)) {
        EXPECT_NEAR(f.order, 2, 0.15);
      }
    }
  }
  // None has lost its reference.
  EXPECT_EQ(compared, 112);
}

}  // namespace
}  // namespace tendril::testing_support
