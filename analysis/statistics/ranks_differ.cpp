#include "analysis/statistics/ranks_differ.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace tendril {

RanksDiffer CompareRanks(const std::vector<double>& one, const std::vector<double>& other) {
  if (one.empty() || other.empty()) return {};
  double larger = 0;
  for (const double a : one) {
    for (const double b : other) larger += a > b ? 1 : a == b ? 0.5 : 0;
  }
  const std::size_t n = one.size(), m = other.size();
  const double pairs = static_cast<double>(n) * static_cast<double>(m);
  // chance[i][u]: of u larger pairs among i values of one and the j of other that were taken so far. The
  // largest of all is one's with i / (i + j), and is then larger than all j.
  std::vector<std::vector<double>> chance(n + 1);
  for (std::size_t i = 0; i <= n; ++i) chance[i] = {1};
  for (std::size_t j = 1; j <= m; ++j) {
    for (std::size_t i = 1; i <= n; ++i) {
      const double share = static_cast<double>(i) / static_cast<double>(i + j);
      std::vector<double> with(i * j + 1, 0.0);
      for (std::size_t u = 0; u < chance[i - 1].size(); ++u) with[u + j] += share * chance[i - 1][u];
      for (std::size_t u = 0; u < chance[i].size(); ++u) with[u] += (1 - share) * chance[i][u];
      chance[i] = std::move(with);
    }
  }
  const double away = std::abs(larger - pairs / 2) * (1 - 1e-12);
  double p = 0;
  for (std::size_t u = 0; u < chance[n].size(); ++u) {
    if (std::abs(static_cast<double>(u) - pairs / 2) >= away) p += chance[n][u];
  }
  return {larger / pairs, std::min(p, 1.0)};
}

}  // namespace tendril
