#include "model/fold/rest_curvature.h"

#include <algorithm>
#include <cmath>

#include "model/check.h"

namespace tendril {

Eigen::Matrix3Xd SmoothedTurning(const Eigen::Ref<const Eigen::Matrix3Xd>& turning, double deviation) {
  const Eigen::Index count = turning.cols();
  if (deviation <= 0 || count < 2) return turning;
  // Five deviations hold all but 6e-7 of the weight, and the weights are normalised.
  const Eigen::Index reach = static_cast<Eigen::Index>(std::ceil(5 * deviation));
  Eigen::VectorXd weight(2 * reach + 1);
  for (Eigen::Index i = -reach; i <= reach; ++i) {
    const double t = static_cast<double>(i) / deviation;
    weight[i + reach] = std::exp(-0.5 * t * t);
  }
  weight /= weight.sum();

  Eigen::Matrix3Xd smoothed = Eigen::Matrix3Xd::Zero(3, count);
  for (Eigen::Index from = 0; from < count; ++from) {
    for (Eigen::Index i = -reach; i <= reach; ++i) {
      Eigen::Index to = (from + i) % (2 * count);  // mirrored about half an entry beyond either end
      if (to < 0) to += 2 * count;
      if (to >= count) to = 2 * count - 1 - to;
      smoothed.col(to) += weight[i + reach] * turning.col(from);
    }
  }
  return smoothed;
}

RestCurvature RestCurvatureOf(const TentacleLayout& layout, const TendonCurve& curve,
                              const RestCurvatureOptions& options) {
  TENDRIL_CHECK(options.elements >= 2 && options.smoothing >= 0);
  const Eigen::Index segments = curve.segment_length.size();
  TENDRIL_CHECK(curve.turning.cols() == segments - 1 && layout.crease_z.size() == segments);
  const double rod_length = layout.tip_z - layout.base_z;
  const double span = layout.hole_z[segments] - layout.hole_z[0];
  const Eigen::Index nodes = options.elements - 1;

  RestCurvature rest;
  rest.element_length = rod_length / options.elements;
  rest.curvature.setZero(3, nodes);

  // Segment lengths as they lie on the rod.
  const double tendon_length = curve.segment_length.sum();
  const bool by_arc_length = options.map != CurvatureMap::kMaterial && tendon_length > 1e-9 * span;
  const double stretch = by_arc_length ? span / tendon_length : 1;
  const double factor = options.map == CurvatureMap::kUnscaled ? stretch : 1;
  const auto length_of = [&](Eigen::Index i) {
    return by_arc_length ? stretch * curve.segment_length[i] : layout.hole_z[i + 1] - layout.hole_z[i];
  };

  // Node m's cell reaches half an element to either side; the outer cells take the ends too. Cell -1 is the
  // base's.
  const Eigen::Index least = options.bends_at_base ? -1 : 0;
  const auto node_at = [&](double place) {
    const double cell = std::floor(place / rest.element_length - 0.5);
    return std::clamp(static_cast<Eigen::Index>(cell), least, nodes - 1);
  };
  const Eigen::Matrix3Xd turning = SmoothedTurning(curve.turning, options.smoothing);
  double hole = -layout.base_z;  // place of hole i on the rod, m
  for (Eigen::Index i = 1; i < segments; ++i) {
    hole += length_of(i - 1);
    const double begin = hole - 0.5 * length_of(i - 1);
    const double end = hole + 0.5 * length_of(i);
    const Eigen::Index first = node_at(begin);
    const Eigen::Index last = node_at(end);
    double given = 0;  // share of this hole's turning that has found its node
    for (Eigen::Index m = first; m <= last; ++m) {
      const double edge = (static_cast<double>(m) + 1.5) * rest.element_length;
      const double share = m == last ? 1 : (edge - begin) / (end - begin);
      const Eigen::Vector3d part = (factor * (share - given) / rest.element_length) * turning.col(i - 1);
      if (m < 0) {
        rest.base += 2 * part;
      } else {
        rest.curvature.col(m) += part;
      }
      given = share;
    }
  }
  return rest;
}

}  // namespace tendril
