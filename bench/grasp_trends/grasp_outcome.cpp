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
#include "model/scene/simulate.h"

namespace tendril {
namespace {

namespace fs = std::filesystem;

const char* const kHeader =
    "scene,settings,inputs,trial,drawn_in_m,borne_share,gave_m,mutual_link,mutual_open,object_link,"
    "object_open,looping,braiding,wall_s,doubt";
constexpr double kFramesPerSecond = 10;
constexpr double kWatched = 1;  // the end of the pull, s

std::string NumberOrNothing(double value) { return std::isnan(value) ? "" : fmt::format("{:.9g}", value); }

// The axis of the first object in that frame.
std::optional<Axis> AxisIn(const Scene& scene, const Simulated& run, std::size_t frame) {
  const SceneObject& object = scene.objects.at(0);
  if (object.body.start == object.body.end) return std::nullopt;
  const Eigen::Isometry3d moved = run.objects.at(0).poses[frame] * object.pose.inverse();
  return Axis{moved * object.body.start, moved.linear() * (object.body.end - object.body.start)};
}

Status MeasureLinks(const Scene& scene, const Simulated& run, std::size_t frame, GraspOutcome& outcome) {
  std::vector<FramedCurve> curves;
  for (const CurveSeries& one : run.curves) curves.push_back(one.curves[frame]);
  LinkOptions options;
  options.axis = AxisIn(scene, run, frame);
  const Result<LinkReport> report = MeasureLink(curves, options);
  if (!report.ok()) return report.error();
  const LinkReport& links = report.value();
  outcome.mutual_link = links.mutual_link;
  outcome.object_link = links.object_link;
  outcome.mutual_open = outcome.object_open = 0;
  std::vector<bool> braids(curves.size());
  for (const PairLink& pair : links.pairs) {
    const double turns = std::abs(pair.gauss.value);
    outcome.mutual_open += turns / static_cast<double>(links.pairs.size());
    if (turns >= kWound) {
      braids[static_cast<std::size_t>(pair.a)] = braids[static_cast<std::size_t>(pair.b)] = true;
    }
  }
  for (const CurveLink& curve : links.curves) {
    const double turns = std::abs(curve.object_gauss.value);
    outcome.object_open += turns / static_cast<double>(links.curves.size());
    if (turns >= kWound) ++outcome.looping;
  }
  outcome.braiding = static_cast<int>(std::count(braids.begin(), braids.end(), true));
  return Ok{};
}

// What became of the object, and the last frame of the pull.
//   pulled  the end of the pull, s
std::size_t MeasureObject(const Scene& scene, double pulled, bool tugged, const Simulated& run,
                          GraspOutcome& outcome) {
  const SceneObject& object = scene.objects.at(0);
  const auto way = [&](std::size_t frame) {
    return (run.objects[0].poses[frame].translation() - object.pose.translation()).z();
  };
  const Eigen::Vector3d up = -scene.gravity.normalized();
  const Eigen::VectorXd& time = run.curves[0].time;
  constexpr double kSame = 1e-9;  // s
  std::size_t end = 0;
  double borne = 0, least_way = HUGE_VAL;
  int frames = 0;
  for (Eigen::Index f = 0; f < time.size(); ++f) {
    const auto frame = static_cast<std::size_t>(f);
    if (time[f] >= pulled - kSame) least_way = std::min(least_way, way(frame));
    if (time[f] > pulled + kSame) continue;
    end = frame;
    if (time[f] < pulled - kWatched - kSame) continue;
    borne += up.dot(run.objects[0].forces[frame]) / (object.mass * scene.gravity.norm());
    ++frames;
  }
  outcome.drawn_in = way(end);
  if (tugged) {
    outcome.gave = outcome.drawn_in - least_way;
  } else if (object.motion == ObjectMotion::kHanging) {
    outcome.borne = borne / frames;
  }
  return end;
}

// Away from the carrier, from the scene's end on.
void AddTug(Scene& scene) {
  const Eigen::Vector3d force(0, 0, -kTug);
  const double from = scene.duration, full = from + kTugTime / 2;
  scene.duration = from + kTugTime;
  scene.pushes.push_back({0, from, full, force, PushShape::kRamp});
  scene.pushes.push_back({0, full, scene.duration, force, PushShape::kSteady});
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
  if (!std::isnan(outcome.gave)) return outcome.gave < kGiven;
  return outcome.drawn_in > 0 && outcome.borne >= 0.5;
}

Result<std::string> InputsOf(const fs::path& scenes, const GraspPoint& point) {
  const Result<Scene> scene = SceneOf(scenes, point);
  if (!scene.ok()) return scene.error();
  const Result<std::string> text = ReadText(scenes / point.scene);
  if (!text.ok()) return text;
  return Sha256(text.value() + JoinedSettings(point.settings) + DesignToml(scene.value().gripper->design) +
                (point.tugged ? " tugged" : ""))
      .substr(0, 12);
}

Result<GraspOutcome> RunGrasp(const fs::path& scenes, const GraspPoint& point, const std::string& inputs,
                              std::uint64_t trial) {
  Result<Scene> read = SceneOf(scenes, point);
  if (!read.ok()) return read.error();
  Scene scene = std::move(read).value();
  const double pulled = scene.duration;
  if (point.tugged) AddTug(scene);
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
  const std::size_t end = MeasureObject(scene, pulled, point.tugged, done, outcome);
  if (Status s = MeasureLinks(scene, done, end, outcome); !s.ok()) return s.error();
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
                     .drawn_in = number(4),
                     .borne = number(5),
                     .gave = number(6),
                     .mutual_link = number(7),
                     .mutual_open = number(8),
                     .object_link = number(9),
                     .object_open = number(10),
                     .looping = static_cast<int>(csv.Integer(11, 0)),
                     .braiding = static_cast<int>(csv.Integer(12, 0)),
                     .wall = csv.Number(13, 0),
                     .doubt = std::string(csv.Text(14))};
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
  row += fmt::format("{},{},{},{}", outcome.scene, outcome.settings, outcome.inputs, outcome.trial);
  for (const double value : {outcome.drawn_in, outcome.borne, outcome.gave, outcome.mutual_link,
                             outcome.mutual_open, outcome.object_link, outcome.object_open}) {
    row += "," + NumberOrNothing(value);
  }
  row += fmt::format(",{},{},{}", outcome.looping, outcome.braiding, NumberOrNothing(outcome.wall));
  row += "," + doubt + "\n";
  std::ofstream out(file, std::ios::app | std::ios::binary);
  out << row << std::flush;
  if (!out) return Error{ErrorKind::kIo, file.string() + ": could not be written"};
  return Ok{};
}

}  // namespace tendril
