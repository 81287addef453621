#include "capture/rig/tag_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "capture/rig/tag_family.h"
#include "model/check.h"

namespace tendril {
namespace {

// Points p of the sheet's (y, z) plane with inward . p >= offset; inward is a unit vector.
struct HalfPlane {
  Eigen::Vector2d inward;
  double offset;
};

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

// One way to pass the hole: the facet's edges and one line that the square keeps beyond.
struct Room {
  std::vector<HalfPlane> within;
  double largest = 0;  // side of the largest square, m
};

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

struct Facet {
  Polygon corners;          // (y, z), m
  std::vector<Room> rooms;  // beyond the hole, before it, on either side of it
  double largest() const {
    double most = 0;
    for (const Room& room : rooms) most = std::max(most, room.largest);
    return most;
  }
};

Facet RoomsOf(const TentacleLayout& layout, int index, double hole_radius, double clearance) {
  Facet facet;
  const Eigen::Matrix3Xd& corners = layout.facets[static_cast<size_t>(index)];
  for (int i = 0; i < corners.cols(); ++i) facet.corners.emplace_back(corners(1, i), corners(2, i));

  std::vector<HalfPlane> edges;
  for (size_t i = 0; i < facet.corners.size(); ++i) {
    const Eigen::Vector2d& a = facet.corners[i];
    const Eigen::Vector2d along = facet.corners[(i + 1) % facet.corners.size()] - a;
    if (!(along.norm() > 0)) continue;
    const Eigen::Vector2d inward = Eigen::Vector2d(-along.y(), along.x()).normalized();
    edges.push_back({inward, inward.dot(a) + clearance});
  }
  const Eigen::Vector2d hole(0, layout.hole_z[index]);
  for (const Eigen::Vector2d& away :
       {Eigen::Vector2d(0, 1), Eigen::Vector2d(0, -1), Eigen::Vector2d(1, 0), Eigen::Vector2d(-1, 0)}) {
    Room room{.within = edges};
    room.within.push_back({away, away.dot(hole) + hole_radius + clearance});
    room.largest = LargestSquare(room.within, facet.corners);
    facet.rooms.push_back(room);
  }
  return facet;
}

// Centre of a square of this side; the caller has made sure that there is room.
Eigen::Vector2d PlaceSquare(const Facet& facet, double side) {
  for (const Room& room : facet.rooms) {
    if (room.largest < side) continue;
    const Polygon centers = CentersOf(side, room.within, facet.corners);
    if (!centers.empty()) return Centroid(centers);
  }
  TENDRIL_CHECK(false && "no room for a square that was found to fit");
  return {};
}

// Corners in the detector's order for a tag whose top is toward the tip. Seen from outside, y is to the
// right; seen from inside, to the left.
Eigen::Matrix<double, 3, 4> CornersOf(const Eigen::Vector2d& center, double border, TagSide side) {
  const double right = side == TagSide::kOuter ? 0.5 * border : -0.5 * border;
  const double up = 0.5 * border;
  Eigen::Matrix<double, 3, 4> corners;
  corners.row(0).setZero();
  corners.row(1) = Eigen::RowVector4d(-right, right, right, -right).array() + center.x();
  corners.row(2) = Eigen::RowVector4d(-up, -up, up, up).array() + center.y();
  return corners;
}

Error Bad(std::string message) { return {ErrorKind::kBadInput, std::move(message)}; }

Status CheckOptions(const TagLayoutOptions& options) {
  const auto not_negative = [](double v) { return std::isfinite(v) && v >= 0; };
  if (!not_negative(options.footprint)) {
    return Bad(
        fmt::format("tag footprint is {} m; expected 0 (the largest that fits) or more", options.footprint));
  }
  if (!(options.largest_footprint > 0)) {
    return Bad(fmt::format("largest tag footprint is {} m; expected more than 0", options.largest_footprint));
  }
  if (!not_negative(options.smallest_footprint)) {
    return Bad(fmt::format("smallest tag footprint is {} m; expected 0 or more", options.smallest_footprint));
  }
  if (!not_negative(options.clearance)) {
    return Bad(fmt::format("tag clearance is {} m; expected 0 or more", options.clearance));
  }
  if (options.first_id < 0) {
    return Bad(fmt::format("first tag id is {}; expected 0 or more", options.first_id));
  }
  return Ok{};
}

}  // namespace

const TagPlace* TagLayout::Find(int id) const {
  const auto at = std::lower_bound(tags.begin(), tags.end(), id,
                                   [](const TagPlace& tag, int wanted) { return tag.id < wanted; });
  return at != tags.end() && at->id == id ? &*at : nullptr;
}

Result<TagLayout> LayOutTags(const TentacleDesign& design, const Gripper& gripper,
                             const TagLayoutOptions& options) {
  if (auto s = CheckOptions(options); !s.ok()) return s.error();
  if (gripper.tentacles < 1) {
    return Bad(fmt::format("the gripper has {} tentacles; expected 1 or more", gripper.tentacles));
  }
  const auto family = FamilyOf(options.family);
  if (!family.ok()) return family.error();

  // Neighbours may be mirror images: at most two kinds of tentacle, by the number's parity.
  std::vector<std::vector<Facet>> facets;
  for (int kind = 0; kind < std::min(gripper.tentacles, 2); ++kind) {
    const auto layout = LayOut(DesignOfTentacle(gripper, design, kind));
    if (!layout.ok()) return layout.error();
    facets.emplace_back();
    for (int i = 0; i < static_cast<int>(layout.value().facets.size()); ++i) {
      facets.back().push_back(RoomsOf(layout.value(), i, 0.5 * design.hole_diameter, options.clearance));
    }
  }

  double footprint = options.footprint;
  if (footprint == 0) {
    footprint = options.largest_footprint;
    bool any = false;
    for (const auto& kind : facets) {
      for (const Facet& facet : kind) {
        if (facet.largest() < options.smallest_footprint) continue;
        any = true;
        footprint = std::min(footprint, facet.largest());
      }
    }
    if (!any || !(footprint > 0)) {
      return Bad(
          fmt::format("no facet has room for a tag of {:.3g} mm clear of hole and creases; expected wider or "
                      "longer facets, or a smaller smallest footprint",
                      1e3 * options.smallest_footprint));
    }
  } else {
    for (const auto& kind : facets) {
      for (size_t i = 0; i < kind.size(); ++i) {
        if (kind[i].largest() >= footprint) continue;
        return Bad(
            fmt::format("facet {} has no room for a tag of {:.4g} mm clear of its hole and creases; at most "
                        "{:.4g} mm fit",
                        i, 1e3 * footprint, 1e3 * kind[i].largest()));
      }
    }
  }

  TagLayout tags{.family = options.family, .tags = {}};
  const double border = footprint * family.value().border_width / family.value().total_width;
  int id = options.first_id;
  for (int tentacle = 0; tentacle < gripper.tentacles; ++tentacle) {
    const std::vector<Facet>& own = facets[static_cast<size_t>(tentacle % 2)];
    for (size_t i = 0; i < own.size(); ++i) {
      if (own[i].largest() < footprint) continue;
      const Eigen::Vector2d center = PlaceSquare(own[i], footprint);
      for (const TagSide side : {TagSide::kOuter, TagSide::kInner}) {
        tags.tags.push_back({.id = id++,
                             .tentacle = tentacle,
                             .facet = static_cast<int>(i),
                             .side = side,
                             .footprint = footprint,
                             .corners_in_sheet = CornersOf(center, border, side)});
      }
    }
  }
  if (id > family.value().ids) {
    return Bad(fmt::format(
        "{} has {} ids, but {} tags from id {} on are needed; expected fewer tentacles or a larger "
        "family (tagStandard41h12 has 2115)",
        options.family, family.value().ids, tags.tags.size(), options.first_id));
  }
  return tags;
}

}  // namespace tendril
