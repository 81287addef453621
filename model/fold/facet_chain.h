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

// angle: phi_i, rad (creases). A law's or any others in [-pi/2, pi/2]; negative turns the other way.
// The second form reuses what `chain` holds: in a loop it allocates nothing.
FacetChain FoldChain(const TentacleLayout& layout, const Eigen::Ref<const Eigen::VectorXd>& angle);
void FoldChain(const TentacleLayout& layout, const Eigen::Ref<const Eigen::VectorXd>& angle,
               FacetChain& chain);

// One frame per tendon segment (hole i to hole i+1). Rows of Q are the directors d1, d2, d3.
struct TendonCurve {
  Eigen::Matrix3Xd holes;               // m, in the tentacle's frame                        (3, H)
  std::vector<Eigen::Matrix3d> frames;  // Q_i                                               (H-1)
  Eigen::VectorXd segment_length;       // l_i = |h_{i+1} - h_i|, m; may be 0 when closed    (H-1)
  Eigen::Matrix3Xd turning;             // -vee(log(Q_{i+1} Q_i^T)) at hole i+1, rad         (3, H-2)
};

// chain: FoldChain(layout, angle). Frames, lengths and turning come from the angles in closed form, not from
// differences of holes, so they keep their digits flat and closed. Creases need not lie midway (a layout may
// be measured or perturbed): d1 is then the mean normal made perpendicular to the chord. The second form
// reuses what `curve` holds.
TendonCurve TendonCurveOf(const TentacleLayout& layout, const FacetChain& chain,
                          const Eigen::Ref<const Eigen::VectorXd>& angle);
void TendonCurveOf(const TentacleLayout& layout, const FacetChain& chain,
                   const Eigen::Ref<const Eigen::VectorXd>& angle, TendonCurve& curve);

// The curve on which everything else agrees: nodes are the holes; a node's normal is the mean of its two
// segments' d1, made perpendicular to the mean of their d3.
FramedCurve NodesAtHoles(const TendonCurve& curve);

// The pull that the rigid shape really has: the share by which the holes drew together, 1 - sum l_i / L. Law
// `paper` counts 2 d cos(phi) per crease, the truth is 2 d sqrt(1 - sin^2(a) sin^2(phi)); they differ where
// creases are oblique. Absolute error about 1e-15.
double KinematicPull(const TentacleLayout& layout, const TendonCurve& curve);

}  // namespace tendril
