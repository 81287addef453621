#include "cli/curvature_plot.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "analysis/study/plots.h"
#include "db/files/recording_logs.h"
#include "model/median.h"

namespace tendril::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();
constexpr double k95 = 1.959963984540054;

// Commands of each servo over time, s since the trial began.
using Commands = std::map<int, PlotSeries>;

Result<Commands> ReadCommands(const CurvaturePlotCall& call) {
  Commands commands;
  if (call.servo_log.empty()) return commands;
  const Result<std::vector<ServoRow>> rows = ReadServoLog(call.servo_log);
  if (!rows.ok()) return rows.error();
  for (const ServoRow& row : rows.value()) {
    if (!row.command) continue;
    PlotSeries& series = commands[row.servo];
    series.x.push_back(1e-9 * static_cast<double>(row.host_ns - call.started_ns));
    series.y.push_back(*row.command);
  }
  if (commands.empty()) {
    return Error{ErrorKind::kBadInput, call.servo_log.string() + ": no row has a command to plot against"};
  }
  if (call.servo && !commands.contains(*call.servo)) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("--servo-number {}: {} has commands of servos {} to {}", *call.servo,
                             call.servo_log.string(), commands.begin()->first, commands.rbegin()->first)};
  }
  return commands;
}

// The last command before a frame is the one that acts.
Eigen::VectorXd CommandAt(const PlotSeries& command, const Eigen::VectorXd& time) {
  Eigen::VectorXd acting = Eigen::VectorXd::Constant(time.size(), kNotKnown);
  for (Eigen::Index f = 0; f < time.size(); ++f) {
    const auto after = std::upper_bound(command.x.begin(), command.x.end(), time[f]);
    if (after != command.x.begin()) {
      acting[f] = command.y[static_cast<std::size_t>(after - command.x.begin()) - 1];
    }
  }
  return acting;
}

std::vector<double> Numbers(const Eigen::VectorXd& values) { return {values.begin(), values.end()}; }

void AddBand(PlotSeries& series, const Eigen::VectorXd& value, const Eigen::VectorXd& sigma) {
  // Where no sigma is stated the band is as thin as its line; none at all where it never is.
  if (sigma.size() == 0 || sigma.array().isNaN().all()) return;
  const Eigen::VectorXd half = k95 * sigma.array().isNaN().select(0, sigma);
  series.low = Numbers(value - half);
  series.high = Numbers(value + half);
}

PlotSeries Line(const std::string& name, const Eigen::VectorXd& x, const Eigen::VectorXd& y,
                const Eigen::VectorXd& sigma, int color) {
  PlotSeries series;
  series.name = name;
  series.x = Numbers(x);
  series.y = Numbers(y);
  series.color = color;
  AddBand(series, y, sigma);
  return series;
}

// Rows of the strokes that go one way, with bars; a gap after each stroke.
PlotSeries Strokes(const std::string& name, const Hysteresis& loop, bool rising,
                   const Eigen::VectorXd& command, const NetCurvature& bend, int color) {
  Eigen::VectorXd y = Eigen::VectorXd::Constant(command.size(), kNotKnown);
  for (const DriveStroke& stroke : loop.strokes) {
    if (stroke.rises != rising) continue;
    const Eigen::Index rows = stroke.last - stroke.first + 1;
    y.segment(stroke.first, rows) = bend.value.segment(stroke.first, rows);
  }
  PlotSeries series = Line(name, command, y, bend.sigma, color);
  series.style = PlotSeries::Style::kLineAndPoints;
  return series;
}

double KnownMedian(const Eigen::VectorXd& values) {
  std::vector<double> known;
  std::copy_if(values.begin(), values.end(), std::back_inserter(known), [](double v) { return v == v; });
  return Median(std::move(known));
}

