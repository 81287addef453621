#pragma once
// The middle of some numbers.

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace tendril {

// The upper one of two middles; NaN of no numbers. None of them is NaN.
template <class T>
double Median(std::vector<T> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return static_cast<double>(*middle);
}

}  // namespace tendril
