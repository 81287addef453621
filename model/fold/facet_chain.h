#pragma once
// The folded tentacle as a chain of rigid facets joined at the creases, and the tendon's curve through its
// holes.
//
// The tentacle's frame: hole 0 at the origin; the first tendon segment keeps d3 = +z and d1 = +x at every
// pull (docs/physics.md, "Frames"). Crease 0 is a mountain seen from +x (the next facet turns by 2 phi toward
// -x), then valley, mountain, ...

#include <Eigen/Geometry>
#include <vector>

#include "model/fold/design.h"
#include "model/geometry/framed_curve.h"

namespace tendril {

// tentacle_from_sheet[i] moves facet i from where it lies in the flat sheet to where it is when folded.
struct FacetChain {
  std::vector<Eigen::Isometry3d> tentacle_from_sheet;  // (facets)
};

// angle: phi_i, rad (creases).
FacetChain FoldChain(const TentacleLayout& layout, const Eigen::Ref<const Eigen::VectorXd>& angle);

// One frame per tendon segment (hole i to hole i+1). Rows of Q are the directors d1, d2, d3.
struct TendonCurve {
  Eigen::Matrix3Xd holes;               // m, in the tentacle's frame                        (3, H)
  std::vector<Eigen::Matrix3d> frames;  // Q_i                                               (H-1)
  Eigen::VectorXd segment_length;       // l_i = |h_{i+1} - h_i|, m; may be 0 when closed    (H-1)
  Eigen::Matrix3Xd turning;             // -vee(log(Q_{i+1} Q_i^T)) at hole i+1, rad         (3, H-2)
};

TendonCurve TendonCurveOf(const TentacleLayout& layout, const FacetChain& chain,
                          const Eigen::Ref<const Eigen::VectorXd>& angle);

// The curve on which everything else agrees: nodes are the holes; a node's normal is the mean of its two
// segments' d1, made perpendicular to the mean of their d3.
FramedCurve NodesAtHoles(const TendonCurve& curve);

}  // namespace tendril
