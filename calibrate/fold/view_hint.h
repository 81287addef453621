#pragma once
// Would another view sharpen a parameter, and by how much? Internal to calibrate/fold.

#include <optional>

#include "calibrate/fold/fit_run.h"

namespace tendril {

// The clustered variance of a parameter is split in two:
//
//   pictures   sum over nodes of sigma^2 |q|^2, q how the estimate follows the node's place: errors that
//              are new in each frame. Their size is measured where frames repeat (a tentacle held at one pull
//              looks the same in each, but for them); else it follows from the covariances that frames state;
//              else the sigmas are taken at their word.
//   tentacles  the rest. It falls as that of creases whose stiffness is a little off, alike in all frames of
//              a trial, would: more creases seen are more to average over.
//
// With a place's further views, a node has the median sigma of nodes that as many cameras saw; the
// information, q and the creases' share are computed anew. None: one trial, or windows in place of distances.
//   parameter  index among what all frames share; not held
std::optional<ViewHint> ViewHintOf(const FitRun& run, const FoldFitOptions& options, int parameter);

}  // namespace tendril
