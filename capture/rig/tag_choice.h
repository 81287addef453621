#pragma once
// Which tag family suits a gripper, and why; and what other choices of facets and sides would cost.
//
// A module is one cell of a tag's pattern. SI units; pixels carry their unit.

#include <optional>
#include <string>
#include <vector>

#include "capture/rig/rig.h"
#include "capture/rig/tag_family.h"
#include "capture/rig/tag_layout.h"
#include "model/result.h"

namespace tendril {

struct FamilyOption {
  TagFamily family;
  int tags = 0;           // that the layout needs; 0: no room
  double module = 0;      // of its smallest tag, m
  double false_tags = 0;  // share of random squares that would pass for one of its tags, as `detect` decodes
  bool enough_ids = false;
};

struct FamilyChoice {
  std::string family;
  std::string why;                    // one sentence
  std::vector<FamilyOption> options;  // square families, as TagFamilyNames orders them
};

// Of the square families with enough ids in which at most 1 random square in 1000 passes for a tag: the one
// with the largest modules; but one with a dark border, whose corners `track` fits (docs/detection.md),
// unless that makes its modules smaller by more than a quarter, or puts them below the decode limit where the
// other's are above.
//   m_per_px  of the best camera at its farthest tag, m; none: not known
//   errors    as LayOutTags; kBadInput: no family has enough ids
Result<FamilyChoice> ChooseFamily(const TentacleDesign& design, const Gripper& gripper,
                                  const TagLayoutOptions& options, std::optional<double> m_per_px = {});

// Square tags of a family's pattern, as `detect` accepts them: up to 2 wrong bits, 1 in families of over
// 10,000 ids.
double FalseTagShare(const TagFamily& family);

}  // namespace tendril
