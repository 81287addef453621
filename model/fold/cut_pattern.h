#pragma once
// What a plotter cuts for one tentacle: outline, perforated creases, holes. Geometry only; the files are
// db/files/drawing_files.h.
//
// SI units. The drawing shows the outer face (+x of the sheet): X from the cut base end toward the tip, Y up
// across the ribbon, all coordinates >= 0: X = z - base_z, Y = half the wider end - y.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "model/fold/design.h"
#include "model/result.h"

namespace tendril {

struct PerforationOptions {
  double dash = 1.0e-3;  // cut, m
  double gap = 1.0e-3;   // left standing, m; at least half of it stays at either edge
};

struct CutDash {
  Eigen::Vector2d from;
  Eigen::Vector2d to;
};

struct CutCrease {
  bool mountain = true;         // seen from the outer face
  std::vector<CutDash> dashes;  // along the crease, from its lower edge (Y) to its upper
};

struct CutPattern {
  double length = 0;         // of the drawing, m
  double width = 0;          // m
  Eigen::Matrix2Xd outline;  // corners, counter-clockwise, m                        (2, 4)
  std::vector<CutCrease> creases;
  Eigen::Matrix2Xd holes;    // centres, m                                           (2, H)
  double hole_diameter = 0;  // m
};

// Why the design cannot be cut, one sentence each, with the crease or hole and its place from the base end in
// mm; empty if it can. Every kind of trouble is told once, where it is first met.
//   creases that cross or meet, that leave through a cut end; holes wider than the ribbon, cut by a crease or
//   by an end
std::vector<std::string> WhyNotCut(const TentacleDesign& design, const TentacleLayout& layout);

//   errors  kBadInput  design out of range; cannot be cut (the first of WhyNotCut); dash or gap <= 0; a
//   crease
//           shorter than a gap
Result<CutPattern> CutPatternOf(const TentacleDesign& design, const PerforationOptions& options = {});

}  // namespace tendril
