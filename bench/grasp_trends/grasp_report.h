#pragma once
// What outcomes of grasps say: success rates with Wilson's 95 % intervals, as a table and as figures.

#include <filesystem>
#include <string>
#include <vector>

#include "analysis/statistics/intervals.h"
#include "bench/grasp_trends/grasp_outcome.h"
#include "bench/grasp_trends/grasp_points.h"
#include "model/result.h"

namespace tendril {

inline constexpr double kRaised = 0.005;  // m

// A point's trials. Doubtful ones are counted and take no part in anything else.
struct GraspCount {
  int trusted = 0, doubtful = 0, held = 0;
  // By kRaised or more by the pull alone: the paper's rule, which also takes what was pushed aside on its
  // string.
  int raised = 0;
  Interval interval;  // of held / trusted
  // Medians, m; NaN: of none. drawn_in: of those that held, by the pull alone.
  double rise_held = GraspOutcome::kNone, rise_lost = GraspOutcome::kNone, drawn_in = GraspOutcome::kNone;
  double Rate() const;  // NaN: no trusted trial
};

// Outcomes of the point's scene and settings.
GraspCount CountGrasps(const GraspPoint& point, const std::vector<GraspOutcome>& outcomes);

// In Markdown, a row to each point that has a trial.
std::string GraspTable(const std::vector<GraspSeries>& series, const std::vector<GraspOutcome>& outcomes);

// Links of the series about distance, by design, medium and whether the object was held, in Markdown: means
// and their standard errors.
std::string LinkTable(const std::vector<GraspSeries>& series, const std::vector<GraspOutcome>& outcomes);

// grasp_<series>.svg, and grasp_links.svg of the mutual against the object link, into the folder.
//   errors  as DrawFigure
Status DrawGrasps(const std::vector<GraspSeries>& series, const std::vector<GraspOutcome>& outcomes,
                  const std::filesystem::path& folder);

}  // namespace tendril
