#pragma once
// Where a tag went when it is not where it was expected: too far for a fit to find its way
// (tag_photometric.h).

#include <Eigen/Core>
#include <optional>

#include "capture/track/tag_detect.h"
#include "capture/track/tag_look.h"

namespace tendril {

// The shift, of whole pixels and at most `reach` in x and y, under which the gray levels at the middles of
// the tag's modules go best with its pattern; none where they hardly do (a correlation below 0.5).
//   corners_px  where it was expected; it is taken to have moved without turning
std::optional<Eigen::Vector2d> SearchTag(const GrayImage& image, const TagLook& look,
                                         const Eigen::Matrix<double, 2, 4>& corners_px, int reach);

}  // namespace tendril
