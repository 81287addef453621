#include "bench/grasp_trends/grasp_outcome.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>

#include "analysis/link/link.h"
#include "db/files/csv_read.h"
#include "db/files/design_toml.h"
#include "db/files/safe_file.h"
#include "db/files/scene_toml.h"
#include "model/scene/holding.h"
#include "model/scene/simulate.h"

namespace tendril {
namespace {

namespace fs = std::filesystem;

const char* const kHeader =
    "scene,settings,inputs,trial,above,rise_m,drawn_in_m,borne_share,mutual_link,mutual_open,object_link,"
    "object_open,wall_s,doubt";
constexpr double kFramesPerSecond = 10;
constexpr double kWatched = 1;  // without a lift: the end of the pull, s

std::string NumberOrNothing(double value) { return std::isnan(value) ? "" : fmt::format("{:.9g}", value); }

// The axis of the first object where it has come to.
std::optional<Axis> AxisAtEnd(const Scene& scene, const Simulated& run) {
  const SceneObject& object = scene.objects.at(0);
  if (object.body.start == object.body.end) return std::nullopt;
  const Eigen::Isometry3d moved = run.objects.at(0).poses.back() * object.pose.inverse();
  return Axis{moved * object.body.start, moved.linear() * (object.body.end - object.body.start)};
}

// Links of the last frame.
Status MeasureEnd(const Scene& scene, const Simulated& run, GraspOutcome& outcome) {
  std::vector<FramedCurve> curves;
  for (const CurveSeries& one : run.curves) curves.push_back(one.curves.back());
  LinkOptions options;
  options.axis = AxisAtEnd(scene, run);
  const Result<LinkReport> report = MeasureLink(curves, options);
  if (!report.ok()) return report.error();
  const LinkReport& links = report.value();
  outcome.mutual_link = links.mutual_link;
  outcome.object_link = links.object_link;
  outcome.mutual_open = outcome.object_open = 0;
  for (const PairLink& pair : links.pairs) {
    outcome.mutual_open += std::abs(pair.gauss.value) / static_cast<double>(links.pairs.size());
  }
  for (const CurveLink& curve : links.curves) {
    outcome.object_open += std::abs(curve.object_gauss.value) / static_cast<double>(links.curves.size());
  }
  return Ok{};
}

// How far the object rose by the end of the pull, and what share of its weight rods bear from then on.
//   pulled   the end of the pull, s
//   watched  from when its weight is looked at, s
void MeasureObject(const Scene& scene, double pulled, double watched, const Simulated& run,
                   GraspOutcome& outcome) {
  const SceneObject& object = scene.objects.at(0);
  const Eigen::Vector3d up = -scene.gravity.normalized();
  const Eigen::VectorXd& time = run.curves[0].time;
  double borne = 0;
  int frames = 0;
  for (Eigen::Index f = 0; f < time.size(); ++f) {
    const auto frame = static_cast<std::size_t>(f);
    if (time[f] <= pulled) {
      outcome.drawn_in = up.dot(run.objects[0].poses[frame].translation() - object.pose.translation());
    }
    if (time[f] < watched) continue;
    borne += up.dot(run.objects[0].forces[frame]) / (object.mass * scene.gravity.norm());
    ++frames;
  }
  if (object.motion == ObjectMotion::kHanging) outcome.borne = borne / frames;
}

Result<Scene> SceneOf(const fs::path& scenes, const GraspPoint& point) {
  Result<Scene> scene = ReadScene(scenes / point.scene, point.settings);
  if (!scene.ok()) return scene;
  if (!scene.value().gripper || scene.value().objects.empty()) {
    return Error{ErrorKind::kBadInput, point.scene + ": expected a [gripper] and an [[object]]"};
  }
  return scene;
}

}  // namespace

bool Held(const GraspOutcome& outcome) {
  if (!std::isnan(outcome.borne)) return outcome.above && outcome.borne >= 0.5;
  return outcome.rise - outcome.drawn_in >= 0.5 * HoldingOptions{}.height;
}

Result<std::string> InputsOf(const fs::path& scenes, const GraspPoint& point) {
  const Result<Scene> scene = SceneOf(scenes, point);
  if (!scene.ok()) return scene.error();
  const Result<std::string> text = ReadText(scenes / point.scene);
  if (!text.ok()) return text;
  return Sha256(text.value() + JoinedSettings(point.settings) + DesignToml(scene.value().gripper->design) +
                (point.lift ? "" : " no lift"))
      .substr(0, 12);
}

Result<GraspOutcome> RunGrasp(const fs::path& scenes, const GraspPoint& point, const std::string& inputs,
                              std::uint64_t trial) {
  Result<Scene> read = SceneOf(scenes, point);
  if (!read.ok()) return read.error();
  Scene scene = std::move(read).value();
  const HoldingOptions options;
  HoldingTimes times{.lift = scene.duration, .watch = scene.duration - kWatched};
  if (point.lift) {
    const Result<HoldingTimes> lift = AddHoldingTest(scene, HoldingTest::kLift, options);
    if (!lift.ok()) return lift.error();
    times = lift.value();
  }
  const Result<SimulationPlan> plan = PlanScene(scene);
  if (!plan.ok()) return plan.error();
  const int last = static_cast<int>(std::ceil(scene.duration * kFramesPerSecond - 1e-9));
  std::vector<double> frames;
  for (int f = 0; f <= last; ++f) frames.push_back(scene.duration * f / last);

  const auto begin = std::chrono::steady_clock::now();
  const Result<Simulated> run = Simulate(scene, plan.value(), frames, trial);
  if (!run.ok()) return run.error();
  const Simulated& done = run.value();
  GraspOutcome outcome{
      .scene = point.scene, .settings = JoinedSettings(point.settings), .inputs = inputs, .trial = trial};
  outcome.wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (done.diverged) {
    outcome.doubt = "diverged " + done.diverged->Sentence();
    return outcome;
  }
  outcome.doubt = fmt::format("{}", fmt::join(done.doubts, "; "));
  MeasureObject(scene, times.lift, times.watch, done, outcome);
  outcome.rise = outcome.drawn_in;
  outcome.above = outcome.rise > 0;
  if (point.lift) {
    constexpr double kNoMass = GraspOutcome::kNone;  // which only a test with a load asks for
    const Result<HoldingResult> judged =
        JudgeHolding(scene, HoldingTest::kLift, times, options, done, kNoMass);
    if (!judged.ok()) return judged.error();
    outcome.above = judged.value().held;
    outcome.rise = judged.value().rise;
  }
  if (Status s = MeasureEnd(scene, done, outcome); !s.ok()) return s.error();
  return outcome;
}

Result<std::vector<GraspOutcome>> ReadOutcomes(const fs::path& file) {
  std::vector<GraspOutcome> rows;
  if (!fs::exists(file)) return rows;
  const Result<std::string> text = ReadText(file);
  if (!text.ok()) return text.error();
  const std::size_t whole = text.value().rfind('\n') + 1;  // npos + 1 = 0: no line at all
  if (whole < text.value().size()) {
    if (Status s = WriteText(file, text.value().substr(0, whole)); !s.ok()) return s.error();
  }
  if (whole == 0) return rows;
  Result<CsvReader> opened = CsvReader::Open(file, {kHeader}, /*lines_end=*/true);
  if (!opened.ok()) return opened.error();
  CsvReader& csv = opened.value();
  const auto number = [&](std::size_t column) {
    return csv.NumberOrEmpty(column).value_or(GraspOutcome::kNone);
  };
  while (csv.Next()) {
    GraspOutcome row{.scene = std::string(csv.Text(0)),
                     .settings = std::string(csv.Text(1)),
                     .inputs = std::string(csv.Text(2)),
                     .trial = static_cast<std::uint64_t>(csv.Integer(3, 0)),
                     .above = csv.Integer(4, 0, 1) == 1,
                     .rise = number(5),
                     .drawn_in = number(6),
                     .borne = number(7),
                     .mutual_link = number(8),
                     .mutual_open = number(9),
                     .object_link = number(10),
                     .object_open = number(11),
                     .wall = csv.Number(12, 0),
                     .doubt = std::string(csv.Text(13))};
    if (csv.ok()) rows.push_back(std::move(row));
  }
  if (!csv.status().ok()) return csv.status().error();
  return rows;
}

Status AppendOutcome(const fs::path& file, const GraspOutcome& outcome) {
  const bool first = !fs::exists(file) || fs::file_size(file) == 0;
  std::string doubt = outcome.doubt;  // a field of ours has no quotes, so no commas
  std::replace_if(
      doubt.begin(), doubt.end(), [](char c) { return c == ',' || c == '\n'; }, ';');
  std::string row = first ? std::string(kHeader) + "\n" : std::string();
  row += fmt::format("{},{},{},{},{:d}", outcome.scene, outcome.settings, outcome.inputs, outcome.trial,
                     outcome.above);
  for (const double value : {outcome.rise, outcome.drawn_in, outcome.borne, outcome.mutual_link,
                             outcome.mutual_open, outcome.object_link, outcome.object_open, outcome.wall}) {
    row += "," + NumberOrNothing(value);
  }
  row += "," + doubt + "\n";
  std::ofstream out(file, std::ios::app | std::ios::binary);
  out << row << std::flush;
  if (!out) return Error{ErrorKind::kIo, file.string() + ": could not be written"};
  return Ok{};
}

}  // namespace tendril
