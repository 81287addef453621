#pragma once
// What the cameras of a rig see of each tag while the gripper hangs straight: how many pixels a module has,
// how tilted it is, whether something stands before it, and what that is good for.
//
// SI units, radians, lab frame; pixels carry their unit. A module is one cell of a tag's pattern.

#include <string>
#include <vector>

#include "capture/rig/rig.h"
#include "capture/rig/tag_layout.h"
#include "model/fold/gripper.h"
#include "model/result.h"

namespace tendril {

enum class TagUse {
  kDecoded,     // its id is read in nearly every picture
  kTracked,     // read now and then, and can be followed in between
  kUnsure,      // too small or tilted to count on either
  kHidden,      // another tentacle stands before it
  kTurnedAway,  // its printed face is not toward the camera
  kOutside,     // not wholly in the picture
};

std::string NameOf(TagUse use);  // "decoded", "tracked", "unsure", "hidden", "turned away", "outside"

// Limits as docs/detection.md has them. module_px: px that a module would have if the tag were seen
// frontally; tilt: of its normal to the ray, rad. Decoding needs 2 px frontally, 3 at 45 degrees, in between
// in proportion, and beyond 45 degrees as much across as at 45. Following needs a footprint of 20 px, up to
// 60 degrees.
double DecodeLimitPx(double tilt);
TagUse UseOf(double module_px, int modules, double tilt);

// A tag before a camera.
struct TagOutlook {
  size_t tag = 0;  // in the layout
  size_t camera = 0;
  TagUse use = TagUse::kOutside;
  double tilt = 0;             // rad
  double module_px = 0;        // as if seen frontally
  double least_module_px = 0;  // along the direction in which the tilt shortens it most
  double m_per_px = 0;         // across the line of sight, there
};

// Of a tag whose facet stands somewhere, with nothing before it; `tag` and `camera` are left at 0.
//   modules  across the footprint (TagFamily::total_width)
TagOutlook LookAtTag(const Camera& camera, const TagPlace& tag, const Eigen::Isometry3d& lab_from_sheet,
                     int modules);

struct CameraSight {
  std::string name;
  double nearest_m_per_px = 0,
         farthest_m_per_px = 0;  // over all tags, seen or not; NaN: none before the camera
  double least_module_px = 0, largest_module_px = 0;  // of tags if they were seen frontally
  std::vector<int> count = std::vector<int>(6, 0);    // of tags, by TagUse
};

struct FacetSight {
  int tentacle = 0;
  int facet = 0;
  TagUse best = TagUse::kOutside;  // of its tags in all cameras
  double best_module_px = 0;       // least_module_px of that view
  int cameras = 0;                 // that decode or follow a tag of it
};

struct TagSight {
  std::vector<TagOutlook> views;  // tag by tag, camera by camera
  std::vector<CameraSight> cameras;
  std::vector<FacetSight> facets;  // that carry tags
  double widest_angle = 0;         // between two cameras' lines of sight to the gripper's middle, rad
};

// errors  kBadInput: the rig has no camera; the design's
Result<TagSight> SeeTags(const TentacleDesign& design, const Gripper& gripper, const TagLayout& tags,
                         const Rig& rig);

}  // namespace tendril
