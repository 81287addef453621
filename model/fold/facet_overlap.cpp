#include "model/fold/facet_overlap.h"

#include <algorithm>
#include <numeric>

#include "model/check.h"

namespace tendril {
namespace {

using Corners = Eigen::Matrix<double, 3, 4>;

// Whether an edge of `edges` crosses the inside of the facet `face`. face_from_edges maps the one's sheet
// coordinates to the other's, in which the facet lies in x = 0.
bool Pierces(const Eigen::Isometry3d& face_from_edges, const Corners& edges, const Corners& face,
             double tolerance) {
  const Corners moved = (face_from_edges.linear() * edges).colwise() + face_from_edges.translation();
  for (int e = 0; e < 4; ++e) {
    const Eigen::Vector3d p = moved.col(e);
    const Eigen::Vector3d q = moved.col((e + 1) % 4);
    if (std::min(p.x(), q.x()) > -tolerance || std::max(p.x(), q.x()) < tolerance) continue;
    const double share = p.x() / (p.x() - q.x());
    const double y = p.y() + share * (q.y() - p.y());
    const double z = p.z() + share * (q.z() - p.z());
    bool inside = true;  // facets are convex and counter-clockwise from +x
    for (int i = 0; i < 4 && inside; ++i) {
      const Eigen::Vector3d a = face.col(i);
      const Eigen::Vector3d along = face.col((i + 1) % 4) - a;
      inside = along.y() * (z - a.z()) - along.z() * (y - a.y()) > tolerance * along.norm();
    }
    if (inside) return true;
  }
  return false;
}

}  // namespace

std::vector<std::pair<int, int>> OverlappingFacets(const TentacleLayout& layout, const FacetChain& chain) {
  const int count = static_cast<int>(layout.facets.size());
  TENDRIL_CHECK(chain.tentacle_from_sheet.size() == layout.facets.size());
  const double tolerance = 1e-9 * (layout.tip_z - layout.base_z);

  // Bounding boxes, swept along the axis in which the tentacle is longest.
  Eigen::Matrix3Xd low(3, count);
  Eigen::Matrix3Xd high(3, count);
  for (int i = 0; i < count; ++i) {
    const Eigen::Isometry3d& pose = chain.tentacle_from_sheet[i];
    const Eigen::Matrix3Xd corners = (pose.linear() * layout.facets[i]).colwise() + pose.translation();
    low.col(i) = corners.rowwise().minCoeff();
    high.col(i) = corners.rowwise().maxCoeff();
  }
  int axis = 0;
  (high.rowwise().maxCoeff() - low.rowwise().minCoeff()).maxCoeff(&axis);
  std::vector<int> order(count);
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) { return low(axis, a) < low(axis, b); });

  std::vector<std::pair<int, int>> pairs;
  for (int m = 0; m < count; ++m) {
    for (int n = m + 1; n < count && low(axis, order[n]) <= high(axis, order[m]); ++n) {
      const auto [i, j] = std::minmax(order[m], order[n]);
      if (j - i < 2) continue;
      if ((low.col(i).array() > high.col(j).array()).any()) continue;
      if ((low.col(j).array() > high.col(i).array()).any()) continue;
      const Corners a = layout.facets[i];
      const Corners b = layout.facets[j];
      const Eigen::Isometry3d a_from_b =
          chain.tentacle_from_sheet[i].inverse() * chain.tentacle_from_sheet[j];
      if (Pierces(a_from_b, b, a, tolerance) || Pierces(a_from_b.inverse(), a, b, tolerance)) {
        pairs.emplace_back(i, j);
      }
    }
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace tendril
