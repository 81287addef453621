#pragma once
// Bitmaps of the tags of a layout, as the virtual rig prints them on its facets.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "capture/rig/tag_layout.h"
#include "model/result.h"

namespace tendril {

struct VirtualTag {
  int modules = 0;                  // along a side, with the white ring
  std::vector<std::uint8_t> white;  // 1: white; row by row from the top left          (modules * modules)
  // Position in the bitmap, in modules from the top left corner, of sheet point (y, z): column = m * (y, z,
  // 1)
  Eigen::Matrix<double, 2, 3> modules_from_sheet;
};

// Looked up by where a tag is glued.
class VirtualTags {
 public:
  //   errors  kBadInput: unknown family (lists those known), an id that it lacks
  static Result<VirtualTags> Make(const TagLayout& layout);

  const VirtualTag* Find(int tentacle, int facet, TagSide side) const;

 private:
  std::vector<VirtualTag> tags_;
  std::vector<std::vector<std::array<int, 2>>> index_;  // [tentacle][facet][side], -1: none
};

}  // namespace tendril
