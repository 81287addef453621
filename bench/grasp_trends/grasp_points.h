#pragma once
// What bench/grasp_trends.cpp runs: series of grasps that differ in one thing, beside what the paper says of
// each.

#include <limits>
#include <string>
#include <vector>

namespace tendril {

struct GraspPoint {
  std::string line;   // the line of the figure that it lies on
  std::string label;  // of x, for the table
  double x = 0;       // in the panel's unit
  std::string scene;  // a file of examples/scenes/grasp
  // As --set takes them; the same grasp has the same settings in every series, so that it is run once.
  std::vector<std::string> settings;
  bool tugged =
      false;  // after the pull, away from the carrier; without, the grasp is judged by the pull alone
  double paper = std::numeric_limits<double>::quiet_NaN();  // the paper's rate; NaN: its text gives no number
  std::string paper_says = {};                              // in its words, short; empty: nothing
};

struct GraspPanel {
  std::string title;
  std::string x_label;  // with the unit
  std::vector<GraspPoint> points;
};

struct GraspSeries {
  std::string name;  // of --series and of the figure
  int trials = 5;    // a point, unless --trials says otherwise
  std::vector<GraspPanel> panels;
};

// distance, pairs, water, sensitivity.
std::vector<GraspSeries> AllGraspSeries();

// The settings as one word of a CSV file: joined by blanks.
std::string JoinedSettings(const std::vector<std::string>& settings);

}  // namespace tendril
