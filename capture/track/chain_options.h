#pragma once
// How firmly the chain's solver holds each piece of knowledge, and what follows for one view, one tag and one
// hole. docs/tracking.md, "What is unknown, and what holds it".
//
// SI units, rad, px. "Sheet" is the facet's own frame: x its normal, z along the tentacle.

#include "capture/track/chain_factors.h"

namespace tendril {

// 1-sigma values. What each stands for, and against what it was checked: docs/tracking.md.
struct ChainOptions {
  double sigma_corner_px = 0.12;  // a corner's coordinate where the view does not state its own
  double sigma_flatness_px =
      0.05;  // besides what a view states, which is of a flat tag: facets bend, paper curls
  double sigma_calibration_px =
      0.2;  // a camera's calibration: a smooth error of all of its views, per coordinate
  double sigma_tag_place = 0.10e-3;  // glue: a tag against its place, along the facet's y and z, m
  double sigma_tag_turn = 0.007;     // glue: likewise, turned about the facet's normal, rad
  double sigma_tag_lift = 0.03e-3;   // paper and bend: a tag's middle above or below its facet, m
  double sigma_tag_tilt = 0.004;     // paper: a tag out of its facet's plane, about y and z, rad
  double sigma_facet_bend = 0.012;   // bend: a tag out of its facet's plane about y, besides, rad
  double sigma_hole = 0.15e-3;       // a hole against its place, along the facet's y and z, m
  double sigma_hole_lift = 0.03e-3;  // likewise along its normal, m
  // Likewise of a facet that no tag shows: its bend lifts both of its ends alike, which sigma_gap has as two
  // errors that average out.
  double sigma_bridged_lift = 0.09e-3;
  double sigma_gap = 0.22e-3;  // bend, crease's place: a crease as its facets carry it, along their normal, m
  double sigma_gap_flat = 0.06e-3;    // likewise in the facet's plane, m
  double sigma_swing = 0.008;         // turning about other axes than the crease, rad
  double sigma_angle = 0.020;         // a crease's phi about what its neighbours suggest, rad
  double sigma_opening = 0.20;        // how far the whole tentacle opens or closes beyond the law, rad
  double sigma_opening_walk = 0.005;  // change of that from one crease to the next, rad
  // false: the law's angles hold nothing, so that curves may calibrate the law. Even and odd creases are each
  // about as far open as their neighbours, and that is all; the law only helps to find the start.
  bool fold_law = true;
  double sigma_free_opening = 1.0;  // without the law: phi of the first crease of either kind about 0, rad
  double sigma_free_walk = 0.05;    // likewise its change from one crease to the next, rad
  // What a crease out of sight was seen to do at another moment (capture/track/recall.h):
  double sigma_recall_walk = 0.01;   // how far it left what the law says of its change, rad per root of s
  double sigma_recall_change = 0.2;  // and of that change itself, share (without the law: 1)
  double sigma_base_place = 1.5e-3;  // hole 0 against its nominal place, each axis, m
  double sigma_base_turn = 0.03;     // its facet likewise, about other axes than the crease, rad
  double sigma_base_fold = 0.15;     // and about its crease, rad
  // Of a view about what all else predicts, per corner coordinate; beyond it the view is left out.
  double largest_chi_square = 6;
  // A hole is "not seen" (sigma NaN) if its facet was not and either holds:
  double farthest_seen = 0.15;   // m along the sheet to the nearest facet that was seen
  double largest_sigma = 0.020;  // m
  int covariance_rank = 36;      // columns of the covariance factor, about; 0: none
  int max_iterations = 60;
};

// For tentacles that touch things: contact bends and twists facets, and its folds leave the law, by far more
// than weight and stiffness do (docs/tracking.md, "Entangled"). The defaults above are for tentacles that
// hang free.
ChainOptions LoadedTentacles();

// Of a view's corners: what the view states, or the option's default where it states nothing (NaN).
CornerSigma SigmaOfView(double stated_px, const ChainOptions& options);

// How far a tag may be off its place on a facet with this orientation.
TagSlop SlopOfTag(const ChainOptions& options, const Eigen::Matrix3d& lab_from_sheet_rotation);

// Covariance of a hole against its place on such a facet, in the lab, m^2.
Eigen::Matrix3d HoleSlop(const ChainOptions& options, const Eigen::Matrix3d& lab_from_sheet_rotation,
                         bool facet_seen);

}  // namespace tendril
