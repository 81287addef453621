#pragma once
// Which facets of a folded tentacle pass through each other: the rigid model does not forbid it, paper does.

#include <utility>
#include <vector>

#include "model/fold/design.h"
#include "model/fold/facet_chain.h"

namespace tendril {

// Pairs (i, j), i < j, ascending, of facets that are not neighbours and of which one's edge crosses the
// inside of the other. Facets that only touch, or lie flat on each other, are not counted.
// Facets are taken as convex; where creases cross in the flat sheet they are not, and pairs may be missed.
//   chain  FoldChain of the layout, in any frame
std::vector<std::pair<int, int>> OverlappingFacets(const TentacleLayout& layout, const FacetChain& chain);

}  // namespace tendril
