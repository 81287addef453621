#include "calibrate/fold/node_motion.h"

#include <fmt/core.h>

#include <cmath>

#include "model/fold/facet_chain.h"
#include "model/fold/fold.h"

namespace tendril {

Result<FoldTangent> FoldAt(const TentacleDesign& design, const TentacleLayout& layout, double effective_pull,
                           double log_ratio, double exponent) {
  if (!std::isfinite(log_ratio) || !std::isfinite(exponent)) {
    return Error{
        ErrorKind::kBadInput,
        fmt::format("stiffness: ln ratio {}, exponent {}; expected finite numbers", log_ratio, exponent)};
  }
  const Eigen::Index creases = layout.width.size();
  const Eigen::ArrayXd log_width = (layout.width.array() / design.base_width).log();
  Eigen::ArrayXd log_ratio_slope = Eigen::ArrayXd::Zero(creases);
  for (Eigen::Index i = 1; i < creases; i += 2) log_ratio_slope[i] = 1;

  TentacleLayout at = layout;
  at.stiffness = (exponent * log_width + log_ratio * log_ratio_slope).exp().matrix();
  const Result<Fold> solved = SolveFold(at, design.base_width, design.closed_angle, effective_pull);
  if (!solved.ok()) return solved.error();

  FoldTangent fold;
  fold.angle = solved.value().angle;
  fold.closed = static_cast<int>(solved.value().closed.size());
  fold.slope.setZero(creases, kFoldDirections);
  // 1 where the crease is free to move.
  const Eigen::ArrayXd open = (fold.angle.array() < design.closed_angle).cast<double>();
  // sum 2 d cos(phi) = (1 - pull) L with ln phi = ln k + ln d - ln W for open creases; its differential is
  // sum lever_i (dlnk - dlnW_i) = L dpull, lever_i = 2 d_i sin(phi_i) phi_i.
  const Eigen::ArrayXd lever =
      open * 2 * layout.half_spacing.array() * fold.angle.array().sin() * fold.angle.array();
  const double all = lever.sum();
  if (!(all > 0)) return fold;
  const Eigen::ArrayXd moving = open * fold.angle.array();
  fold.slope.col(kEffectivePull) = (moving * (FlatTendonLength(layout) / all)).matrix();
  fold.slope.col(kLogRatio) = (moving * ((lever * log_ratio_slope).sum() / all - log_ratio_slope)).matrix();
  fold.slope.col(kExponent) = (moving * ((lever * log_width).sum() / all - log_width)).matrix();
  return fold;
}

NodeMotion MoveNodes(const TentacleLayout& layout, const FoldTangent& fold) {
  const FacetChain chain = FoldChain(layout, fold.angle);
  const Eigen::Index holes = layout.hole_z.size();
  NodeMotion motion;
  motion.nodes.resize(3, holes);
  for (Eigen::Index i = 0; i < holes; ++i) {
    motion.nodes.col(i) =
        chain.tentacle_from_sheet[static_cast<std::size_t>(i)] * Eigen::Vector3d(0, 0, layout.hole_z[i]);
  }
  for (Eigen::Matrix3Xd& velocity : motion.velocity) velocity.setZero(3, holes);

  const Eigen::ArrayXd across = layout.crease_angle.array().sin().square();
  motion.folded = (across * fold.angle.array().sin().square()).matrix();
  motion.folded_slope = (across * (2 * fold.angle.array()).sin()).matrix().asDiagonal() * fold.slope;

  Eigen::Matrix3d spin = Eigen::Matrix3d::Zero();  // of the facet, one column per direction
  for (Eigen::Index i = 0; i + 1 < holes; ++i) {
    const Eigen::Isometry3d& facet = chain.tentacle_from_sheet[static_cast<std::size_t>(i)];
    const Eigen::Vector3d crease = facet * Eigen::Vector3d(0, 0, layout.crease_z[i]);
    const double a = layout.crease_angle[i];
    // Mountains (even) turn the next facet toward -x: negatively about cos(a) z + sin(a) y.
    const double sign = i % 2 == 0 ? -2 : 2;
    const Eigen::Vector3d axis = facet.linear() * Eigen::Vector3d(0, std::sin(a), std::cos(a)) * sign;
    const Eigen::Vector3d to_crease = crease - motion.nodes.col(i);
    const Eigen::Vector3d from_crease = motion.nodes.col(i + 1) - crease;
    for (Eigen::Index k = 0; k < kFoldDirections; ++k) {
      Eigen::Matrix3Xd& velocity = motion.velocity[static_cast<std::size_t>(k)];
      const Eigen::Vector3d before = spin.col(k);
      spin.col(k) += axis * fold.slope(i, k);
      const Eigen::Vector3d after = spin.col(k);
      velocity.col(i + 1) = velocity.col(i) + before.cross(to_crease) + after.cross(from_crease);
    }
  }
  return motion;
}

}  // namespace tendril
