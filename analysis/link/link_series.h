#pragma once
// The link of all tentacles over all frames of a trial, its values at pull 0 and at the end, and the moments
// at which something passed through something.

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "analysis/link/link.h"
#include "db/trial_store.h"
#include "model/geometry/framed_curve.h"
#include "model/progress.h"
#include "model/result.h"

namespace tendril {

// Between two frames a value jumped by about 1. A ray that a body swept over is a matter of the closure; a
// body that passed another (or the axis) cannot happen in the world: there the curves are wrong, or the
// simulation.
struct LinkEvent {
  enum class Kind { kRayCrossed, kBodyPassed };
  Kind kind = Kind::kRayCrossed;
  int frame = 0;    // the later of the two
  double time = 0;  // its time, s
  int a = 0;
  int b = -1;       // -1: the object's axis
  double jump = 0;  // turns
};

struct LinkSeries {
  std::vector<std::string> names;  // of the curves
  Eigen::VectorXd time;            // s                (frames)
  std::vector<LinkReport> frames;  // one or more
  std::vector<LinkEvent> events;   // in order of time
  std::size_t end = 0;             // the frame that shows the finished grasp: the last, unless told otherwise

  // A trial begins with slack tendons: its first frame is the value at pull 0.
  const LinkReport& AtPullZero() const { return frames.front(); }
  const LinkReport& AtEnd() const { return frames[end]; }
  double EndTime() const { return time[static_cast<Eigen::Index>(end)]; }  // s
  // What comes after that time is a test of the grasp: the end is the last frame up to it, s.
  void EndBy(double last_time);
};

// Measures every frame. Nodes that an estimator bridged count like seen ones; a curve with a node that is not
// finite gives NaN with the flag kMissing in that frame, for its pairs and for the means.
//   errors  kBadInput  no curve, no frame, curves of unequal numbers of frames, or as MeasureLink
//           kStopped   progress said so
Result<LinkSeries> MeasureLinkSeries(std::span<const CurveSeries> curves, const LinkOptions& options,
                                     const Progress& progress = {});

// As the lab's store takes it.
LinkRows RowsOf(const LinkSeries& series);

}  // namespace tendril
