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
  int raised = 0;                         // by kRaised or more by the pull: the paper's rule in air
  Interval interval;                      // of held / trusted
  double drawn_in = GraspOutcome::kNone;  // the median of those that held, m; NaN: none
  double Rate() const;                    // NaN: no trusted trial
};

// Whether an outcome is one of that scene and these settings.
bool IsOf(const GraspPoint& point, const GraspOutcome& outcome);

GraspCount CountGrasps(const GraspPoint& point, const std::vector<GraspOutcome>& outcomes);

// In Markdown, a row to each point that has a trial.
std::string GraspTable(const std::vector<GraspSeries>& series, const std::vector<GraspOutcome>& outcomes);

// Of all points in air, and of all under water, by design and whether the object was held, in Markdown: links
// (means and their standard errors), and how many rods are wound about the object or about each other.
std::string LinkTable(const std::vector<GraspSeries>& series, const std::vector<GraspOutcome>& outcomes);

// grasp_<series>.svg, and grasp_links.svg of the mutual against the object link, into the folder.
//   errors  as DrawFigure
Status DrawGrasps(const std::vector<GraspSeries>& series, const std::vector<GraspOutcome>& outcomes,
                  const std::filesystem::path& folder);

}  // namespace tendril