void TellCurvature(const std::string& name, const NetCurvature& bend, Json& json, Output& out) {
  const Eigen::Index known = bend.value.array().isFinite().count();
  double low = kNotKnown;
  double high = kNotKnown;
  for (const double v : bend.value) {
    low = std::fmin(low, v);  // the other one of a NaN
    high = std::fmax(high, v);
  }
  const double sigma = KnownMedian(bend.sigma);
  const double scatter = RowScatter(bend.value);
  json["frames"] = bend.value.size();
  json["frames_known"] = known;
  json["curvature_per_m"] = {NumberOrNull(low), NumberOrNull(high)};
  json["median_sigma_per_m"] = NumberOrNull(sigma);
  json["row_scatter_per_m"] = NumberOrNull(scatter);
  if (known == 0) {
    out.Print("{}: no net curvature: in no frame are all of its nodes known (--nodes takes a part of them)",
              name);
    return;
  }
  out.Print("{}: net curvature {:.3f} to {:.3f} 1/m in {} of {} frames", name, low, high, known,
            bend.value.size());
  if (std::isnan(sigma)) {
    out.Print("  no sigma: the curves state no covariance");
  } else {
    out.Print(
        "  sigma {:.3f} 1/m (median, from the nodes' covariance); from row to row it scatters by {:.3f} 1/m",
        sigma, scatter);
  }
}

void TellLoop(const Hysteresis& loop, const Eigen::VectorXd& command, Json& json, Output& out) {
  Json& answer = json["hysteresis"];
  answer["strokes"] = loop.strokes.size();
  answer["levels"] = loop.level.size();
  answer["width_per_m"] = NumberOrNull(loop.width);
  answer["standard_error_per_m"] = NumberOrNull(loop.standard_error);
  answer["half_95_per_m"] = NumberOrNull(loop.half_95);
  answer["measurement_sigma_per_m"] = NumberOrNull(loop.sigma);
  answer["cycles"] = Json::array();
  for (const HysteresisCycle& cycle : loop.cycles) {
    answer["cycles"].push_back({{"first_frame", cycle.first},
                                {"last_frame", cycle.last},
                                {"levels", cycle.levels},
                                {"width_per_m", cycle.width},
                                {"measurement_sigma_per_m", NumberOrNull(cycle.sigma)}});
  }
  if (command.array().isNaN().all()) {
    out.Print("  no loop: no command comes before a frame");
    return;
  }
  if (loop.cycles.empty()) {
    out.Print("  no loop: in {} strokes no actuation is reached both rising and falling",
              loop.strokes.size());
    return;
  }
  int levels = 0;
  for (const HysteresisCycle& cycle : loop.cycles) levels += cycle.levels;
  const std::string how_sure =
      loop.cycles.size() < 2
          ? "one cycle, which does not tell how much cycles differ"
          : fmt::format("standard error {:.3f} from {} cycles, 95 %: {:.3f} to {:.3f}", loop.standard_error,
                        loop.cycles.size(), loop.width - loop.half_95, loop.width + loop.half_95);
  out.Print("  loop: at equal actuation rising less falling is {:+.3f} 1/m ({})", loop.width, how_sure);
  out.Print(
      "  compared at {} levels of {}{}", levels,
      loop.level.size() * static_cast<Eigen::Index>(loop.cycles.size()),
      std::isfinite(loop.sigma) ? fmt::format("; measurement alone: sigma {:.3f} 1/m", loop.sigma) : "");
  if (levels < 3 * static_cast<int>(loop.cycles.size())) {
    out.Warn(
        "the loop is compared at few levels, as the command jumps past the others: its width is that of "
        "those levels alone");
  }
}

Status CheckNodes(const std::vector<CurveSeries>& curves, const CurvaturePlotCall& call) {
  if (!call.nodes) return Ok{};
  const auto [first, last] = *call.nodes;
  for (const CurveSeries& curve : curves) {
    const Eigen::Index nodes = curve.curves.empty() ? 0 : curve.curves.front().points.cols();
    if (first < 0 || last < first + 2 || last >= nodes) {
      return Error{ErrorKind::kBadInput,
                   fmt::format("--nodes {},{}: curve '{}' has nodes 0 .. {}; expected first,last of three "
                               "or more of them",
                               first, last, curve.name, nodes - 1)};
    }
  }
  return Ok{};
}

}  // namespace

