#include "capture/track/chain_turn.h"

#include <algorithm>
#include <cmath>

#include "capture/track/chain_curve.h"

namespace tendril {

Eigen::SparseMatrix<double> CurveOfSteps(const TentacleLayout& layout,
                                         const std::vector<FacetState>& facets) {
  const int holes = static_cast<int>(facets.size());
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < 3 * holes; ++i) entries.emplace_back(i, 6 * (i / 3) + 3 + i % 3, 1.0);
  const TendonCurve tendon = SegmentsOfFacets(layout, facets);
  // Turned by w about its own axes, a facet turns by (its z) . w about the direction z.
  const auto add = [&](int node, int facet, const Eigen::Vector3d& about) {
    const Eigen::Vector3d own = facets[static_cast<std::size_t>(facet)].rotation.transpose() * about;
    for (int k = 0; k < 3; ++k) entries.emplace_back(3 * holes + node, 6 * facet + k, own[k]);
  };
  for (int node = 0; node < holes; ++node) {
    // The node's normal is the sum of its segments' ones, each of which turns with the mean of its facets.
    const int first = std::max(node - 1, 0);
    const int last = std::min(node, holes - 2);
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    Eigen::Vector3d tangent = Eigen::Vector3d::Zero();
    for (int k = first; k <= last; ++k) {
      normal += tendon.frames[static_cast<std::size_t>(k)].row(0).transpose();
      tangent += tendon.frames[static_cast<std::size_t>(k)].row(2).transpose();
    }
    const Eigen::Vector3d sideways = tangent.cross(normal);
    // Segments that turn by almost pi leave no sum; their tangents' mean stands in.
    const bool clear = sideways.norm() > 0.1 * normal.norm() && normal.norm() > 0.1;
    for (int k = first; k <= last; ++k) {
      const Eigen::Matrix3d& frame = tendon.frames[static_cast<std::size_t>(k)];
      const double share =
          clear ? sideways.normalized().dot(frame.row(1)) / normal.norm() : 1.0 / (last - first + 1);
      const Eigen::Vector3d about = 0.5 * share * frame.row(2).transpose();
      add(node, k, about);
      add(node, k + 1, about);
    }
  }
  Eigen::SparseMatrix<double> curve(4 * holes, 6 * holes);
  curve.setFromTriplets(entries.begin(), entries.end());
  return curve;
}

}  // namespace tendril
