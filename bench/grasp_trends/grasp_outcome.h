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
  double drawn_in = kNone;  // by the pull, toward the carrier's side: along z, m. In air that is up
  double borne = kNone;     // by rods, the mean share of its weight at the pull's end; NaN: not asked
  double gave = kNone;      // to a tug away from the carrier, the most, m; NaN: not asked
  // At the end of the pull: with rays at both ends of a curve, and of the curves alone (docs/link.md), turns.
  double mutual_link = kNone, mutual_open = kNone, object_link = kNone, object_open = kNone;
  // Rods of which the curve alone is wound about the object, or about another rod: by kWound or more.
  int looping = 0, braiding = 0;
  double wall = 0;         // s
  std::string doubt = {};  // why the run is not to be trusted; empty: it is
};

inline constexpr double kWound = 0.75;  // turns: half a turn is a straight curve that passes by

// A tug comes after the pull, grows to kTug (the tube's weight in air, N) in half of kTugTime (s), and stays
// as long.
inline constexpr double kTug = 0.147, kTugTime = 4;
inline constexpr double kGiven = 0.075;  // m

// Judged by the pull alone: rods bear half of its weight or more and it is above its start (what was pushed
// aside on its string may end above it, too). After a tug: it gave by less than kGiven; what is free goes
// several times as far.
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
