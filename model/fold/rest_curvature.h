#pragma once
// The rest curvature of an equivalent rod: the turning of the tendon's curve at its holes, smoothed and laid
// on the rod's nodes.

#include <Eigen/Core>

#include "model/fold/design.h"
#include "model/fold/facet_chain.h"

namespace tendril {

enum class CurvatureMap {
  kTurning,   // by the tendon's normalised arc length, scaled so that the total turning is kept
  kMaterial,  // each hole's turning at its place on the flat sheet
  kUnscaled,  // by normalised arc length, the tendon's curvature as it is: turns too far as the pull grows
};

struct RestCurvatureOptions {
  int elements = 100;
  double smoothing = 2;  // standard deviation of the Gaussian, in holes; 0: none
  CurvatureMap map = CurvatureMap::kTurning;
  // Half an element at the base bends too (EndHold::kFrame); else its turning is the first node's.
  bool bends_at_base = false;
};

// A rod as long as the sheet's cut length, its elements equally long; beyond the first and last hole
// straight.
struct RestCurvature {
  Eigen::Matrix3Xd curvature;  // d1, d2, d3 components at the inner nodes, 1/m           (3, elements - 1)
  double element_length = 0;   // m; curvature * element_length is a node's turning, rad
  Eigen::Vector3d base =
      Eigen::Vector3d::Zero();  // of the half element at the base, 1/m; 0 where it is stiff
};

// Smooths a sequence over its index with a Gaussian of the given standard deviation (in entries); the ends
// are mirrored, so each row keeps its sum.
Eigen::Matrix3Xd SmoothedTurning(const Eigen::Ref<const Eigen::Matrix3Xd>& turning, double deviation);

// Turning is moved, never made or lost: under kTurning and kMaterial the turnings of nodes and base sum
// to the holes'.
// A hole's turning is spread over its cell of the curve (half of either segment); a tendon drawn to length 0
// has no arc length and is laid on by kMaterial.
//   options  elements >= 2, smoothing >= 0 (TENDRIL_CHECK)
//   source   paper, Methods, "Cosserat rod modeling"; docs/physics.md, "From fold to rod"
RestCurvature RestCurvatureOf(const TentacleLayout& layout, const TendonCurve& curve,
                              const RestCurvatureOptions& options = {});

}  // namespace tendril
