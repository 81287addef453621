#pragma once
// Which AprilTag is glued where: tag id -> tentacle, facet, side, and its corners in the flat sheet.
//
// A tag's size is its printed footprint with the white ring; its corners (what the detector reports) are
// those of the black border inside that ring.

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "db/files/tag_toml.h"
#include "model/fold/design.h"
#include "model/fold/gripper.h"
#include "model/result.h"

namespace tendril {

enum class TagSide { kOuter, kInner };  // outer: the face whose normal is +x in the sheet's frame

struct TagPlace {
  int id = 0;
  int tentacle = 0;
  int facet = 0;
  TagSide side = TagSide::kOuter;
  double footprint = 0;    // printed side with the white ring, m
  bool over_hole = false;  // its middle lies over the tendon's hole, which is punched through it
  // Corners of the black border in the sheet's frame, in the detector's order (counter-clockwise in the image
  // of an upright tag, from the bottom left), m                                                  (3, 4)
  // The tag's top is toward the tip; seen from outside its right is +y, seen from inside -y.
  Eigen::Matrix<double, 3, 4> corners_in_sheet;
};

struct TagLayoutOptions {
  std::string family = "tag36h11";
  double footprint = 0;               // m; 0: the largest that fits every facet, at most largest_footprint
  double largest_footprint = 0.008;   // m; of tags that are all alike and beside their holes
  double smallest_footprint = 0.003;  // m; with footprint 0, facets that cannot hold this much carry no tag
  double clearance = 0.0003;          // kept free around holes, creases and edges, m
  int first_id = 0;
  bool each = false;  // each tag as large as its facet holds, at most `footprint` where that is not 0
  int every = 1;      // facets 0, every, 2 every, ... carry tags
  TagSides sides = TagSides::kBoth;
  // Where a tag can be so large that the family's unused middle is as wide as the hole, it lies over the hole
  // (tagCustom48h12: a hole of 2 mm needs 10 mm). The hole is punched through it.
  bool over_hole = false;
};

// What a trial says of its tags.
TagLayoutOptions LayoutOptionsOf(const TagSpec& spec);

struct TagLayout {
  std::string family;
  std::vector<TagPlace> tags;  // ascending id

  const TagPlace* Find(int id) const;
};
// Of a layout with a tag, m.
double SmallestFootprint(const TagLayout& layout);
double LargestFootprint(const TagLayout& layout);

// Tags on the facets and sides asked for, where one fits. Ids ascend over tentacle, facet, side (outer,
// inner).
//   errors  kBadInput: no room for a tag of the size asked for (names the facet and what would fit);
//           the family has too few ids for the gripper, or nothing unused in its middle
Result<TagLayout> LayOutTags(const TentacleDesign& design, const Gripper& gripper,
                             const TagLayoutOptions& options = {});

}  // namespace tendril
