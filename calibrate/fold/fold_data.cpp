#include "calibrate/fold/fold_data.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>

#include "db/files/curve_files.h"
#include "db/files/safe_file.h"
#include "model/fold/gripper.h"

namespace tendril {
namespace {

constexpr double kLogEnd = 0.5;          // s that a log's last command is taken to hold
constexpr double kPullTolerance = 1e-9;  // below any servo's resolution

std::optional<int> TentacleOf(const std::string& name) {
  constexpr std::string_view kPrefix = "tentacle";
  if (!name.starts_with(kPrefix)) return std::nullopt;
  int number = 0;
  const char* const end = name.data() + name.size();
  const auto [stop, error] = std::from_chars(name.data() + kPrefix.size(), end, number);
  if (error != std::errc() || stop != end || number < 0) return std::nullopt;
  return number;
}

double RateBefore(const CommandLog& log, Eigen::Index row) {
  return (log.pull[row] - log.pull[row - 1]) / (log.time[row] - log.time[row - 1]);
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

  const double* const begin = log.time.data();
  // Rows before `next` are at or before the time asked for.
  const Eigen::Index next = std::upper_bound(begin, begin + rows, time) - begin;
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

Result<FoldData> LoadFoldData(const std::filesystem::path& trial_folder) {
  FoldData data;
  Result<TrialSpec> trial = ReadTrialToml(trial_folder / "trial.toml");
  if (!trial.ok()) return trial.error();
  data.trial = std::move(trial).value();

  const auto missing = [&](const char* file, const char* advice) {
    return Error{ErrorKind::kNotFound, fmt::format("trial {}: no {}; {}", data.trial.label, file, advice)};
  };
  if (!std::filesystem::exists(trial_folder / "curves.h5")) {
    return missing("curves.h5", "run `tendril track` on it first");
  }
  if (!std::filesystem::exists(trial_folder / "servo.csv")) {
    return missing("servo.csv", "a fit needs the commanded pull, which the recorder logs there");
  }
  for (const char* const file : {"trial.toml", "curves.h5", "servo.csv"}) {
    Result<std::string> hash = Sha256OfFile(trial_folder / file);
    if (!hash.ok()) return hash.error();
    data.input_sha256.emplace_back(fmt::format("{}/{}", data.trial.id, file), std::move(hash).value());
  }
  const Result<std::vector<CurveSeries>> curves = ReadCurves(trial_folder / "curves.h5");
  if (!curves.ok()) return Error(curves.error()).Within("trial " + data.trial.label);
  const Result<std::vector<ServoRow>> rows = ReadServoLog(trial_folder / "servo.csv");
  if (!rows.ok()) return Error(rows.error()).Within("trial " + data.trial.label);
  std::set<int> servos;
  for (const ServoRow& row : rows.value()) {
    if (row.command) servos.insert(row.servo);
  }
  if (servos.empty())
    return missing("commanded pull in servo.csv", "expected numbers in its column `command`");

  for (const CurveSeries& series : curves.value()) {
    const std::optional<int> tentacle = TentacleOf(series.name);
    if (!tentacle || *tentacle >= data.trial.gripper.tentacles) {
      data.warnings.push_back(
          fmt::format("trial {}: curve `{}` is none of its {} tentacles (tentacle0, ...); left out",
                      data.trial.label, series.name, data.trial.gripper.tentacles));
      continue;
    }
    if (!servos.contains(*tentacle) && servos.size() > 1) {
      data.warnings.push_back(fmt::format("trial {}: no command logged for servo {}; tentacle left out",
                                          data.trial.label, *tentacle));
      continue;
    }
    const int servo = servos.contains(*tentacle) ? *tentacle : *servos.begin();
    const CommandLog log = CommandsOf(rows.value(), servo, data.trial.started_ns);
    const TentacleDesign design = DesignOfTentacle(data.trial.gripper, data.trial.design, *tentacle);
    for (std::size_t frame = 0; frame < series.curves.size(); ++frame) {
      FoldObservation o;
      o.trial = data.trial.id;
      o.tentacle = *tentacle;
      o.design = design;
      o.time = series.time[static_cast<Eigen::Index>(frame)];
      const CommandState state = StateAt(log, o.time);
      o.commanded_pull = state.pull;
      o.settled_for = state.settled_for;
      o.steady_for = state.steady_for;
      o.curve = series.curves[frame];
      if (!series.sigma.empty()) o.sigma = series.sigma[frame];
      if (!series.interpolated.empty()) o.interpolated = series.interpolated[frame];
      data.observations.push_back(std::move(o));
    }
  }
  return data;
}

}  // namespace tendril
