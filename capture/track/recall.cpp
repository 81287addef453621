#include "capture/track/recall.h"

#include <cmath>
#include <limits>

namespace tendril {

MomentAngles AnglesOf(double time, const ChainModel& model, const ChainSolution& solution) {
  return {.time = time,
          .expected = model.expected_angle,
          .angle = solution.angle,
          .sigma = solution.angle_sigma,
          .by_pictures = solution.angle_by_pictures};
}

RecalledAngles RecallAngles(const MomentAngles& now, std::span<const MomentAngles> near,
                            const ChainOptions& options) {
  const Eigen::VectorXd none =
      Eigen::VectorXd::Constant(now.angle.size(), std::numeric_limits<double>::quiet_NaN());
  RecalledAngles recalled{.angle = none, .sigma = none};
  for (Eigen::Index i = 0; i < now.angle.size(); ++i) {
    if (now.by_pictures[i] >= kToldByPictures) continue;
    for (const MomentAngles& other : near) {
      if (!(other.by_pictures[i] >= kToldByPictures) || !std::isfinite(other.sigma[i])) continue;
      const double change = now.expected[i] - other.expected[i];
      const double walked =
          options.sigma_recall_walk * options.sigma_recall_walk * std::abs(now.time - other.time);
      // What that moment was sure of for other reasons than its pictures, this one has of its own.
      const double told = other.sigma[i] * other.sigma[i] / other.by_pictures[i];
      const double sigma = std::sqrt(
          told + walked + std::pow((options.fold_law ? options.sigma_recall_change : 1.0) * change, 2));
      if (sigma >= recalled.sigma[i]) continue;  // false where nothing is recalled yet
      recalled.angle[i] = other.angle[i] + (options.fold_law ? change : 0.0);
      recalled.sigma[i] = sigma;
    }
  }
  return recalled;
}

}  // namespace tendril
