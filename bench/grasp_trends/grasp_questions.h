#pragma once
// What the trials answer: the trends that the paper reports, each with the chance that luck alone would have
// made it look as strong.

#include <string>
#include <vector>

#include "bench/grasp_trends/grasp_outcome.h"
#include "bench/grasp_trends/grasp_points.h"

namespace tendril {

inline constexpr double kToldApart = 0.05;

struct GraspAnswer {
  std::string question;
  std::string seen;  // held of trials, group by group
  double p = 1;      // of NoTrendP or SameRateP (analysis/statistics/rates_differ.h), two-sided
};

// Those of the given series, where every group has a trusted trial: whether grasps get fewer with distance,
// whether more pairs hold more often, whether the designs differ at the same distances, whether the media do
// (water at distances of 13.3 to 53.3 %, each against air 6.7 % nearer), and whether what a sensitivity
// varies matters. Of the 23 at 5 % one is told apart by luck.
std::vector<GraspAnswer> AnswersOf(const std::vector<GraspSeries>& series,
                                   const std::vector<GraspOutcome>& outcomes);

// In Markdown; told apart where p < kToldApart.
std::string AnswerTable(const std::vector<GraspAnswer>& answers);

// Of the trusted trials of the series about distance in air and in water, by design, in Markdown: held of
// those in which rods were wound about the object, about each other, both or neither (kWound); and in how
// many pairs of a trial that held and one that did not the links of the curves alone are larger in the first
// (CompareRanks).
std::string WindingTable(const std::vector<GraspSeries>& series, const std::vector<GraspOutcome>& outcomes);

}  // namespace tendril
