#include "cli/demo_plots.h"

#include <fmt/core.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <utility>

#include "analysis/link/link_series.h"
#include "analysis/statistics/intervals.h"
#include "analysis/study/plots.h"
#include "db/files/curve_files.h"
#include "db/files/trial_toml.h"

namespace tendril::cli {
namespace {

namespace fs = std::filesystem;

// Coordinates of one axis of a curve, mm.
std::vector<double> Millimetres(const Eigen::Matrix3Xd& points, int axis) {
  std::vector<double> values;
  for (Eigen::Index i = 0; i < points.cols(); ++i) values.push_back(1e3 * points(axis, i));
  return values;
}

Panel Projection(const std::vector<CurveSeries>& tracked, const std::vector<CurveSeries>& truth, int across,
                 int up, const std::string& title) {
  constexpr const char* kAxes[] = {"x (mm)", "y (mm)", "z (mm)"};
  Panel panel;
  panel.title = title;
  panel.x_label = kAxes[across];
  panel.y_label = kAxes[up];
  panel.equal_axes = true;
  for (std::size_t t = 0; t < tracked.size(); ++t) {
    const Eigen::Matrix3Xd& real = truth[t].curves.back().points;
    PlotSeries line;
    line.name = fmt::format("tentacle {}, true", t);
    line.x = Millimetres(real, across);
    line.y = Millimetres(real, up);
    line.color = static_cast<int>(t);
    panel.series.push_back(line);
    PlotSeries seen;
    PlotSeries bridged;
    seen.style = bridged.style = PlotSeries::Style::kPoints;
    seen.name = fmt::format("tentacle {}, seen", t);
    bridged.name = fmt::format("tentacle {}, bridged", t);
    seen.color = static_cast<int>(t);
    bridged.color = 6;
    const Eigen::Matrix3Xd& found = tracked[t].curves.back().points;
    for (Eigen::Index i = 0; i < found.cols(); ++i) {
      PlotSeries& to = tracked[t].interpolated.back()[i] == 0 ? seen : bridged;
      to.x.push_back(1e3 * found(across, i));
      to.y.push_back(1e3 * found(up, i));
    }
    panel.series.push_back(std::move(seen));
    panel.series.push_back(std::move(bridged));
  }
  return panel;
}

}  // namespace

Status PlotRates(const std::vector<RateGroup>& groups, const fs::path& file) {
  std::map<std::string, PlotSeries> by_design;
  for (const RateGroup& group : groups) {
    const std::string& design = group.keys[0].second;
    PlotSeries& series = by_design[design];
    series.name = design;
    series.style = PlotSeries::Style::kLineAndPoints;
    const Interval interval = WilsonInterval(group.grasped, group.trials);
    series.x.push_back(1e3 * std::strtod(group.keys[1].second.c_str(), nullptr));
    series.y.push_back(static_cast<double>(group.grasped) / static_cast<double>(group.trials));
    series.low.push_back(interval.low);
    series.high.push_back(interval.high);
  }
  Panel panel;
  panel.title = "Grasp success of virtual trials, 95 % Wilson intervals";
  panel.x_label = "carrier to object (mm)";
  panel.y_label = "success rate";
  panel.y_range = {{0, 1.05}};
  // Set a little apart, so that the bars of two designs at one distance can be told from each other.
  double shift = -0.2 * (static_cast<double>(by_design.size()) - 1);
  for (auto& [design, series] : by_design) {
    for (double& x : series.x) x += shift;
    shift += 0.4;
    panel.series.push_back(std::move(series));
  }
  Figure figure;
  figure.panels = {std::move(panel)};
  return DrawFigure(figure, file);
}

Status PlotCenterlines(const fs::path& trial_folder, const std::string& title, const fs::path& file) {
  const Result<std::vector<CurveSeries>> tracked = ReadCurves(trial_folder / "curves.h5");
  if (!tracked.ok()) return tracked.error();
  const Result<std::vector<CurveSeries>> truth = ReadCurves(trial_folder / "truth.h5");
  if (!truth.ok()) return truth.error();
  Figure figure;
  figure.columns = 2;
  figure.panel_height_px = 460;
  figure.panels = {Projection(tracked.value(), truth.value(), 0, 2, title + ", from the side"),
                   Projection(tracked.value(), truth.value(), 1, 2, title + ", from the front")};
  return DrawFigure(figure, file);
}

Status PlotLinks(const fs::path& trial_folder, const std::string& title, const fs::path& file) {
  const Result<std::vector<CurveSeries>> curves = ReadCurves(trial_folder / "curves.h5");
  if (!curves.ok()) return curves.error();
  const Result<TrialSpec> trial = ReadTrialToml(trial_folder / "trial.toml");
  if (!trial.ok()) return trial.error();
  LinkOptions options;
  options.axis = Axis{trial.value().object.position, trial.value().object.axis};
  const Result<LinkSeries> links = MeasureLinkSeries(curves.value(), options);
  if (!links.ok()) return links.error();
  Panel object;
  object.title = title + ", link with the object";
  object.x_label = "time (s)";
  object.y_label = "object link (turns)";
  Panel self = object;
  self.title = title + ", self-link";
  self.y_label = "self-link (turns)";
  for (std::size_t c = 0; c < links.value().names.size(); ++c) {
    PlotSeries of_object;
    of_object.name = links.value().names[c];
    of_object.style = PlotSeries::Style::kLineAndPoints;
    PlotSeries of_self = of_object;
    for (std::size_t f = 0; f < links.value().frames.size(); ++f) {
      const double time = links.value().time[static_cast<Eigen::Index>(f)];
      of_object.x.push_back(time);
      of_object.y.push_back(links.value().frames[f].curves[c].object_link.value);
      of_self.x.push_back(time);
      of_self.y.push_back(links.value().frames[f].curves[c].self_link.value);
    }
    object.series.push_back(std::move(of_object));
    self.series.push_back(std::move(of_self));
  }
  Figure figure;
  figure.columns = 2;
  figure.panels = {std::move(object), std::move(self)};
  return DrawFigure(figure, file);
}

}  // namespace tendril::cli
