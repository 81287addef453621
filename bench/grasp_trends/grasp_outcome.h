#pragma once
// One trial of a grasp: run, judged, and kept as a row of a CSV file, so that runs that were interrupted go
// on.

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "bench/grasp_trends/grasp_points.h"
#include "model/result.h"

namespace tendril {

struct GraspOutcome {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::string scene, settings;  // the file's name; JoinedSettings
  std::string inputs;           // of InputsOf: rows of other inputs are not taken up again
  std::uint64_t trial = 0;
  bool above = false;       // anything above its start in the end, as JudgeHolding has it after a lift
  double rise = kNone;      // of the object, the least while it is watched after the lift, or by the pull, m
  double drawn_in = kNone;  // by the pull alone, before the lift, m
  double borne = kNone;     // by rods, the mean share of its weight at the end; NaN: it does not hang
  // At the end: with rays at both ends of a curve, and of the curves alone (docs/link.md), turns.
  double mutual_link = kNone, mutual_open = kNone, object_link = kNone, object_open = kNone;
  double wall = 0;         // s
  std::string doubt = {};  // why the run is not to be trusted; empty: it is
};

// What hangs is held where rods bear half of its weight or more and it is above its start; what floats, where
// it came along by half of the lift or more from where the pull had left it. What was missed but pushed aside
// may end above its start, too, and what floats and is held may be below.
bool Held(const GraspOutcome& outcome);

// Of what a point's runs are made from: the scene's text, the settings and the design.
Result<std::string> InputsOf(const std::filesystem::path& scenes, const GraspPoint& point);

// errors  as ReadScene, PlanScene and Simulate; a run that diverges is an outcome with a doubt
Result<GraspOutcome> RunGrasp(const std::filesystem::path& scenes, const GraspPoint& point,
                              const std::string& inputs, std::uint64_t trial);

// Rows of the file; none if there is no such file. A last line without its end, of a run that was killed
// while it wrote, is cut off the file.
Result<std::vector<GraspOutcome>> ReadOutcomes(const std::filesystem::path& file);

// Adds a row behind the others, and the header before the first.
Status AppendOutcome(const std::filesystem::path& file, const GraspOutcome& outcome);

}  // namespace tendril
