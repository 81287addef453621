#include "calibrate/fold/node_motion.h"

#include <fmt/core.h>

#include <cmath>
#include <vector>

#include "model/fold/facet_chain.h"

namespace tendril {

Result<FoldTangent> FoldAt(const TentacleDesign& design, const TentacleLayout& layout,
                           const FoldPoint& point) {
  if (!std::isfinite(point.log_ratio) || !std::isfinite(point.exponent)) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("stiffness: ln ratio {}, exponent {}; expected finite numbers", point.log_ratio,
                             point.exponent)};
  }
  const Eigen::Index creases = layout.width.size();
  Eigen::MatrixXd directions = Eigen::MatrixXd::Zero(creases, 2);  // of ln W: ln ratio, exponent
  for (Eigen::Index i = 1; i < creases; i += 2) directions(i, 0) = 1;
  directions.col(1) = (layout.width.array() / design.base_width).log().matrix();

  TentacleDesign with = design;
  with.rest_angle = point.rest_angle;
  with.tendon_friction = point.friction;
  TentacleLayout at;  // what the laws read; a copy of the facets would cost more than the fold
  at.half_spacing = layout.half_spacing;
  at.crease_angle = layout.crease_angle;
  at.width = layout.width;
  at.stiffness = (directions * Eigen::Vector2d(point.log_ratio, point.exponent)).array().exp().matrix();
  const Result<RisingFold> solved = SolveRisingFold(point.law, with, at, point.effective_pull);
  if (!solved.ok()) return solved.error();
  const RisingSlopes slopes = SlopesOf(point.law, with, at, solved.value(), directions, point.by_friction);

  FoldTangent fold;
  fold.angle = solved.value().angle;
  fold.closed = solved.value().closed;
  fold.slope.resize(creases, kFoldDirections);
  fold.slope << slopes.pull, slopes.stiffness, slopes.rest_angle, slopes.friction;
  if (!point.by_rest_angle) fold.slope.col(kRestAngle).setZero();
  if (!point.by_friction) fold.slope.col(kFriction).setZero();
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

  std::vector<Eigen::Index> moving;  // directions in which anything moves
  for (Eigen::Index k = 0; k < kFoldDirections; ++k) {
    if (!fold.slope.col(k).isZero(0)) moving.push_back(k);
  }
  // Of the facet, one column per direction.
  Eigen::Matrix<double, 3, kFoldDirections> spin = Eigen::Matrix<double, 3, kFoldDirections>::Zero();
  for (Eigen::Index i = 0; i + 1 < holes; ++i) {
    const Eigen::Isometry3d& facet = chain.tentacle_from_sheet[static_cast<std::size_t>(i)];
    const Eigen::Vector3d crease = facet * Eigen::Vector3d(0, 0, layout.crease_z[i]);
    const double a = layout.crease_angle[i];
    // Mountains (even) turn the next facet toward -x: negatively about cos(a) z + sin(a) y.
    const double sign = i % 2 == 0 ? -2 : 2;
    const Eigen::Vector3d axis = facet.linear() * Eigen::Vector3d(0, std::sin(a), std::cos(a)) * sign;
    const Eigen::Vector3d to_crease = crease - motion.nodes.col(i);
    const Eigen::Vector3d from_crease = motion.nodes.col(i + 1) - crease;
    for (const Eigen::Index k : moving) {
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
