#include "bench/grasp_trends/grasp_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "analysis/study/plots.h"

namespace tendril {
namespace {

double Mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value / static_cast<double>(values.size());
  return values.empty() ? GraspOutcome::kNone : sum;
}

double Median(std::vector<double> values) {
  if (values.empty()) return GraspOutcome::kNone;
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

// Of a mean; NaN of fewer than two values.
double StandardError(const std::vector<double>& values) {
  if (values.size() < 2) return GraspOutcome::kNone;
  const double mean = Mean(values), n = static_cast<double>(values.size());
  double sum = 0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  return std::sqrt(sum / (n - 1) / n);
}

std::string OrDash(double value, double scale, const char* format) {
  return std::isnan(value) ? "-" : fmt::format(fmt::runtime(format), scale * value);
}

// Of the trusted trials of the series about distance in one medium, by design, and held (true) or lost.
using ByGroup = std::map<std::tuple<std::string, std::string, bool>, std::vector<const GraspOutcome*>>;

ByGroup Grouped(const std::vector<GraspSeries>& series, const std::vector<GraspOutcome>& outcomes) {
  ByGroup groups;
  for (const GraspSeries& one : series) {
    if (one.name != "distance" && one.name != "water") continue;
    for (const GraspPanel& panel : one.panels) {
      for (const GraspPoint& point : panel.points) {
        for (const GraspOutcome& o : outcomes) {
          if (IsOf(point, o) && o.doubt.empty()) groups[{panel.title, point.line, Held(o)}].push_back(&o);
        }
      }
    }
  }
  return groups;
}

template <class Member>
std::vector<double> ValuesOf(const std::vector<const GraspOutcome*>& outcomes, Member member) {
  std::vector<double> values;
  for (const GraspOutcome* o : outcomes) values.push_back(static_cast<double>(o->*member));
  return values;
}

// Lines of a panel, and the paper's rates on them as points; side by side where they would cover each other.
Panel RatePanel(const GraspPanel& from, const std::vector<GraspOutcome>& outcomes) {
  Panel panel{.title = from.title,
              .x_label = from.x_label,
              .y_label = "grasps that held (%)",
              .y_range = {{-4, 104}}};
  std::vector<std::string> lines;
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (const GraspPoint& point : from.points) {
    if (std::find(lines.begin(), lines.end(), point.line) == lines.end()) lines.push_back(point.line);
    low = std::min(low, point.x);
    high = std::max(high, point.x);
  }
  const double aside = 0.006 * (high - low);
  panel.x_range = {{low - 0.08 * (high - low), high + 0.08 * (high - low)}};
  for (std::size_t l = 0; l < lines.size(); ++l) {
    const int color = static_cast<int>(l);
    const double shift = aside * (2 * static_cast<double>(l) - static_cast<double>(lines.size()) + 1);
    PlotSeries ours{.name = lines[l], .style = PlotSeries::Style::kLineAndPoints, .color = color};
    PlotSeries paper{.name = lines[l] + ", paper", .style = PlotSeries::Style::kPoints, .color = 5 - color};
    for (const GraspPoint& point : from.points) {
      if (point.line != lines[l]) continue;
      if (!std::isnan(point.paper)) {
        paper.x.push_back(point.x + 2 * shift);
        paper.y.push_back(100 * point.paper);
      }
      const GraspCount count = CountGrasps(point, outcomes);
      if (count.trusted == 0) continue;
      ours.x.push_back(point.x + shift);
      ours.y.push_back(100 * count.Rate());
      ours.low.push_back(100 * count.interval.low);
      ours.high.push_back(100 * count.interval.high);
    }
    if (lines.size() == 1 && paper.x.empty()) ours.name = "";  // the panel's title says all
    panel.series.push_back(std::move(ours));
    if (!paper.x.empty()) panel.series.push_back(std::move(paper));
  }
  return panel;
}

// Of the curves alone.
Panel LinkPanel(const ByGroup& groups, const std::string& title) {
  Panel panel{.title = title,
              .x_label = "mutual link of the curves alone, mean (turns)",
              .y_label = "object link, mean (turns)"};
  double right = 0, top = 0;
  for (const auto& [key, trials] : groups) {
    const auto& [of, line, held] = key;
    const bool first = line == std::get<1>(groups.begin()->first);
    const PlotSeries points{.name = line + (held ? ", held" : ", lost"),
                            .x = ValuesOf(trials, &GraspOutcome::mutual_open),
                            .y = ValuesOf(trials, &GraspOutcome::object_open),
                            .style = PlotSeries::Style::kPoints,
                            .color = held ? (first ? 0 : 1) : (first ? 5 : 4)};
    right = std::max(right, *std::max_element(points.x.begin(), points.x.end()));
    top = std::max(top, *std::max_element(points.y.begin(), points.y.end()));
    if (of == title) panel.series.push_back(points);
  }
  panel.x_range = {{0, 1.1 * right}};
  panel.y_range = {{0, 1.1 * top}};
  return panel;
}

}  // namespace

bool IsOf(const GraspPoint& point, const GraspOutcome& outcome) {
  return outcome.scene == point.scene && outcome.settings == JoinedSettings(point.settings);
}

double GraspCount::Rate() const {
  return trusted == 0 ? GraspOutcome::kNone : static_cast<double>(held) / trusted;
}

GraspCount CountGrasps(const GraspPoint& point, const std::vector<GraspOutcome>& outcomes) {
  GraspCount count;
  std::vector<double> drawn_in;
  for (const GraspOutcome& o : outcomes) {
    if (!IsOf(point, o)) continue;
    if (!o.doubt.empty()) {
      ++count.doubtful;
      continue;
    }
    ++count.trusted;
    count.held += Held(o) ? 1 : 0;
    count.raised += o.drawn_in >= kRaised ? 1 : 0;
    if (Held(o)) drawn_in.push_back(o.drawn_in);
  }
  count.interval = WilsonInterval(count.held, count.trusted);
  count.drawn_in = Median(drawn_in);
  return count;
}

std::string GraspTable(const std::vector<GraspSeries>& series, const std::vector<GraspOutcome>& outcomes) {
  std::string text =
      "| series | design | at | held | rate, 95 % interval | raised by the pull | drawn in, mm | paper |\n"
      "|---|---|---|---|---|---|---|---|\n";
  std::set<std::string> there;  // the scene's own values stand once
  for (const GraspSeries& one : series) {
    for (const GraspPanel& panel : one.panels) {
      for (const GraspPoint& point : panel.points) {
        const bool again = !there.insert(point.scene + " " + JoinedSettings(point.settings)).second;
        if (again && one.name == "sensitivity") continue;
        const GraspCount c = CountGrasps(point, outcomes);
        if (c.trusted + c.doubtful == 0) continue;
        const std::string of = one.name == "sensitivity" ? panel.title : one.name;
        const std::string doubtful = c.doubtful > 0 ? fmt::format(" ({} not trusted)", c.doubtful) : "";
        const std::string raised = point.tugged ? "-" : fmt::format("{}", c.raised);
        text += fmt::format("| {} | {} | {} | {} of {}{} | {} %, {:.0f} to {:.0f} | {} | {} | {} |\n", of,
                            point.line, point.label, c.held, c.trusted, doubtful,
                            OrDash(c.Rate(), 100, "{:.0f}"), 100 * c.interval.low, 100 * c.interval.high,
                            raised, OrDash(c.drawn_in, 1e3, "{:.0f}"), point.paper_says);
      }
    }
  }
  return text;
}

std::string LinkTable(const std::vector<GraspSeries>& series, const std::vector<GraspOutcome>& outcomes) {
  std::string text =
      "| where | design | outcome | trials | mutual link | object link | mutual, curves alone | object, "
      "curves alone | rods wound about the object | about another rod |\n"
      "|---|---|---|---|---|---|---|---|---|---|\n";
  for (const auto& [key, trials] : Grouped(series, outcomes)) {
    const auto& [title, line, held] = key;
    text += fmt::format("| {} | {} | {} | {} |", title, line, held ? "held" : "lost", trials.size());
    for (const auto member : {&GraspOutcome::mutual_link, &GraspOutcome::object_link,
                              &GraspOutcome::mutual_open, &GraspOutcome::object_open}) {
      const std::vector<double> values = ValuesOf(trials, member);
      text += fmt::format(" {:.3f} +- {} |", Mean(values), OrDash(StandardError(values), 1, "{:.3f}"));
    }
    text += fmt::format(" {:.1f} | {:.1f} |\n", Mean(ValuesOf(trials, &GraspOutcome::looping)),
                        Mean(ValuesOf(trials, &GraspOutcome::braiding)));
  }
  return text;
}

Status DrawGrasps(const std::vector<GraspSeries>& series, const std::vector<GraspOutcome>& outcomes,
                  const std::filesystem::path& folder) {
  for (const GraspSeries& one : series) {
    const bool many = one.panels.size() > 1;
    Figure figure{
        .columns = many ? 2 : 1, .panel_width_px = many ? 500 : 680, .panel_height_px = many ? 240 : 340};
    for (const GraspPanel& panel : one.panels) figure.panels.push_back(RatePanel(panel, outcomes));
    if (Status s = DrawFigure(figure, folder / ("grasp_" + one.name + ".svg")); !s.ok()) return s;
  }
  const ByGroup groups = Grouped(series, outcomes);
  Figure figure{.columns = 2, .panel_width_px = 560, .panel_height_px = 300};
  std::string last;
  for (const auto& [key, trials] : groups) {
    const std::string& title = std::get<0>(key);
    if (title == last) continue;
    last = title;
    figure.panels.push_back(LinkPanel(groups, title));
  }
  return figure.panels.empty() ? Status(Ok{}) : DrawFigure(figure, folder / "grasp_links.svg");
}

}  // namespace tendril
