#include "cli/score_trial.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "analysis/link/seen_from.h"
#include "cli/program_version.h"
#include "db/files/curve_files.h"
#include "db/files/safe_file.h"
#include "db/files/trial_toml.h"
#include "db/simulation_store.h"
#include "db/trial_store.h"

namespace tendril::cli {

Result<std::vector<CurveSeries>> CurvesAboutObject(const std::filesystem::path& folder,
                                                   const TrialSpec& trial) {
  Result<std::vector<CurveSeries>> curves = ReadCurves(folder / "curves.h5");
  if (!curves.ok()) return curves;
  const Result<ObjectsOverTime> objects = ReadObjectsOverTime(folder / "curves.h5");
  if (!objects.ok()) return objects.error();
  for (const ObjectSeries& object : objects.value().objects) {
    if (object.poses.empty() || object.poses.size() != curves.value().front().curves.size()) continue;
    // The trial's object is the one that begins where trial.toml has it.
    if ((object.poses.front().translation() - trial.object.position).norm() > 1e-9) continue;
    const bool moved = std::any_of(object.poses.begin(), object.poses.end(), [&](const auto& pose) {
      return pose.matrix() != object.poses.front().matrix();
    });
    if (!moved) break;
    return SeenFrom(object.poses, curves.value());
  }
  return curves;
}

std::optional<Axis> AxisOf(const TrialSpec& trial) {
  const std::string& kind = trial.object.kind;
  const bool simulated = trial.kind == TrialKind::kSimulated;
  if (kind == "sphere" || kind == "none" || (simulated && kind != "cylinder" && kind != "capsule")) {
    return std::nullopt;
  }
  return Axis{trial.object.position, trial.object.axis};
}

Result<LinkSeries> ScoreTrial(Lab& lab, const std::string& trial_id, LinkOptions options,
                              const Progress& progress) {
  const std::filesystem::path folder = lab.TrialFolder(trial_id);
  if (!std::filesystem::exists(folder / "curves.h5")) {
    return Error{ErrorKind::kNotFound,
                 "trial " + trial_id + " has no curves yet; make them with: tendril track " + trial_id};
  }
  const Result<TrialSpec> trial = ReadTrialToml(folder / "trial.toml");
  if (!trial.ok()) return trial.error();
  const Result<std::vector<CurveSeries>> curves = CurvesAboutObject(folder, trial.value());
  if (!curves.ok()) return curves.error();
  options.axis = AxisOf(trial.value());
  const Result<std::optional<StoredSimulation>> simulation = LoadSimulation(lab, trial_id);
  if (!simulation.ok()) return simulation.error();
  Result<LinkSeries> series = MeasureLinkSeries(curves.value(), options, progress);
  if (!series.ok()) return series;
  if (simulation.value() && simulation.value()->row.holding &&
      std::isfinite(simulation.value()->row.holding->begins_s)) {
    series.value().EndBy(simulation.value()->row.holding->begins_s);
  }

  Provenance made{.program_version = ProgramVersion()};
  nlohmann::json axis = nullptr;
  if (options.axis) {
    const Eigen::Vector3d& p = options.axis->point;
    const Eigen::Vector3d& d = options.axis->direction;
    axis = {p.x(), p.y(), p.z(), d.x(), d.y(), d.z()};
  }
  made.parameters_json = nlohmann::json{{"axis", axis}, {"closure", ClosureText(options.closure)}}.dump();
  for (const char* input : {"trial.toml", "curves.h5"}) {
    Result<std::string> hash = Sha256OfFile(folder / input);
    if (!hash.ok()) return hash.error();
    made.input_sha256.emplace_back(input, std::move(hash).value());
  }
  if (Status s = StoreLink(lab, trial_id, RowsOf(series.value()), made); !s.ok()) return s.error();
  return series;
}

}  // namespace tendril::cli
