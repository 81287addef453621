#include "capture/track/chain_angles.h"

#include <algorithm>
#include <limits>

namespace tendril {
namespace {

// Variances of the creases' angles, rad^2.
Eigen::VectorXd Variances(const std::vector<AngleMotion>& motions, const ChainCholesky& cholesky) {
  const std::vector<NearCovariance> near = cholesky.NearCovariances();
  const auto turns = [](const FacetMatrix& block) { return block.topLeftCorner<3, 3>(); };
  Eigen::VectorXd variances(static_cast<Eigen::Index>(motions.size()));
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const auto& [angle, before, after] = motions[i];
    variances[static_cast<Eigen::Index>(i)] =
        std::max(0.0, before.dot(before * turns(near[i].own)) + 2 * after.dot(before * turns(near[i].next)) +
                          after.dot(after * turns(near[i + 1].own)));
  }
  return variances;
}

}  // namespace

AngleKnowledge KnowledgeOfAngles(const ChainProblem& problem, const Descent& run,
                                 const ChainCholesky& cholesky, double inflation) {
  std::vector<AngleMotion> motions;
  for (std::size_t i = 0; i < problem.creases.size(); ++i) {
    motions.push_back(
        MotionOfAngle(problem.creases[i], run.facets[i].rotation.transpose() * run.facets[i + 1].rotation));
  }
  const Eigen::VectorXd variances = Variances(motions, cholesky);
  AngleKnowledge knowledge{.sigma = (inflation * variances).cwiseSqrt(),
                           .by_pictures = Eigen::VectorXd::Zero(variances.size())};

  for (std::size_t i = 0; i < motions.size(); ++i) {  // turned about an axis square to it there is no angle
    if (motions[i].after.isZero(0))
      knowledge.sigma[static_cast<Eigen::Index>(i)] = std::numeric_limits<double>::quiet_NaN();
  }

  // The same fit with nothing expected of any fold angle: what it is sure of, the pictures and the facets'
  // stiffness tell.
  constexpr double kOpen = 1e2;  // rad
  ChainProblem open = problem;
  for (CreasePrior& prior : open.priors) {
    prior.sigma_angle = kOpen;
    prior.recalled_weight = 0;
  }
  ChainOptions options = *problem.options;
  options.sigma_base_fold = options.sigma_free_opening = kOpen;
  open.options = &options;
  Linearised at = run.at;
  AddUp(open, run.facets, run.weight, at);
  const ChainCholesky alone(at.matrix);
  if (!alone.ok()) return knowledge;  // of some crease they tell nothing at all
  knowledge.by_pictures =
      (variances.array() / Variances(motions, alone).array().max(std::numeric_limits<double>::min()))
          .min(1.0);
  return knowledge;
}

}  // namespace tendril
