#pragma once
// Designs over the stated extremes.

#include <cmath>
#include <numbers>
#include <random>

#include "model/fold/design.h"

namespace tendril::test {

// Over the stated extremes; every design can be laid out.
inline TentacleDesign RandomDesign(std::mt19937_64& random) {
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  TentacleDesign design;
  design.holes = static_cast<int>(uniform(2, 60));
  design.unit_length = std::pow(10, uniform(-4, 1));
  design.length = design.unit_length * 0.5 * (design.holes + 2);
  design.base_width = design.unit_length * uniform(0.05, 2);
  design.taper = uniform(0.05, 1);
  design.spacing_ratio = uniform(0.05, 1);
  design.alpha = uniform(15, 165) * std::numbers::pi / 180;
  design.beta = uniform(15, 165) * std::numbers::pi / 180;
  design.stiffness_exponent = uniform(0, 3);
  design.stiffness_ratio = std::pow(10, uniform(-9, 9));
  return design;
}

}  // namespace tendril::test
