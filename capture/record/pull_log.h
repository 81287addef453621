#pragma once
// What pull was each tentacle's servo told at a time, and since when? From the trial's servo log; where there
// is none, from the ramp that trial.toml states.

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>

#include "db/files/recording_logs.h"
#include "db/files/trial_toml.h"
#include "model/result.h"

namespace tendril {

// One servo's command over time.
struct CommandLog {
  Eigen::VectorXd time;  // s since the trial began, ascending     (rows)
  Eigen::VectorXd pull;  // commanded, fraction                    (rows)
};

// The rows of one servo that carry a command; of rows at the same time the last.
CommandLog CommandsOf(std::span<const ServoRow> rows, int servo, std::int64_t started_ns);

struct CommandState {
  double pull = 0;         // interpolated; NaN: before or more than half a second after the log
  double settled_for = 0;  // s that the command has stood still; infinity: since a log that began at rest
  double steady_for = 0;   // s that its rate has been the same (within 5 % and 1e-4 per s)
};

// A log that begins with a command of 0 was at rest before.
CommandState StateAt(const CommandLog& log, double time);

class PullLog {
 public:
  // servo.csv of the trial's folder, if it is there. Without a command there, a tentacle follows the ramp.
  //   errors  as ReadServoLog
  static Result<PullLog> Read(const std::filesystem::path& trial_folder, const TrialSpec& trial);

  // Fraction of the flat tendon length. time: s since the trial began. Between two rows linear, beyond them
  // as at the nearest. One servo alone pulls all tentacles; else servo i pulls tentacle i.
  double At(int tentacle, double time) const;

 private:
  double ramp_pull_ = 0;
  double ramp_rate_ = 0;
  std::map<int, CommandLog> servos_;  // those with a command
};

}  // namespace tendril
