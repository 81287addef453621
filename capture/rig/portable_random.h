#pragma once
// Random numbers that come out the same with every standard library: the generator's bits are fixed by the
// C++ standard, but the library's distributions are not.

#include <cmath>
#include <numbers>
#include <random>

namespace tendril {

// Uniform in [0, 1), 53 bits; takes one number from the generator.
inline double DrawUnit(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1.0p-53; }

inline double DrawUniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * DrawUnit(random);
}

// Normal with mean 0 (Box-Muller); takes two numbers from the generator whatever the deviation.
inline double DrawNormal(std::mt19937_64& random, double standard_deviation) {
  const double radius = std::sqrt(-2 * std::log(1 - DrawUnit(random)));
  return standard_deviation * radius * std::cos(2 * std::numbers::pi * DrawUnit(random));
}

}  // namespace tendril
