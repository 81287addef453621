#include "calibrate/fold/fold_data.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <set>

#include "capture/record/pull_log.h"
#include "db/files/curve_files.h"
#include "db/files/safe_file.h"
#include "model/fold/gripper.h"

namespace tendril {
namespace {

constexpr std::size_t kCovariances = 6;  // of a curve over time are kept at most: they are large

std::optional<int> TentacleOf(const std::string& name) {
  constexpr std::string_view kPrefix = "tentacle";
  if (!name.starts_with(kPrefix)) return std::nullopt;
  int number = 0;
  const char* const end = name.data() + name.size();
  const auto [stop, error] = std::from_chars(name.data() + kPrefix.size(), end, number);
  if (error != std::errc() || stop != end || number < 0) return std::nullopt;
  return number;
}

// Whether the command has fallen before a time, by more than a servo's resolution.
bool WentBackBefore(const CommandLog& log, double time) {
  double largest = 0;
  for (Eigen::Index i = 0; i < log.time.size() && log.time[i] <= time; ++i) {
    if (log.pull[i] < largest - 1e-3) return true;
    largest = std::max(largest, log.pull[i]);
  }
  return false;
}

}  // namespace

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
      o.released = WentBackBefore(log, o.time);
      o.curve = series.curves[frame];
      if (!series.sigma.empty()) o.sigma = series.sigma[frame];
      if (!series.interpolated.empty()) o.interpolated = series.interpolated[frame];
      // Evenly over time and with the last frame, which of a pull that rises is folded most.
      const std::size_t stride = (series.curves.size() + kCovariances - 1) / kCovariances;
      if (!series.covariance_factor.empty() && (series.curves.size() - 1 - frame) % stride == 0)
        o.covariance_factor = series.covariance_factor[frame];
      data.observations.push_back(std::move(o));
      data.frames.push_back(static_cast<int>(frame));
      data.angles.push_back(series.angle.empty() ? Eigen::VectorXd() : series.angle[frame]);
    }
  }
  return data;
}

}  // namespace tendril
