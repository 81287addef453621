// tendril plot curves, curvature, link, rates: figures for people.
#include "cli/plot_commands.h"

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/curvature_plot.h"
#include "cli/lab_option.h"
#include "cli/lab_plots.h"
#include "cli/left_out.h"
#include "db/files/curve_files.h"
#include "db/files/trial_toml.h"
#include "db/trial_query.h"

namespace tendril::cli {
namespace {

struct PlotCall {
  std::string curves;
  std::string servo;
  std::optional<int> servo_number;
  std::vector<int> nodes;
  std::string command_label = "commanded pull (fraction)";
  std::string lab;
  std::string trial;
  std::vector<std::string> by = {"design", "distance"};
  std::string kind = "real";
  std::string file;
  int frame = -1;
  bool include_untrusted = false;
};

void AddOut(CLI::App& app, PlotCall& call) {
  app.add_option("--out", call.file, "figure to write (.svg or .png)")->required();
}

Status Drawn(const Status& drawn, const PlotCall& call, Output& out) {
  if (!drawn.ok()) return drawn;
  out.fields()["figure"] = call.file;
  out.Print("{}", call.file);
  return Ok{};
}

Status RunCurves(const PlotCall& call, Output& out) {
  const Result<std::vector<CurveSeries>> curves = ReadCurves(call.curves);
  if (!curves.ok()) return curves.error();
  return Drawn(PlotCenterlines(curves.value(), nullptr, call.frame, std::filesystem::path(call.curves).stem(),
                               call.file),
               call, out);
}

Status RunCurvature(const PlotCall& call, Output& out) {
  const Result<std::vector<CurveSeries>> curves = ReadCurves(call.curves);
  if (!curves.ok()) return curves.error();
  // A trial's curves count time from its beginning, its servo log from 1970: trial.toml beside them says how
  // far apart.
  std::int64_t started_ns = 0;
  const std::filesystem::path trial = std::filesystem::path(call.curves).parent_path() / "trial.toml";
  if (!call.servo.empty() && std::filesystem::exists(trial)) {
    const Result<TrialSpec> spec = ReadTrialToml(trial);
    if (!spec.ok()) return spec.error();
    started_ns = spec.value().started_ns;
  }
  CurvaturePlotCall plot{.nodes = std::nullopt,
                         .servo_log = call.servo,
                         .started_ns = started_ns,
                         .servo = call.servo_number,
                         .command_label = call.command_label,
                         .file = call.file};
  if (!call.nodes.empty()) plot.nodes = {call.nodes.front(), call.nodes.back()};
  return Drawn(PlotCurvature(curves.value(), plot, out), call, out);
}

Status RunLinkPlot(const PlotCall& call, Output& out) {
  Result<Lab> lab = OpenLab(call.lab);
  if (!lab.ok()) return lab.error();
  const Result<std::string> id = FindTrial(lab.value(), call.trial);
  if (!id.ok()) return id.error();
  return Drawn(PlotLinks(lab.value().TrialFolder(id.value()), call.trial, call.file), call, out);
}

Status RunRates(const PlotCall& call, Output& out) {
  Result<Lab> lab = OpenLab(call.lab);
  if (!lab.ok()) return lab.error();
  RateQuestion question{.by = call.by,
                        .where = {},
                        .kind = *TrialKindOf(call.kind),
                        .include_untrusted = call.include_untrusted};
  if (const Status split = TellSplit(lab.value(), question, out); !split.ok()) return split;
  const Result<std::vector<RateGroup>> groups = CountGrasps(lab.value(), question);
  if (!groups.ok()) return groups.error();
  if (const auto left_out = TellLeftOut(lab.value(), question, out); !left_out.ok()) return left_out.error();
  if (groups.value().empty()) {
    return Error{ErrorKind::kNotFound, "no judged " + call.kind + " trial to plot; other kinds: --kind"};
  }
  const std::string& last = call.by.back();
  const bool length = last == "distance";
  return Drawn(
      PlotRates(groups.value(), length ? "carrier to object (mm)" : last, length ? 1e3 : 1, call.file), call,
      out);
}

}  // namespace

Command MakePlotCurvesCommand() {
  auto call = std::make_shared<PlotCall>();
  return {
      .path = "plot curves",
      .help = "centerlines of one frame, from the side (x, z) and from the front (y, z)",
      .example = "tendril plot curves curves.h5 --out curves.svg",
      .declare =
          [call](CLI::App& app) {
            app.add_option("curves", call->curves, "curves file (.csv or .h5; metres)")->required();
            app.add_option("--frame", call->frame, "frame number (from 0); -1: the last")
                ->capture_default_str();
            AddOut(app, *call);
          },
      .run = [call](Output& out) { return RunCurves(*call, out); },
  };
}

Command MakePlotCurvatureCommand() {
  auto call = std::make_shared<PlotCall>();
  return {
      .path = "plot curvature",
      .help =
          "net curvature of each curve over time and against the actuation, with bands and the width of the "
          "loop",
      .example = "tendril plot curvature curves.h5 --servo servo.csv --out curvature.svg",
      .declare =
          [call](CLI::App& app) {
            app.add_option("curves", call->curves, "curves file (.csv or .h5; metres)")->required();
            CLI::Option* const servo = app.add_option(
                "--servo", call->servo, "servo log (CSV) whose command is drawn beside and against it");
            app.add_option("--servo-number", call->servo_number,
                           "servo whose command acts (number); else servo c on curve c, or the only one")
                ->needs(servo);
            app.add_option("--nodes", call->nodes, "first,last node that counts (numbers from 0); else all")
                ->delimiter(',')
                ->expected(2);
            app.add_option("--command-label", call->command_label, "what the command is, with its unit")
                ->capture_default_str();
            AddOut(app, *call);
          },
      .run = [call](Output& out) { return RunCurvature(*call, out); },
  };
}

Command MakePlotLinkCommand() {
  auto call = std::make_shared<PlotCall>();
  return {
      .path = "plot link",
      .help = "a tracked trial's object link and self-link over time",
      .example = "tendril plot link coiling-50mm-1 --lab demo-lab --out link.svg",
      .declare =
          [call](CLI::App& app) {
            app.add_option("trial", call->trial, "trial: its label, id, or a unique beginning of its id")
                ->required();
            AddLabOption(app, call->lab);
            AddOut(app, *call);
          },
      .run = [call](Output& out) { return RunLinkPlot(*call, out); },
  };
}

Command MakePlotRatesCommand() {
  auto call = std::make_shared<PlotCall>();
  return {
      .path = "plot rates",
      .help = "success rates with 95 % Wilson intervals over the last key, one line per value of the others",
      .example = "tendril plot rates --lab demo-lab --by design,distance --kind virtual --out rates.svg",
      .declare =
          [call](CLI::App& app) {
            app.add_option("--by", call->by, "keys as `tendril stats` takes them; the last must be a number")
                ->delimiter(',')
                ->capture_default_str();
            app.add_option("--kind", call->kind, "kind of trial")
                ->check(CLI::IsMember({"real", "virtual", "simulated", "published"}))
                ->capture_default_str();
            app.add_flag("--include-untrusted", call->include_untrusted,
                         "also count simulations whose contacts speak against them");
            AddLabOption(app, call->lab);
            AddOut(app, *call);
          },
      .run = [call](Output& out) { return RunRates(*call, out); },
  };
}

}  // namespace tendril::cli
