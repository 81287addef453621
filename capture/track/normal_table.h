#pragma once
// The normal distribution's share and density, fast.

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace tendril {

// At a fixed spacing, with the rest by Taylor's series to the third order: 1e-9.
class NormalTable {
 public:
  static const NormalTable& Get() {
    static const NormalTable table;
    return table;
  }
  // Share below z, and the density there.
  struct Normal {
    double share, density;
  };
  Normal At(double z) const {
    if (z <= -kReach) return {0, 0};
    if (z >= kReach) return {1, 0};
    const double scaled = (z + kReach) * kPerUnit;
    const int i = static_cast<int>(scaled + 0.5);
    const double d = z - (i * (1.0 / kPerUnit) - kReach), at = z - d;
    const double share = shares_[static_cast<std::size_t>(i)],
                 density = densities_[static_cast<std::size_t>(i)];
    // Derivatives of phi at `at`: -at phi, (at^2 - 1) phi, (3 at - at^3) phi.
    const double second = at * at - 1;
    return {share + density * d * (1 - d * (0.5 * at - d * (1. / 6) * second)),
            density * (1 - d * (at - d * (0.5 * second + d * (1. / 6) * (3 - at * at) * at)))};
  }

 private:
  static constexpr double kReach = 4.5;
  static constexpr int kPerUnit = 64, kSize = static_cast<int>(2 * kReach * kPerUnit) + 1;
  NormalTable() {
    for (int i = 0; i < kSize; ++i) {
      const double z = static_cast<double>(i) / kPerUnit - kReach;
      shares_[static_cast<std::size_t>(i)] = 0.5 * std::erfc(-z / std::numbers::sqrt2);
      densities_[static_cast<std::size_t>(i)] =
          std::exp(-0.5 * z * z) * std::numbers::inv_sqrtpi / std::numbers::sqrt2;
    }
  }
  std::array<double, kSize> shares_{}, densities_{};
};

}  // namespace tendril
