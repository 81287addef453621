#pragma once
// A pull answered by the law that a call names: the fold angles, and what that law knows beside them.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "model/fold/design.h"
#include "model/result.h"

namespace tendril::cli {

// What either law answers; none: it has no such thing.
struct FoldAnswer {
  Eigen::VectorXd angle;
  std::vector<int> closed;
  double tendon_length = 0;
  std::optional<double> scale;
  std::optional<double> tension;
  std::optional<bool> slack;
  std::optional<double> base_tension;  // where friction makes it another
};

//   law   "paper" or "exact"; with tendon friction the latter goes from flat through `path` to the pull
//   errors  as SolveFold, SolveExactFold, FrictionTendon
Result<FoldAnswer> AnswerFold(const std::string& law, const TentacleDesign& design,
                              const TentacleLayout& layout, const std::vector<double>& path, double pull);

}  // namespace tendril::cli
