#include "model/fold/crease_pattern.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "model/fold/millimetres.h"

namespace tendril {
namespace {

// Facet i's corners on the side of the tip, which is where crease i ends: y < 0, y > 0, in the sheet's frame.
constexpr int kLower = 3;
constexpr int kUpper = 2;

}  // namespace

bool IsMountain(int crease) { return crease % 2 == 0; }

std::vector<std::string> WhyNoFacets(const TentacleDesign& design, const TentacleLayout& layout) {
  std::optional<std::string> leaves, cross;
  for (Eigen::Index i = 0; i < layout.crease_z.size(); ++i) {
    const Eigen::Matrix3Xd& facet = layout.facets[static_cast<std::size_t>(i)];
    const std::string place = Millimetres(layout.crease_z[i] - layout.base_z) + " from the base end";
    for (const int end : {kLower, kUpper}) {
      const double z = facet(2, end);
      const double edge = 0.5 * WidthAt(design, layout, z);
      const bool at_cut_end = z <= layout.base_z || z >= layout.tip_z;
      if (!leaves && (at_cut_end || std::abs(facet(1, end)) < edge * (1 - 1e-9))) {
        leaves = "crease " + std::to_string(i) + ", " + place + ", leaves through the ";
        *leaves += z < layout.crease_z[i] ? "base" : "tip";
        *leaves += " end instead of the ribbon's edge: take a steeper angle or a longer sheet";
      }
    }
    // Creases run from edge to edge: two of them cross exactly if they come in another order on one edge.
    if (cross || i == 0) continue;
    const Eigen::Matrix3Xd& before = layout.facets[static_cast<std::size_t>(i - 1)];
    if (facet(2, kLower) <= before(2, kLower) || facet(2, kUpper) <= before(2, kUpper)) {
      cross = "creases " + std::to_string(i - 1) + " and " + std::to_string(i) + " cross or meet, " + place +
              ": take steeper angles, a longer unit or a narrower ribbon";
    }
  }
  std::vector<std::string> reasons;
  for (auto* reason : {&cross, &leaves}) {
    if (*reason) reasons.push_back(**reason);
  }
  return reasons;
}

Result<CreasePattern> CreasePatternOf(const TentacleDesign& design, const TentacleLayout& layout) {
  if (const auto reasons = WhyNoFacets(design, layout); !reasons.empty()) {
    return Error{ErrorKind::kBadInput, "has no crease pattern: " + reasons.front()};
  }
  CreasePattern pattern;
  pattern.length = layout.tip_z - layout.base_z;
  pattern.width = design.base_width * std::max(1.0, design.taper);
  const int facets = static_cast<int>(layout.facets.size());
  pattern.vertices.resize(2, 2 * facets + 2);
  // Lines across the sheet: cut end, creases, cut end. Line j ends in vertices 2 j (y < 0) and 2 j + 1.
  const auto draw = [&](Eigen::Index vertex, const Eigen::Vector3d& in_sheet) {
    pattern.vertices.col(vertex) << in_sheet.z() - layout.base_z, 0.5 * pattern.width - in_sheet.y();
  };
  draw(0, layout.facets.front().col(0));
  draw(1, layout.facets.front().col(1));
  for (int i = 0; i < facets; ++i) {
    draw(2 * i + 2, layout.facets[static_cast<std::size_t>(i)].col(kLower));
    draw(2 * i + 3, layout.facets[static_cast<std::size_t>(i)].col(kUpper));
    pattern.faces.push_back({2 * i, 2 * i + 1, 2 * i + 3, 2 * i + 2});
  }
  for (int i = 0; i + 1 < facets; ++i) pattern.edges.push_back({2 * i + 2, 2 * i + 3, i});
  pattern.edges.push_back({0, 1, -1});
  pattern.edges.push_back({2 * facets, 2 * facets + 1, -1});
  for (int i = 0; i < facets; ++i) {
    pattern.edges.push_back({2 * i, 2 * i + 2, -1});
    pattern.edges.push_back({2 * i + 1, 2 * i + 3, -1});
  }
  return pattern;
}

Eigen::Matrix3Xd FoldedVertices(const TentacleLayout& layout, const FacetChain& chain) {
  const Eigen::Index facets = static_cast<Eigen::Index>(layout.facets.size());
  Eigen::Matrix3Xd folded(3, 2 * facets + 2);
  for (Eigen::Index i = 0; i < facets; ++i) {
    const Eigen::Isometry3d& pose = chain.tentacle_from_sheet[static_cast<std::size_t>(i)];
    const Eigen::Matrix3Xd& facet = layout.facets[static_cast<std::size_t>(i)];
    if (i == 0) folded.leftCols<2>() = pose * facet.leftCols<2>();
    folded.col(2 * i + 2) = pose * facet.col(kLower);
    folded.col(2 * i + 3) = pose * facet.col(kUpper);
  }
  return folded;
}

}  // namespace tendril
