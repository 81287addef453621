#include "cli/lab_plots.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <utility>

#include "analysis/link/link_series.h"
#include "analysis/statistics/intervals.h"
#include "analysis/study/plots.h"
#include "cli/score_trial.h"
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

Panel Projection(const std::vector<CurveSeries>& curves, const std::vector<CurveSeries>* truth, int frame,
                 int across, int up, const std::string& title) {
  constexpr const char* kAxes[] = {"x (mm)", "y (mm)", "z (mm)"};
  Panel panel;
  panel.title = title;
  panel.x_label = kAxes[across];
  panel.y_label = kAxes[up];
  panel.equal_axes = true;
  for (std::size_t c = 0; c < curves.size(); ++c) {
    const auto f = static_cast<std::size_t>(frame);
    const Eigen::Matrix3Xd& found = curves[c].curves[f].points;
    const Eigen::Matrix3Xd& joined = truth != nullptr ? (*truth)[c].curves[f].points : found;
    const int color = static_cast<int>(c % 6);
    PlotSeries line;
    line.name = curves[c].name + (truth != nullptr ? ", true" : "");
    line.x = Millimetres(joined, across);
    line.y = Millimetres(joined, up);
    line.color = color;
    PlotSeries seen;
    PlotSeries bridged;
    seen.style = bridged.style = PlotSeries::Style::kPoints;
    seen.name = curves[c].name + ", seen";
    bridged.name = curves[c].name + ", bridged";
    seen.color = color;
    bridged.color = 6;
    for (Eigen::Index i = 0; i < found.cols(); ++i) {
      const bool was_seen = curves[c].interpolated.empty() || curves[c].interpolated[f][i] == 0;
      PlotSeries& to = was_seen ? seen : bridged;
      to.x.push_back(1e3 * found(across, i));
      to.y.push_back(1e3 * found(up, i));
    }
    for (PlotSeries* series : {&line, &seen, &bridged}) panel.series.push_back(std::move(*series));
  }
  return panel;
}

}  // namespace

Status PlotRates(const std::vector<RateGroup>& groups, const std::string& x_label, double scale,
                 const fs::path& file) {
  std::map<std::string, PlotSeries> by_name;
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const RateGroup& group : groups) {
    std::string name;
    for (std::size_t k = 0; k + 1 < group.keys.size(); ++k)
      name += (k > 0 ? ", " : "") + group.keys[k].second;
    PlotSeries& series = by_name[name];
    series.name = name;
    series.style = PlotSeries::Style::kLineAndPoints;
    const Interval interval = WilsonInterval(group.grasped, group.trials);
    const double x = scale * std::strtod(group.keys.back().second.c_str(), nullptr);
    low = std::min(low, x);
    high = std::max(high, x);
    series.x.push_back(x);
    series.y.push_back(static_cast<double>(group.grasped) / static_cast<double>(group.trials));
    series.low.push_back(interval.low);
    series.high.push_back(interval.high);
  }
  Panel panel;
  panel.title = "Grasp success, 95 % Wilson intervals";
  panel.x_label = x_label;
  panel.y_label = "success rate";
  panel.y_range = {{0, 1.05}};
  const double width = high > low ? high - low : 1;
  if (high >= low) panel.x_range = {{low - 0.1 * width, high + 0.1 * width}};
  // Set a little apart, so that the bars of two series at one place can be told from each other.
  double shift = -0.0075 * width * (static_cast<double>(by_name.size()) - 1);
  for (auto& [name, series] : by_name) {
    for (double& x : series.x) x += shift;
    shift += 0.015 * width;
    panel.series.push_back(std::move(series));
  }
  Figure figure;
  figure.panels = {std::move(panel)};
  return DrawFigure(figure, file);
}

Status PlotCenterlines(const std::vector<CurveSeries>& curves, const std::vector<CurveSeries>* truth,
                       int frame, const std::string& title, const fs::path& file) {
  const int frames = static_cast<int>(curves.front().curves.size());
  if (frame < -1 || frame >= frames) {
    return Error{ErrorKind::kBadInput, fmt::format("frame {}: there are frames 0 .. {}", frame, frames - 1)};
  }
  const int shown = frame < 0 ? frames - 1 : frame;
  Figure figure;
  figure.columns = 2;
  figure.panels = {Projection(curves, truth, shown, 0, 2, title + ", from the side"),
                   Projection(curves, truth, shown, 1, 2, title + ", from the front")};
  return DrawFigure(figure, file);
}

Status PlotLinks(const fs::path& trial_folder, const std::string& title, const fs::path& file) {
  const Result<TrialSpec> trial = ReadTrialToml(trial_folder / "trial.toml");
  if (!trial.ok()) return trial.error();
  const Result<std::vector<CurveSeries>> curves = CurvesAboutObject(trial_folder, trial.value());
  if (!curves.ok()) return curves.error();
  LinkOptions options;
  options.axis = AxisOf(trial.value());
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
  if (options.axis) figure.panels.push_back(std::move(object));
  figure.panels.push_back(std::move(self));
  figure.columns = static_cast<int>(figure.panels.size());
  return DrawFigure(figure, file);
}

}  // namespace tendril::cli
