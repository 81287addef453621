#pragma once
// What `link --bands` says: how sure each link is.

#include <string>
#include <vector>

#include "analysis/link/link_bands.h"
#include "cli/command.h"
#include "model/geometry/framed_curve.h"

namespace tendril::cli {

// "+0.412 [+0.391, +0.430]" (mean, 95 %), or where strands may have passed each other "+0.41 (72 %) or -0.58
// (28 %)".
std::string BandText(const LinkBand& band);

// "tentacle0 at node 3.5 and the axis are 1.2 mm apart, known to 0.9 mm (1 sigma)".
std::string UndecidedText(const UndecidedCrossing& crossing, const std::vector<std::string>& names);

// Bands of one frame; adds `bands` to the answer's fields and prints a table.
//   source  the curves' file or trial, for messages
//   errors  kBadInput: the curves state no covariance; as MeasureLinkBands
Status AnswerWithBands(const std::vector<CurveSeries>& curves, std::size_t frame, const LinkOptions& options,
                       int draws, const std::string& source, Output& out);

}  // namespace tendril::cli
