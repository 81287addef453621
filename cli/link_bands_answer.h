#pragma once
// What `link --bands` says: how sure each link is.

#include <string>
#include <vector>

#include "analysis/link/link_bands.h"
#include "cli/command.h"
#include "model/geometry/framed_curve.h"

namespace tendril::cli {

// Bands of one frame; adds `bands` to the answer's fields and prints a table.
//   source  the curves' file or trial, for messages
//   errors  kBadInput: the curves state no covariance; as MeasureLinkBands
Status AnswerWithBands(const std::vector<CurveSeries>& curves, std::size_t frame, const LinkOptions& options,
                       int draws, const std::string& source, Output& out);

}  // namespace tendril::cli
