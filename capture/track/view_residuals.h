#pragma once
// What each tag that was found says against the reconstructed chain: where its corners are in the picture,
// minus where the facet's pose puts them.

#include <cstdint>
#include <span>
#include <vector>

#include "capture/track/chain_solve.h"
#include "db/files/recording_logs.h"

namespace tendril {

// One row per view, in their order. A tag is taken to sit at its nominal place on its facet, so a residual
// holds the detector's error, how the tag was glued, what the camera's calibration is off, and the chain's
// own error: larger than ChainSolution::rms_reprojection_px, which lets the tag move.
//   solution  SolveChain's of these views
//   frame     of the rows
void AppendResiduals(std::span<const Camera> cameras, const TentacleLayout& layout,
                     std::span<const TagView> views, const ChainSolution& solution, std::int64_t frame,
                     std::vector<ResidualRow>& rows);

}  // namespace tendril
