#pragma once
// What pull was each tentacle's servo told at a time? From the trial's servo log; where there is none, from
// the ramp that trial.toml states.

#include <filesystem>
#include <vector>

#include "db/files/trial_toml.h"
#include "model/result.h"

namespace tendril {

class PullLog {
 public:
  // servo.csv of the trial's folder, if it is there. A servo whose log has no command follows the ramp.
  //   errors  as ReadServoLog
  static Result<PullLog> Read(const std::filesystem::path& trial_folder, const TrialSpec& trial);

  // Fraction of the flat tendon length. time: s since the trial began. Between two rows linear, beyond them
  // as at the nearest. One servo alone pulls all tentacles; else servo i pulls tentacle i.
  double At(int tentacle, double time) const;

 private:
  struct Knot {
    double time = 0;  // s
    double pull = 0;
  };

  double ramp_pull_ = 0;
  double ramp_rate_ = 0;
  std::vector<std::vector<Knot>> servos_;
};

}  // namespace tendril
