#pragma once
// Where a tag's black border ends, to a few hundredths of a pixel: each of its four edges is fitted by a
// straight, blurred step in brightness over the pixels beside it, and the corners are where the lines meet.

#include <Eigen/Core>
#include <optional>

#include "capture/track/tag_detect.h"

namespace tendril {

struct TagRefineOptions {
  // Pixels farther from the edge than this are left out, modules: the code's bits begin one module inside,
  // the white ring ends one module outside, and both blur. (At 20 px, 0.8 inside drew the edges out by 0.06
  // px.)
  double band_inside = 0.5;
  double band_outside = 0.6;
  double largest_band_px = 4;     // or farther than this
  double corner_margin = 0.5;     // the edge's ends are left out: band_outside + this, modules
  double largest_shift_px = 1.5;  // an edge that moves farther was not this tag's
};

//   corners_px    as detected, in the detector's order
//   border_width  modules along an edge (TagFamily::border_width)
//   returns       the refined corners; none where an edge has too few pixels, leaves the picture or moves
//                 farther than largest_shift_px: then the detector's corners are the best there are
std::optional<Eigen::Matrix<double, 2, 4>> RefineTagCorners(const GrayImage& image,
                                                            const Eigen::Matrix<double, 2, 4>& corners_px,
                                                            int border_width,
                                                            const TagRefineOptions& options = {});

}  // namespace tendril
