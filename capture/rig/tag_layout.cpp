#include "capture/rig/tag_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "capture/rig/tag_family.h"
#include "capture/rig/tag_room.h"

namespace tendril {
namespace {

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
  if (options.every < 1) {
    return Bad(fmt::format("tags on every {}th facet; expected 1 or more", options.every));
  }
  return Ok{};
}

// Which sizes facets hold, for one family and the options.
struct Fitting {
  double hole_diameter = 0;  // m
  double void_share = 0;     // of a tag's side that is unused in its middle; 0: tags lie beside holes only

  bool FitsOver(const FacetRoom& room, double side) const {
    return side <= room.largest_over && side * void_share >= hole_diameter && void_share > 0;
  }
  bool Fits(const FacetRoom& room, double side) const {
    return side <= room.largest_beside || FitsOver(room, side);
  }
  // The largest that fits and is at most `bound`, m; 0: none.
  double Largest(const FacetRoom& room, double bound) const {
    const double over = std::min(room.largest_over, bound);
    return std::max(FitsOver(room, over) ? over : 0.0, std::min(room.largest_beside, bound));
  }
  Eigen::Vector2d Place(const FacetRoom& room, double side) const {
    return FitsOver(room, side) ? room.hole : PlaceBesideHole(room, side);
  }
};

using Rooms = std::vector<std::vector<FacetRoom>>;  // [kind of tentacle][facet]

// One size for all facets that carry tags and hold the smallest, m.
Result<double> EqualSize(const Rooms& rooms, const Fitting& fitting, const TagLayoutOptions& options) {
  const double infinite = std::numeric_limits<double>::infinity();
  double beside = options.largest_footprint;
  double any_way = infinite;
  bool any = false;
  const auto carries = [&](const FacetRoom& room) {
    return fitting.Largest(room, infinite) >= options.smallest_footprint;
  };
  const auto for_all = [&](const auto& ask) {
    for (const auto& kind : rooms) {
      for (size_t i = 0; i < kind.size(); i += static_cast<size_t>(options.every)) {
        if (carries(kind[i])) ask(kind[i]);
      }
    }
  };
  for_all([&](const FacetRoom& room) {
    any = true;
    beside = std::min(beside, room.largest_beside);
    any_way = std::min(any_way, fitting.Largest(room, infinite));
  });
  bool some_over = false;
  bool all_fit = true;
  for_all([&](const FacetRoom& room) {
    some_over = some_over || fitting.FitsOver(room, any_way);
    all_fit = all_fit && fitting.Fits(room, any_way);
  });
  const double size = some_over && all_fit && any_way > beside ? any_way : beside;
  if (!any || !(size > 0)) {
    return Bad(
        fmt::format("no facet has room for a tag of {:.3g} mm clear of hole and creases; expected wider or "
                    "longer facets, or a smaller smallest footprint",
                    1e3 * options.smallest_footprint));
  }
  return size;
}

Status CheckRoom(const Rooms& rooms, const Fitting& fitting, const TagLayoutOptions& options) {
  for (const auto& kind : rooms) {
    for (size_t i = 0; i < kind.size(); i += static_cast<size_t>(options.every)) {
      if (fitting.Fits(kind[i], options.footprint)) continue;
      return Bad(fmt::format(
          "facet {} has no room for a tag of {:.4g} mm clear of its hole and creases; at most {:.4g} mm fit",
          i, 1e3 * options.footprint,
          1e3 * fitting.Largest(kind[i], std::numeric_limits<double>::infinity())));
    }
  }
  return Ok{};
}

// "; tag36h10 has 2320, ...": families with a square outline that would do.
std::string FamiliesWith(int ids) {
  std::string text;
  for (const std::string& name : TagFamilyNames()) {
    const auto family = FamilyOf(name);
    if (family.ok() && family.value().ids >= ids && !family.value().round) {
      text += fmt::format("{}{} has {}", text.empty() ? "" : ", ", name, family.value().ids);
    }
  }
  return text.empty() ? "no family has so many" : text;
}

}  // namespace

TagLayoutOptions LayoutOptionsOf(const TagSpec& spec) {
  return {.family = spec.family,
          .footprint = spec.footprint,
          .first_id = spec.first_id,
          .each = spec.sizes == TagSizes::kEach,
          .every = spec.every,
          .sides = spec.sides,
          .over_hole = spec.over_hole};
}

