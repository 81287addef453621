#pragma once
// What a lab's trials hold for the fold fit: tracked curves, each with the pull that its servo was commanded.

#include <Eigen/Core>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "calibrate/fold/fold_fit.h"
#include "db/files/recording_logs.h"
#include "db/files/trial_toml.h"
#include "model/result.h"

namespace tendril {

// One servo's command over time.
struct CommandLog {
  Eigen::VectorXd time;  // s since the trial began, ascending     (rows)
  Eigen::VectorXd pull;  // commanded, fraction                    (rows)
};

struct CommandState {
  double pull = 0;         // interpolated; NaN: before or more than half a second after the log
  double settled_for = 0;  // s that the command has stood still; infinity: since a log that began at rest
  double steady_for = 0;   // s that its rate has been the same (within 5 % and 1e-4 per s)
};

// The rows of one servo that carry a command. A log that begins with a command of 0 was at rest before.
CommandLog CommandsOf(std::span<const ServoRow> rows, int servo, std::int64_t started_ns);
CommandState StateAt(const CommandLog& log, double time);

struct FoldData {
  TrialSpec trial;
  std::vector<FoldObservation> observations;
  std::vector<std::pair<std::string, std::string>> input_sha256;  // (trial id/file, hash)
  std::vector<std::string> warnings;
};

// Reads trial.toml, curves.h5 (curves named tentacle0, tentacle1, ...) and servo.csv of a trial's folder.
// Tentacle i hangs on servo i; a log of a single servo pulls them all.
//   errors  kNotFound a missing file (says which command makes it); kBadInput what a file says wrongly
Result<FoldData> LoadFoldData(const std::filesystem::path& trial_folder);

}  // namespace tendril
