#include "model/fold/cut_pattern.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "model/fold/crease_pattern.h"
#include "model/fold/millimetres.h"

namespace tendril {
namespace {

// Crease i's ends on the edges y < 0 and y > 0, in the sheet's frame: the corners that facets i and i+1
// share.
Eigen::Vector3d LowerEnd(const TentacleLayout& layout, Eigen::Index i) { return layout.facets[i].col(3); }
Eigen::Vector3d UpperEnd(const TentacleLayout& layout, Eigen::Index i) { return layout.facets[i].col(2); }

}  // namespace

std::vector<std::string> WhyNotCut(const TentacleDesign& design, const TentacleLayout& layout) {
  const Eigen::Index creases = layout.crease_z.size();
  const double radius = 0.5 * design.hole_diameter;
  const auto from_base = [&](double z) { return Millimetres(z - layout.base_z) + " from the base end"; };
  std::optional<std::string> wide, hit, beyond;

  for (Eigen::Index i = 0; i <= creases; ++i) {
    const std::string hole = "hole " + std::to_string(i);
    const double z = layout.hole_z[i];
    const double narrowest =
        std::min(WidthAt(design, layout, z - radius), WidthAt(design, layout, z + radius));
    if (!wide && design.hole_diameter >= narrowest) {
      wide = hole + ", " + from_base(z) + ", is " + Millimetres(design.hole_diameter) +
             " wide where the ribbon is " + Millimetres(narrowest) + ": take a smaller hole_diameter";
    }
    if (!beyond && (z - radius <= layout.base_z || z + radius >= layout.tip_z)) {
      beyond = hole + ", " + from_base(z) + ", reaches over the cut end: take a longer sheet";
    }
    for (const Eigen::Index j : {i - 1, i}) {
      if (hit || j < 0 || j >= creases) continue;
      const double distance = std::abs(layout.crease_z[j] - z) * std::sin(layout.crease_angle[j]);
      if (distance > radius) continue;
      hit = hole + ", " + from_base(z) + ", meets crease " + std::to_string(j) + ", which is " +
            Millimetres(distance) + " from its centre: take a smaller hole_diameter or a larger spacing";
    }
  }

  std::vector<std::string> reasons = WhyNoFacets(design, layout);
  for (auto* reason : {&wide, &hit, &beyond}) {
    if (*reason) reasons.push_back(**reason);
  }
  return reasons;
}

Result<CutPattern> CutPatternOf(const TentacleDesign& design, const PerforationOptions& options) {
  const auto bad = [](const std::string& message) { return Error{ErrorKind::kBadInput, message}; };
  if (!(options.dash > 0 && options.gap > 0 && std::isfinite(options.dash) && std::isfinite(options.gap))) {
    return bad("dash = " + Millimetres(options.dash) + ", gap = " + Millimetres(options.gap) +
               ": expected both above 0 mm");
  }
  const Result<TentacleLayout> laid_out = LayOut(design);
  if (!laid_out.ok()) return laid_out.error();
  const TentacleLayout& layout = laid_out.value();
  if (const auto reasons = WhyNotCut(design, layout); !reasons.empty()) {
    return bad("cannot be cut: " + reasons.front());
  }

  CutPattern pattern;
  pattern.length = layout.tip_z - layout.base_z;
  pattern.width = design.base_width * std::max(1.0, design.taper);
  pattern.hole_diameter = design.hole_diameter;
  const auto drawn = [&](const Eigen::Vector3d& in_sheet) {
    return Eigen::Vector2d(in_sheet.z() - layout.base_z, 0.5 * pattern.width - in_sheet.y());
  };

  const Eigen::Matrix3Xd& base = layout.facets.front();
  const Eigen::Matrix3Xd& tip = layout.facets.back();
  pattern.outline.resize(2, 4);
  pattern.outline << drawn(base.col(1)), drawn(tip.col(2)), drawn(tip.col(3)), drawn(base.col(0));

  pattern.holes.resize(2, layout.hole_z.size());
  for (Eigen::Index i = 0; i < layout.hole_z.size(); ++i) {
    pattern.holes.col(i) = drawn({0, 0, layout.hole_z[i]});
  }

  for (Eigen::Index i = 0; i < layout.crease_z.size(); ++i) {
    const Eigen::Vector2d from = drawn(UpperEnd(layout, i));  // y > 0 is drawn below
    const Eigen::Vector2d to = drawn(LowerEnd(layout, i));
    const double length = (to - from).norm();
    if (length <= options.gap) {
      return bad("crease " + std::to_string(i) + " is " + Millimetres(length) +
                 " long: expected more than the gap, " + Millimetres(options.gap));
    }
    // Whole dashes, centred, so that what stays at either edge is half a gap or more; a crease too short for
    // a whole one gets a shorter one.
    const int count = std::max(1, static_cast<int>(std::floor(length / (options.dash + options.gap) + 1e-9)));
    const double dash = std::min(options.dash, length - options.gap);
    const double step = dash + options.gap;
    const double margin = 0.5 * (length - count * dash - (count - 1) * options.gap);
    const Eigen::Vector2d along = (to - from) / length;
    CutCrease crease;
    crease.mountain = IsMountain(static_cast<int>(i));
    for (int k = 0; k < count; ++k) {
      const double begin = margin + k * step;
      crease.dashes.push_back({from + begin * along, from + (begin + dash) * along});
    }
    pattern.creases.push_back(std::move(crease));
  }
  return pattern;
}

}  // namespace tendril
