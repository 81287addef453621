#include "capture/rig/tag_room.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/check.h"

namespace tendril {
namespace {

using Polygon = std::vector<Eigen::Vector2d>;

Polygon Clip(const Polygon& polygon, const HalfPlane& keep) {
  Polygon kept;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& a = polygon[i];
    const Eigen::Vector2d& b = polygon[(i + 1) % polygon.size()];
    const double over_a = keep.inward.dot(a) - keep.offset;
    const double over_b = keep.inward.dot(b) - keep.offset;
    if (over_a >= 0) kept.push_back(a);
    if ((over_a >= 0) != (over_b >= 0)) kept.push_back(a + (b - a) * (over_a / (over_a - over_b)));
  }
  return kept;
}

// Where the centre of an upright square may lie so that the square keeps within all half-planes.
Polygon CentersOf(double side, const std::vector<HalfPlane>& within, const Polygon& around) {
  Polygon centers = around;
  for (const HalfPlane& edge : within) {
    const double reach = 0.5 * side * edge.inward.cwiseAbs().sum();
    centers = Clip(centers, {edge.inward, edge.offset + reach});
    if (centers.empty()) break;
  }
  return centers;
}

Eigen::Vector2d Centroid(const Polygon& polygon) {
  double area = 0;
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  const Eigen::Vector2d& origin = polygon.front();
  double size2 = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d a = polygon[i] - origin;
    const Eigen::Vector2d b = polygon[(i + 1) % polygon.size()] - origin;
    const double twice = a.x() * b.y() - a.y() * b.x();
    area += 0.5 * twice;
    moment += twice / 6 * (a + b);
    mean += a / static_cast<double>(polygon.size());
    size2 = std::max(size2, a.squaredNorm());
  }
  if (std::abs(area) <= 1e-9 * size2) return origin + mean;  // a segment or a point
  return origin + moment / area;
}

double LargestSquare(const std::vector<HalfPlane>& within, const Polygon& around) {
  double low = 0;
  double high = 0;
  for (const Eigen::Vector2d& p : around) high = std::max(high, (p - around.front()).cwiseAbs().maxCoeff());
  if (CentersOf(0, within, around).empty()) return 0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (CentersOf(middle, within, around).empty() ? high : low) = middle;
  }
  return low;
}

std::vector<HalfPlane> EdgesOf(const Polygon& corners, double clearance) {
  std::vector<HalfPlane> edges;
  for (size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d& a = corners[i];
    const Eigen::Vector2d along = corners[(i + 1) % corners.size()] - a;
    if (!(along.norm() > 0)) continue;
    const Eigen::Vector2d inward = Eigen::Vector2d(-along.y(), along.x()).normalized();
    edges.push_back({inward, inward.dot(a) + clearance});
  }
  return edges;
}

// Of the largest upright square with its centre there, m.
double LargestCentredOn(const Eigen::Vector2d& center, const std::vector<HalfPlane>& within) {
  double side = std::numeric_limits<double>::infinity();
  for (const HalfPlane& edge : within) {
    side = std::min(side, 2 * (edge.inward.dot(center) - edge.offset) / edge.inward.cwiseAbs().sum());
  }
  return std::isfinite(side) ? std::max(side, 0.0) : 0.0;
}

}  // namespace

std::vector<FacetRoom> RoomsOf(const TentacleDesign& design, const TentacleLayout& layout, double clearance) {
  std::vector<FacetRoom> rooms;
  const auto creases = layout.crease_z.size();
  for (Eigen::Index facet = 0; facet < layout.hole_z.size(); ++facet) {
    FacetRoom room;
    const double hole_z = layout.hole_z[facet];
    const double low = facet == 0 ? layout.base_z : layout.crease_z[facet - 1];
    const double high = facet == creases ? layout.tip_z : layout.crease_z[facet];
    room.length = high - low;
    room.before_hole = hole_z - low;
    room.beyond_hole = high - hole_z;
    room.width = WidthAt(design, layout, hole_z);
    room.hole = {0, hole_z};
    const Eigen::Matrix3Xd& corners = layout.facets[static_cast<size_t>(facet)];
    for (int i = 0; i < corners.cols(); ++i) room.corners.emplace_back(corners(1, i), corners(2, i));

    const std::vector<HalfPlane> edges = EdgesOf(room.corners, clearance);
    room.largest_over = LargestCentredOn(room.hole, edges);
    for (const Eigen::Vector2d& away :
         {Eigen::Vector2d(0, 1), Eigen::Vector2d(0, -1), Eigen::Vector2d(1, 0), Eigen::Vector2d(-1, 0)}) {
      FacetRoom::Way way{.within = edges};
      way.within.push_back({away, away.dot(room.hole) + 0.5 * design.hole_diameter + clearance});
      way.largest = LargestSquare(way.within, room.corners);
      room.largest_beside = std::max(room.largest_beside, way.largest);
      room.ways.push_back(std::move(way));
    }
    rooms.push_back(std::move(room));
  }
  return rooms;
}

Eigen::Vector2d PlaceBesideHole(const FacetRoom& room, double side) {
  for (const FacetRoom::Way& way : room.ways) {
    if (way.largest < side) continue;
    const Polygon centers = CentersOf(side, way.within, room.corners);
    if (!centers.empty()) return Centroid(centers);
  }
  TENDRIL_CHECK(false && "no room for a square that was found to fit");
  return {};
}

}  // namespace tendril
