#pragma once
// Is a quantity larger in one group than in another? Mann's and Whitney's test, exact, of a few values each.

#include <vector>

namespace tendril {

struct RanksDiffer {
  double share =
      0.5;       // of pairs (a value of `one`, a value of `other`) in which the first is larger; equal: half
  double p = 1;  // chance that luck alone brings the share as far from a half, two-sided
};

// Values are finite. p counts no ties: of values that are equal it is too large or too small by a little.
// Without a value on either side {0.5, 1}.
//   source  Mann & Whitney 1947
RanksDiffer CompareRanks(const std::vector<double>& one, const std::vector<double>& other);

}  // namespace tendril