const TagPlace* TagLayout::Find(int id) const {
  const auto at = std::lower_bound(tags.begin(), tags.end(), id,
                                   [](const TagPlace& tag, int wanted) { return tag.id < wanted; });
  return at != tags.end() && at->id == id ? &*at : nullptr;
}

double SmallestFootprint(const TagLayout& layout) {
  double smallest = layout.tags.front().footprint;
  for (const TagPlace& tag : layout.tags) smallest = std::min(smallest, tag.footprint);
  return smallest;
}
double LargestFootprint(const TagLayout& layout) {
  double largest = 0;
  for (const TagPlace& tag : layout.tags) largest = std::max(largest, tag.footprint);
  return largest;
}

Result<TagLayout> LayOutTags(const TentacleDesign& design, const Gripper& gripper,
                             const TagLayoutOptions& options) {
  if (auto s = CheckOptions(options); !s.ok()) return s.error();
  if (gripper.tentacles < 1) {
    return Bad(fmt::format("the gripper has {} tentacles; expected 1 or more", gripper.tentacles));
  }
  const auto family = FamilyOf(options.family);
  if (!family.ok()) return family.error();
  if (options.over_hole && family.value().void_width == 0) {
    return Bad(
        fmt::format("{} has no unused middle to lie over a hole; expected tagCustom48h12", options.family));
  }

  // Neighbours may be mirror images: at most two kinds of tentacle, by the number's parity.
  Rooms rooms;
  for (int kind = 0; kind < std::min(gripper.tentacles, 2); ++kind) {
    const auto layout = LayOut(DesignOfTentacle(gripper, design, kind));
    if (!layout.ok()) return layout.error();
    rooms.push_back(RoomsOf(design, layout.value(), options.clearance));
  }
  const Fitting fitting{.hole_diameter = design.hole_diameter,
                        .void_share = options.over_hole ? static_cast<double>(family.value().void_width) /
                                                              family.value().total_width
                                                        : 0.0};
  double common = options.footprint;
  if (!options.each && common > 0) {
    if (Status s = CheckRoom(rooms, fitting, options); !s.ok()) return s.error();
  } else if (!options.each) {
    const auto size = EqualSize(rooms, fitting, options);
    if (!size.ok()) return size.error();
    common = size.value();
  }
  const double bound = options.footprint > 0 ? options.footprint : std::numeric_limits<double>::infinity();

  TagLayout tags{.family = options.family, .tags = {}};
  int id = options.first_id;
  for (int tentacle = 0; tentacle < gripper.tentacles; ++tentacle) {
    const std::vector<FacetRoom>& own = rooms[static_cast<size_t>(tentacle % 2)];
    for (size_t i = 0; i < own.size(); i += static_cast<size_t>(options.every)) {
      const double footprint = options.each ? fitting.Largest(own[i], bound) : common;
      const bool fits = options.each ? footprint >= std::min(options.smallest_footprint, bound)
                                     : fitting.Fits(own[i], footprint);
      if (!fits || !(footprint > 0)) continue;
      const Eigen::Vector2d center = fitting.Place(own[i], footprint);
      const double border = footprint * family.value().border_width / family.value().total_width;
      for (const TagSide side : {TagSide::kOuter, TagSide::kInner}) {
        if (options.sides == (side == TagSide::kOuter ? TagSides::kInner : TagSides::kOuter)) continue;
        tags.tags.push_back({.id = id++,
                             .tentacle = tentacle,
                             .facet = static_cast<int>(i),
                             .side = side,
                             .footprint = footprint,
                             .over_hole = fitting.FitsOver(own[i], footprint),
                             .corners_in_sheet = CornersOf(center, border, side)});
      }
    }
  }
  if (tags.tags.empty()) {
    return Bad(
        fmt::format("no facet has room for a tag of {:.3g} mm clear of hole and creases; expected wider or "
                    "longer facets",
                    1e3 * options.smallest_footprint));
  }
  if (id > family.value().ids) {
    return Bad(fmt::format(
        "{} has {} ids, but {} tags from id {} on are needed; expected fewer tentacles, facets or sides, or "
        "a "
        "larger family ({})",
        options.family, family.value().ids, tags.tags.size(), options.first_id, FamiliesWith(id)));
  }
  return tags;
}

}  // namespace tendril
