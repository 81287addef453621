#pragma once
// Which facets would a camera see of tentacles that are folded? As rig/tag_views.h asks of straight ones: a
// facet counts as seen where one of its tags is decoded or followed, and nothing stands before that tag.
//
// SI units, lab frame.

#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "capture/rig/camera_model.h"
#include "capture/rig/tag_layout.h"
#include "model/fold/design.h"
#include "model/geometry/framed_curve.h"

namespace tendril {

struct FoldedTentacle {
  TentacleDesign design;  // its own: mirrored where the gripper mirrors it
  TentacleLayout layout;
  std::vector<Eigen::Isometry3d> lab_from_sheet;  // of each facet; none: not known where it is     (facets)
};

// Lays the chain with these fold angles on the curve's nodes, as a whole; nodes that are NaN do not count.
// Facets lie where the estimate has them but for twist and bend of single facets, which it leaves out.
//   angle  phi_i, rad                                                            (creases)
// No lab_from_sheet if fewer than 4 nodes are known, or an angle is not.
FoldedTentacle LayOnCurve(const TentacleDesign& design, const TentacleLayout& layout,
                          const Eigen::VectorXd& angle, const FramedCurve& curve);

// 1: the camera sees the facet                                       (tentacles) x (facets)
//   modules  across a tag's footprint (TagFamily::total_width)
// A tag is hidden if a facet, of its own or another tentacle, stands before its middle or before two of its
// printed corners or more.
std::vector<Eigen::VectorXi> FacetsSeen(std::span<const FoldedTentacle> tentacles, const TagLayout& tags,
                                        int modules, const Camera& camera);

}  // namespace tendril
