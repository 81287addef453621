// tendril simulate: a scene's rods over time, with their links.
#include "cli/simulate_command.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "analysis/link/link_series.h"
#include "db/files/curve_files.h"
#include "db/files/scene_toml.h"
#include "model/scene/simulate.h"

namespace tendril::cli {
namespace {

struct SimulateCall {
  std::string scene;
  std::string level;
  std::string out;
  std::vector<double> at;
  double fps = 30;
  std::uint64_t trial = 0;
  bool plan = false;
  bool full = false;
};

void TellPlan(const Scene& scene, const SimulationPlan& plan, Output& out) {
  auto& fields = out.fields();
  fields["level"] = NameOf(scene.level);
  fields["time_step_s"] = plan.time_step;
  auto& terms = fields["terms"] = nlohmann::ordered_json::array();
  out.Print("level {}, steps of {:.3g} s: {}", NameOf(scene.level), plan.time_step, plan.step_why);
  for (const PlanTerm& term : plan.terms) {
    terms.push_back({{"name", term.name}, {"on", term.on}, {"why", term.why}});
    out.Print("  {:<3} {}: {}", term.on ? "on" : "off", term.name, term.why);
  }
}

// Frames at the rate, the end, and what was asked for besides.
std::vector<double> TimesOf(const SimulateCall& call, double duration) {
  std::vector<double> times = call.at;
  for (int i = 0; i / call.fps < duration * (1 - 1e-12); ++i) times.push_back(i / call.fps);
  times.push_back(duration);
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

Status TellLink(const Scene& scene, const std::vector<CurveSeries>& curves, Output& out) {
  LinkOptions options;
  if (!scene.objects.empty() && scene.objects[0].body.start != scene.objects[0].body.end) {
    const FixedBody& body = scene.objects[0].body;
    options.axis = Axis{body.start, body.end - body.start};
  }
  const Result<LinkSeries> links = MeasureLinkSeries(curves, options);
  if (!links.ok()) return links.error();
  const auto or_null = [](double value) {
    return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
  };
  auto& list = out.fields()["link"] = nlohmann::ordered_json::array();
  int passed = 0;
  for (const LinkEvent& event : links.value().events)
    passed += event.kind == LinkEvent::Kind::kBodyPassed ? 1 : 0;
  for (size_t f = 0; f < links.value().frames.size(); ++f) {
    const LinkReport& report = links.value().frames[f];
    list.push_back({{"time", links.value().time[static_cast<Eigen::Index>(f)]},
                    {"mutual_link", or_null(report.mutual_link)},
                    {"object_link", or_null(report.object_link)}});
  }
  out.fields()["bodies_passed"] = passed;
  const LinkReport& end = links.value().AtEnd();
  if (curves.size() > 1) out.Print("mutual link {:.4f} turns", end.mutual_link);
  if (options.axis) out.Print("object link {:.4f} turns", end.object_link);
  if (passed > 0) {
    out.Warn(fmt::format(
        "{} jumps of a link by a whole turn between frames: a body went through another, or through "
        "another's extension to infinity",
        passed));
  }
  return Ok{};
}

// Whether every step of the run shows that no body went through another; null: it was not looked at.
void TellPassages(const Simulated& done, Output& out) {
  auto& fields = out.fields();
  fields["nothing_passed"] = nullptr;
  if (!done.nothing_passed) return;
  const bool touched = std::isfinite(done.least_axis_distance);
  fields["nothing_passed"] = *done.nothing_passed;
  fields["least_axis_distance_m"] =
      touched ? nlohmann::ordered_json(done.least_axis_distance) : nlohmann::ordered_json(nullptr);
  fields["longest_move_m"] = done.longest_move;
  const char* const verdict =
      *done.nothing_passed ? "no body passed through another" : "a body may have passed through another";
  if (touched) {
    out.Print("contact: axes never nearer than {:.3g} mm ({:.2f} of the radii's sum)",
              1e3 * done.least_axis_distance, done.least_axis_share);
  }
  out.Print("nodes never moved farther than {:.3g} mm in a step: {}", 1e3 * done.longest_move, verdict);
  if (!*done.nothing_passed) {
    out.Warn(fmt::format("{}: the contact is too soft or the step too long", verdict));
  }
}

Status RunSimulate(const SimulateCall& call, Output& out) {
  Result<Scene> read = ReadScene(call.scene);
  if (!read.ok()) return read.error();
  Scene scene = std::move(read).value();
  if (!call.level.empty()) scene.level = LevelNamed(call.level);
  for (const double time : call.at) {
    if (time >= 0 && time <= scene.duration) continue;
    return Error{ErrorKind::kBadInput,
                 fmt::format("--at {}: expected 0 to the scene's duration, {} s", time, scene.duration)};
  }
  const Result<SimulationPlan> plan = PlanScene(scene, call.full);
  if (!plan.ok()) return Error(plan.error()).Within(call.scene);
  out.fields()["scene"] = scene.name;
  TellPlan(scene, plan.value(), out);
  if (call.plan) return Ok{};

  const auto begin = std::chrono::steady_clock::now();
  const Result<Simulated> run = Simulate(scene, plan.value(), TimesOf(call, scene.duration), call.trial,
                                         {.progress = out.ShowProgress(scene.name)});
  if (!run.ok()) return Error(run.error()).Within(call.scene);
  const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const Simulated& done = run.value();
  const double reached = done.curves[0].time.size() > 0 ? done.curves[0].time.tail<1>()[0] : 0;

  auto& fields = out.fields();
  fields["wall_s"] = wall;
  fields["steps"] = done.steps;
  fields["diverged"] = done.diverged.has_value();
  out.Print("{:.4g} s of {:.4g} in {:.3g} s: {:.3g} times real time, {} steps", reached, scene.duration, wall,
            reached / wall, done.steps);
  if (done.curves[0].time.size() > 0) {
    if (Status told = TellLink(scene, done.curves, out); !told.ok()) return told;
    TellPassages(done, out);
    if (!call.out.empty()) {
      if (Status written = WriteCurves(call.out, done.curves, "tendril simulate " TENDRIL_VERSION);
          !written.ok()) {
        return written;
      }
      fields["out"] = call.out;
      out.Print("{}: {} frames of {} rods", call.out, done.curves[0].time.size(), done.curves.size());
    }
  }
  if (done.diverged) {
    return Error{ErrorKind::kDiverged,
                 fmt::format("{}: the run diverged {}; try time_step = {}", call.scene,
                             done.diverged->Sentence(), ShortNumber(done.diverged->suggested_step))};
  }
  if (done.stopped) return Error{ErrorKind::kStopped, call.scene + ": stopped; what was simulated is kept"};
  return Ok{};
}

}  // namespace

Command MakeSimulateCommand() {
  auto call = std::make_shared<SimulateCall>();
  return {
      .path = "simulate",
      .help = "rods that bend, touch and entangle, as a scene file says",
      .example = "tendril simulate examples/scenes/helix.toml --out helix.csv",
      .declare =
          [call](CLI::App& app) {
            app.add_option("scene", call->scene, "scene file (TOML)")->required();
            app.add_option("--level", call->level, "instead of the scene's")
                ->check(CLI::IsMember({"paper", "standard", "fast", "static"}));
            app.add_option("--out", call->out,
                           "write the rods' curves over time (.csv or .h5; metres, seconds)");
            app.add_option("--at", call->at, "times to write besides the frames, s, separated by commas")
                ->delimiter(',');
            app.add_option("--fps", call->fps, "frames per simulated second")
                ->check(CLI::Range(1e-3, 1e6))
                ->capture_default_str();
            app.add_option("--trial", call->trial, "number of the trial, for the random draws")
                ->capture_default_str();
            app.add_flag("--plan", call->plan, "say what the scene requires, and do not run");
            app.add_flag("--full", call->full, "switch everything on, whatever the plan says");
          },
      .run = [call](Output& out) { return RunSimulate(*call, out); },
  };
}

}  // namespace tendril::cli
