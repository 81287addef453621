#include "capture/record/pull_log.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace tendril {
namespace {

constexpr double kLogEnd = 0.5;          // s that a log's last command is taken to hold
constexpr double kPullTolerance = 1e-9;  // below any servo's resolution

double RateBefore(const CommandLog& log, Eigen::Index row) {
  return (log.pull[row] - log.pull[row - 1]) / (log.time[row] - log.time[row - 1]);
}

// Rows at or before the time.
Eigen::Index RowsUntil(const CommandLog& log, double time) {
  const double* const begin = log.time.data();
  return std::upper_bound(begin, begin + log.time.size(), time) - begin;
}

}  // namespace

CommandLog CommandsOf(std::span<const ServoRow> rows, int servo, std::int64_t started_ns) {
  std::map<double, double> by_time;
  for (const ServoRow& row : rows) {
    if (row.servo == servo && row.command) {
      by_time[1e-9 * static_cast<double>(row.host_ns - started_ns)] = *row.command;
    }
  }
  CommandLog log;
  log.time.resize(static_cast<Eigen::Index>(by_time.size()));
  log.pull.resize(log.time.size());
  Eigen::Index i = 0;
  for (const auto& [time, pull] : by_time) {
    log.time[i] = time;
    log.pull[i++] = pull;
  }
  return log;
}

CommandState StateAt(const CommandLog& log, double time) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr double kAlways = std::numeric_limits<double>::infinity();
  const Eigen::Index rows = log.time.size();
  if (rows == 0 || !(time <= log.time[rows - 1] + kLogEnd)) return {kNaN, 0, 0};
  const bool rest_before = log.pull[0] == 0;
  if (time < log.time[0]) return rest_before ? CommandState{0, kAlways, kAlways} : CommandState{kNaN, 0, 0};

  const Eigen::Index next = RowsUntil(log, time);
  CommandState state;
  state.pull = log.pull[next - 1];
  double rate = 0;
  if (next < rows) {
    rate = RateBefore(log, next);
    state.pull += rate * (time - log.time[next - 1]);
  }
  const double before = rest_before ? kAlways : time - log.time[0];

  Eigen::Index row = next;  // the earliest row whose command is still this one
  while (row > 0 && std::abs(log.pull[row - 1] - state.pull) <= kPullTolerance) --row;
  state.settled_for = row == 0 ? before : row == next ? 0 : time - log.time[row];

  row = next - 1;  // the earliest row from which the rate is still this one
  while (row > 0 && std::abs(RateBefore(log, row) - rate) <= 0.05 * std::abs(rate) + 1e-4) --row;
  const bool at_rest = std::abs(rate) <= 1e-4;
  state.steady_for = row == 0 && at_rest ? before : time - log.time[row];
  return state;
}

Result<PullLog> PullLog::Read(const std::filesystem::path& trial_folder, const TrialSpec& trial) {
  PullLog log;
  log.ramp_pull_ = trial.pull;
  log.ramp_rate_ = trial.pull_rate;
  const std::filesystem::path file = trial_folder / "servo.csv";
  if (!std::filesystem::exists(file)) return log;
  const Result<std::vector<ServoRow>> rows = ReadServoLog(file);
  if (!rows.ok()) return rows.error();
  for (const ServoRow& row : rows.value()) {
    if (row.command) log.servos_.try_emplace(row.servo);
  }
  for (auto& [servo, commands] : log.servos_) commands = CommandsOf(rows.value(), servo, trial.started_ns);
  return log;
}

double PullLog::At(int tentacle, double time) const {
  const auto servo = servos_.size() == 1 ? servos_.begin() : servos_.find(tentacle);
  if (servo == servos_.end()) return std::clamp(ramp_rate_ * time, 0.0, ramp_pull_);
  const CommandLog& log = servo->second;
  const Eigen::Index next = RowsUntil(log, time);
  if (next == 0) return log.pull[0];
  if (next == log.time.size()) return log.pull[next - 1];
  return log.pull[next - 1] + RateBefore(log, next) * (time - log.time[next - 1]);
}

}  // namespace tendril
