#include "capture/rig/virtual_tags.h"

#include <fmt/core.h>

#include <Eigen/LU>
#include <utility>

#include "capture/rig/tag_family.h"

namespace tendril {
namespace {

VirtualTag Print(const TagFamily& family, const TagPattern& pattern, const TagPlace& place) {
  VirtualTag tag;
  tag.modules = family.total_width;
  for (Eigen::Index row = 0; row < pattern.rows(); ++row) {
    for (Eigen::Index column = 0; column < pattern.cols(); ++column) {
      tag.white.push_back(pattern(row, column) > 127 ? 1 : 0);
    }
  }

  // The border's corners in the bitmap, in the detector's order, and in the sheet.
  const double low = 0.5 * (family.total_width - family.border_width);
  const double high = low + family.border_width;
  const Eigen::Vector2d bottom_left(low, high);
  const Eigen::Matrix<double, 3, 4>& c = place.corners_in_sheet;
  Eigen::Matrix2d sheet;  // columns: along the bitmap's rows, then its columns
  sheet.col(0) = (c.col(1) - c.col(0)).tail<2>() / family.border_width;
  sheet.col(1) = (c.col(0) - c.col(3)).tail<2>() / family.border_width;
  const Eigen::Matrix2d inverse = sheet.inverse();
  tag.modules_from_sheet.leftCols<2>() = inverse;
  tag.modules_from_sheet.col(2) = bottom_left - inverse * c.col(0).tail<2>();
  return tag;
}

}  // namespace

Result<VirtualTags> VirtualTags::Make(const TagLayout& layout) {
  const Result<TagFamily> family = FamilyOf(layout.family);
  if (!family.ok()) return family.error();
  VirtualTags tags;
  for (const TagPlace& place : layout.tags) {
    const Result<TagPattern> pattern = PatternOf(layout.family, place.id);
    if (!pattern.ok()) return pattern.error();
    const auto tentacle = static_cast<std::size_t>(place.tentacle);
    const auto facet = static_cast<std::size_t>(place.facet);
    if (tags.index_.size() <= tentacle) tags.index_.resize(tentacle + 1);
    if (tags.index_[tentacle].size() <= facet) tags.index_[tentacle].resize(facet + 1, {-1, -1});
    tags.index_[tentacle][facet][place.side == TagSide::kOuter ? 0 : 1] = static_cast<int>(tags.tags_.size());
    tags.tags_.push_back(Print(family.value(), pattern.value(), place));
  }
  return tags;
}

const VirtualTag* VirtualTags::Find(int tentacle, int facet, TagSide side) const {
  const auto t = static_cast<std::size_t>(tentacle);
  const auto f = static_cast<std::size_t>(facet);
  if (t >= index_.size() || f >= index_[t].size()) return nullptr;
  const int found = index_[t][f][side == TagSide::kOuter ? 0 : 1];
  return found < 0 ? nullptr : &tags_[static_cast<std::size_t>(found)];
}

}  // namespace tendril
