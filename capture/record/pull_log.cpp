#include "capture/record/pull_log.h"

#include <algorithm>
#include <cstddef>

#include "db/files/recording_logs.h"

namespace tendril {

Result<PullLog> PullLog::Read(const std::filesystem::path& trial_folder, const TrialSpec& trial) {
  PullLog log;
  log.ramp_pull_ = trial.pull;
  log.ramp_rate_ = trial.pull_rate;
  const std::filesystem::path file = trial_folder / "servo.csv";
  if (!std::filesystem::exists(file)) return log;
  const Result<std::vector<ServoRow>> rows = ReadServoLog(file);
  if (!rows.ok()) return rows.error();
  for (const ServoRow& row : rows.value()) {
    if (!row.command || row.servo < 0) continue;
    const auto servo = static_cast<std::size_t>(row.servo);
    if (servo >= log.servos_.size()) log.servos_.resize(servo + 1);
    log.servos_[servo].push_back({1e-9 * static_cast<double>(row.host_ns - trial.started_ns), *row.command});
  }
  for (std::vector<Knot>& knots : log.servos_) {
    std::stable_sort(knots.begin(), knots.end(),
                     [](const Knot& a, const Knot& b) { return a.time < b.time; });
  }
  return log;
}

double PullLog::At(int tentacle, double time) const {
  const std::size_t servo = servos_.size() == 1 ? 0 : static_cast<std::size_t>(tentacle);
  if (servo >= servos_.size() || servos_[servo].empty())
    return std::clamp(ramp_rate_ * time, 0.0, ramp_pull_);
  const std::vector<Knot>& knots = servos_[servo];
  const auto after = std::lower_bound(knots.begin(), knots.end(), time,
                                      [](const Knot& knot, double t) { return knot.time < t; });
  if (after == knots.begin()) return knots.front().pull;
  if (after == knots.end()) return knots.back().pull;
  const Knot& before = *(after - 1);
  return before.pull + (after->pull - before.pull) * (time - before.time) / (after->time - before.time);
}

}  // namespace tendril
