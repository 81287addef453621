#pragma once
// The crease pattern as a planar graph of vertices, edges and faces, for programs that fold paper. Pure
// functions.
//
// Drawn like a cut pattern (cut_pattern.h): X from the cut base end toward the tip, Y up across the ribbon,
// seen from the outer face.

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "model/fold/design.h"
#include "model/fold/facet_chain.h"
#include "model/result.h"

namespace tendril {

struct CreasePattern {
  struct Edge {
    int from = 0, to = 0;  // vertices
    int crease = -1;       // its number; -1: border of the sheet
  };

  double length = 0, width = 0;           // of the drawing, m
  Eigen::Matrix2Xd vertices;              // m                                                (2, 2 H + 2)
  std::vector<Edge> edges;                // creases by number, then the border               (H-1 + 2 H + 2)
  std::vector<std::array<int, 4>> faces;  // vertices of facet i, counter-clockwise                   (H)
};

// Whether a crease is a mountain seen from the outer face: creases 0, 2, 4, ... are (docs/physics.md,
// "Frames").
bool IsMountain(int crease);

// Why its creases do not part the sheet into facets: creases that cross or meet, that leave through a cut
// end. One sentence each, for the first crease of that trouble, with its place; empty if they do.
std::vector<std::string> WhyNoFacets(const TentacleDesign& design, const TentacleLayout& layout);

//   layout  LayOut(design)
//   errors  kBadInput  the first of WhyNoFacets
Result<CreasePattern> CreasePatternOf(const TentacleDesign& design, const TentacleLayout& layout);

// Where the pattern's vertices are when folded, in the tentacle's frame, m.                 (3, 2 H + 2)
Eigen::Matrix3Xd FoldedVertices(const TentacleLayout& layout, const FacetChain& chain);

}  // namespace tendril
