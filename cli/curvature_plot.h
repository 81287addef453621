#pragma once
// Curvature of curves over time and against their actuation, with bands and the loop between rising and
// falling actuation: measured, drawn, told.

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "analysis/statistics/hysteresis.h"
#include "cli/command.h"
#include "model/geometry/framed_curve.h"
#include "model/geometry/net_curvature.h"
#include "model/result.h"

namespace tendril::cli {

struct CurvaturePlotCall {
  std::optional<std::pair<int, int>> nodes;  // first and last that count; none: all
  std::filesystem::path servo_log;           // servo.csv, its times relative to started_ns; empty: none
  std::int64_t started_ns = 0;
  std::optional<int> servo;  // whose command acts; none: servo c pulls curve c, one servo alone pulls all
  std::string command_label;
  std::filesystem::path file;  // .svg or .png
};

// Net curvature of each curve over time (model/geometry/net_curvature.h) with its 95 % band where the curves
// state their covariance. With a servo log, also the command over time, curvature against it, rising and
// falling apart, and the width of each cycle's loop.
//   errors  kBadInput  nodes or a servo that there is not, a servo log without any command
Status PlotCurvature(const std::vector<CurveSeries>& curves, const CurvaturePlotCall& call, Output& out);

}  // namespace tendril::cli
