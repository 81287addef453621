#pragma once
// A strip of folded shapes: facets of one tentacle at several pulls, side by side.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "analysis/study/plots.h"

namespace tendril::cli {

struct StripShape {
  std::string label;
  std::vector<Eigen::Matrix3Xd> facets;  // corners in the tentacle's frame, counter-clockwise seen from the
                                         // outer face, m; none: only the label
};

// A panel in millimetres, seen from the side, hanging: the base end is up. Outer faces are light, inner ones
// dark.
//   step, depth   room for each shape sideways, and for all of them downward, m
Panel StripPanel(const std::string& title, const std::vector<StripShape>& shapes, double step, double depth);

}  // namespace tendril::cli