Status PlotCurvature(const std::vector<CurveSeries>& curves, const CurvaturePlotCall& call, Output& out) {
  if (Status good = CheckNodes(curves, call); !good.ok()) return good;
  const Result<Commands> commands = ReadCommands(call);
  if (!commands.ok()) return commands.error();
  Panel over_time;
  over_time.title = "Curvature over time, 95 % band";
  over_time.x_label = "time (s)";
  over_time.y_label = "net curvature (1/m)";
  Panel against = over_time;
  against.title = "Curvature against actuation, 95 % bars";
  against.x_label = call.command_label;
  Panel widths = against;
  widths.title = "Rising less falling at equal actuation, 95 % bars";
  widths.y_label = "difference of net curvature (1/m)";
  double low = kNotKnown;
  double high = kNotKnown;
  Json answers = Json::array();
  bool any_sigma = false;
  for (std::size_t c = 0; c < curves.size(); ++c) {
    const CurveSeries& curve = curves[c];
    const auto nodes = call.nodes.value_or(std::pair{0, -1});
    const NetCurvature bend = NetCurvatureOf(curve, nodes.first, nodes.second);
    const int color = static_cast<int>(c % 6);
    over_time.series.push_back(Line(curve.name, curve.time, bend.value, bend.sigma, color));
    any_sigma = any_sigma || bend.sigma.array().isFinite().any();
    Json answer;
    answer["name"] = curve.name;
    TellCurvature(curve.name, bend, answer, out);
    if (!commands.value().empty()) {
      const int servo = call.servo.value_or(static_cast<int>(c));
      auto own = commands.value().find(servo);
      if (own == commands.value().end() && commands.value().size() == 1) own = commands.value().begin();
      if (own == commands.value().end()) {
        out.Warn(fmt::format("{}: no servo {} in {}; name its servo with --servo-number", curve.name, servo,
                             call.servo_log.string()));
        answers.push_back(std::move(answer));
        continue;
      }
      answer["servo"] = own->first;
      const PlotSeries& command = own->second;
      const Eigen::VectorXd acting = CommandAt(command, curve.time);
      const Hysteresis loop = MeasureHysteresis(acting, bend.value, bend.sigma);
      TellLoop(loop, acting, answer, out);
      for (const double v : acting) {
        low = std::fmin(low, v);
        high = std::fmax(high, v);
      }
      const std::string whose = curves.size() > 1 ? curve.name + ", " : "";
      const int up_color = static_cast<int>(2 * c % 6);
      against.series.push_back(Strokes(whose + "rising", loop, true, acting, bend, up_color));
      against.series.push_back(Strokes(whose + "falling", loop, false, acting, bend, up_color + 1));
      for (std::size_t k = 0; k < loop.cycles.size(); ++k) {
        const HysteresisCycle& cycle = loop.cycles[k];
        PlotSeries between = Line("", loop.level, cycle.rising, {}, 6);
        between.low = Numbers(cycle.rising.cwiseMin(cycle.falling));
        between.high = Numbers(cycle.rising.cwiseMax(cycle.falling));
        against.series.push_back(std::move(between));
        PlotSeries width = Line(whose + fmt::format("cycle {}: {:+.2f} 1/m", k + 1, cycle.width), loop.level,
                                cycle.rising - cycle.falling, cycle.difference_sigma, -1);
        width.style = PlotSeries::Style::kLineAndPoints;
        widths.series.push_back(std::move(width));
      }
    }
    answers.push_back(std::move(answer));
  }
  out.fields()["curves"] = std::move(answers);
  if (!any_sigma) {
    for (Panel* panel : {&over_time, &against, &widths}) panel->title.erase(panel->title.find(", 95 %"));
  }
  Figure figure;
  figure.panels = {std::move(over_time)};
  if (!commands.value().empty()) {
    Panel command;
    command.title = "Actuation over time";
    command.x_label = "time (s)";
    command.y_label = call.command_label;
    for (const auto& [servo, series] : commands.value()) {
      command.series.push_back(series);
      command.series.back().name = fmt::format("servo {}", servo);
    }
    figure.columns = 2;
    if (high > low) {
      against.x_range = widths.x_range = {{low - 0.05 * (high - low), high + 0.05 * (high - low)}};
    }
    figure.panels.push_back(std::move(command));
    figure.panels.push_back(std::move(against));
    if (!widths.series.empty()) figure.panels.push_back(std::move(widths));
  }
  return DrawFigure(figure, call.file);
}

}  // namespace tendril::cli
