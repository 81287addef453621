#pragma once
// A virtual trial as something to record: a hidden truth, cameras that render it, servos that log it.
//
// What is drawn from which ranges: docs/virtual_rig.md. The truth goes to truth.h5 (centerlines at the
// frames' times) and truth.toml in the trial's folder; nothing that tracks or fits reads them.

#include <cstdint>
#include <filesystem>
#include <vector>

#include "capture/record/record.h"
#include "capture/rig/virtual_render.h"
#include "capture/rig/virtual_truth.h"
#include "db/files/trial_toml.h"
#include "model/result.h"

namespace tendril {

struct VirtualTrialOptions {
  TrueFold fold;
  TruthRanges ranges;
  VirtualOptics optics;
  int frames = 12;              // evenly from the flat shape to the end; 1: the end alone
  double hold = 0.5;            // after the slowest tentacle has arrived, s
  double servo_rate = 20;       // servo log rows per second and servo
  double spool_radius = 0.015;  // m; position_deg = pull * flat tendon length / spool_radius, in degrees
  std::uint64_t seed = 1;
};

// Everything to record: `trial` says design, gripper, tags, rig (rig_toml), object, pull and rate. One servo
// per tentacle; its `command` is what that servo was told at that moment, start-up delay and rate included.
// The same trial and options give the same pictures and logs.
//   errors  kBadInput: the trial's or an option's; no cameras in the rig; kUnreachable: the pull
Result<RecordPlan> PlanVirtualTrial(TrialSpec trial, const VirtualTrialOptions& options);

// truth.toml: what a study may compare its fit and its outcomes with.
struct TruthFile {
  std::uint64_t seed = 0;
  TrueFold fold;
  VirtualCylinder object;
};
Result<TruthFile> ReadTruthFile(const std::filesystem::path& file);

}  // namespace tendril
