#include "cli/report_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "analysis/study/plots.h"
#include "capture/track/chain_solve.h"
#include "model/median.h"

namespace tendril::cli {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kDegree = std::numbers::pi / 180;
constexpr int kWidth = 480;  // of a panel that stands beside another, px

// Time cut into columns of one width, for a map: which frame each shows, -1 where there is none.
struct TimeColumns {
  std::vector<int> frame;
  double left = 0, right = 1;  // outer edges, s
};

TimeColumns ColumnsOf(const Eigen::VectorXd& time) {
  constexpr double kMost = 400;
  const Eigen::Index frames = time.size();
  const double span = time[frames - 1] - time[0];
  if (frames < 2 || !(span > 0)) return {{0}, time[0] - 0.5, time[0] + 0.5};
  std::vector<double> steps;
  for (Eigen::Index f = 1; f < frames; ++f) steps.push_back(time[f] - time[f - 1]);
  double interval = Median(steps);
  if (!(interval > 0)) interval = span / static_cast<double>(frames - 1);
  const int count = static_cast<int>(std::min(kMost, std::round(span / interval) + 1));
  if (count < 2) return {{0}, time[0] - 0.5, time[0] + 0.5};
  const double width = span / (count - 1);
  TimeColumns columns{{}, time[0] - 0.5 * width, time[frames - 1] + 0.5 * width};
  Eigen::Index nearest = 0;
  for (int k = 0; k < count; ++k) {
    const double at = time[0] + k * width;
    while (nearest + 1 < frames && std::abs(time[nearest + 1] - at) <= std::abs(time[nearest] - at))
      ++nearest;
    const bool near = std::abs(time[nearest] - at) < 0.6 * std::max(interval, width);
    columns.frame.push_back(near ? static_cast<int>(nearest) : -1);
  }
  return columns;
}

Panel MapPanel(const TimeColumns& columns, const std::string& title, const std::string& rows_label,
               int rows) {
  Panel panel;
  panel.title = title;
  panel.x_label = "time (s)";
  panel.y_label = rows_label;
  panel.x_range = {{columns.left, columns.right}};
  panel.y_range = {{-0.5, rows - 0.5}};
  PlotHeat heat;
  heat.columns = static_cast<int>(columns.frame.size());
  heat.rows = rows;
  heat.values.assign(columns.frame.size() * static_cast<std::size_t>(rows), kNone);
  heat.left = columns.left;
  heat.right = columns.right;
  heat.bottom = -0.5;
  heat.top = rows - 0.5;
  panel.heat = std::move(heat);
  return panel;
}

// Range of the colour bar that suits all tentacles, from 0 or, where creases turn the other way, below.
std::pair<double, double> FoldRange(const TrialFacts& facts) {
  double low = 0;
  double high = 10;
  for (std::size_t t = 0; t < facts.curves.size(); ++t) {
    for (std::size_t f = 0; f < facts.curves[t].angle.size(); ++f) {
      const Eigen::VectorXd& angle = facts.curves[t].angle[f];
      const auto& sights = facts.tentacles[t].sights[f];
      for (Eigen::Index i = 0; i < angle.size(); ++i) {
        const auto crease = static_cast<std::size_t>(i);
        if (std::max(sights[crease], sights[crease + 1]) == NodeSight::kNotSeen) continue;
        low = std::min(low, 5 * std::floor(angle[i] / kDegree / 5));
        high = std::max(high, 10 * std::ceil(angle[i] / kDegree / 10));
      }
    }
  }
  return {low, high};
}

Figure FoldMap(const CurveSeries& series, const TentacleFacts& tentacle, std::pair<double, double> range) {
  const TimeColumns columns = ColumnsOf(series.time);
  const int creases = static_cast<int>(series.angle.front().size());
  Panel panel = MapPanel(columns, series.name + ": fold angle", "crease, from the base", creases);
  PlotHeat& heat = *panel.heat;
  heat.hatched.assign(heat.values.size(), 0);
  heat.range = range;
  heat.label = "phi (degrees)";
  for (std::size_t k = 0; k < columns.frame.size(); ++k) {
    if (columns.frame[k] < 0) continue;
    const auto frame = static_cast<std::size_t>(columns.frame[k]);
    for (int i = 0; i < creases; ++i) {
      const auto crease = static_cast<std::size_t>(i);
      const std::size_t cell = crease * columns.frame.size() + k;
      const NodeSight sight = std::max(tentacle.sights[frame][crease], tentacle.sights[frame][crease + 1]);
      if (sight != NodeSight::kNotSeen) heat.values[cell] = series.angle[frame][i] / kDegree;
      const bool told = series.angle_by_pictures.empty()
                            ? sight == NodeSight::kSeen
                            : series.angle_by_pictures[frame][i] >= kToldByPictures;
      heat.hatched[cell] = sight != NodeSight::kNotSeen && !told ? 1 : 0;
    }
  }
  return {.panels = {std::move(panel)}, .columns = 1, .panel_width_px = kWidth, .panel_height_px = 260};
}

Figure SightMap(const CurveSeries& series, const TentacleFacts& tentacle) {
  const TimeColumns columns = ColumnsOf(series.time);
  const int nodes = static_cast<int>(tentacle.median_sigma_at.size());
  Panel panel = MapPanel(columns, series.name + ": nodes", "node, from the base", nodes);
  PlotHeat& heat = *panel.heat;
  // The overlay's colours.
  heat.classes = {{"seen", "#40d0ff"}, {"bridged", "#ffa500"}, {"not seen", "#d65cd6"}};
  for (std::size_t k = 0; k < columns.frame.size(); ++k) {
    if (columns.frame[k] < 0) continue;
    const auto& sights = tentacle.sights[static_cast<std::size_t>(columns.frame[k])];
    for (std::size_t i = 0; i < sights.size(); ++i) {
      heat.values[i * columns.frame.size() + k] = static_cast<double>(sights[i]);
    }
  }
  return {.panels = {std::move(panel)}, .columns = 1, .panel_width_px = kWidth, .panel_height_px = 260};
}

std::vector<double> Numbers(const Eigen::VectorXd& values) { return {values.begin(), values.end()}; }

// Few points are shown as points, so that a trial of one frame is seen at all.
PlotSeries Line(const std::string& name, std::vector<double> x, std::vector<double> y) {
  PlotSeries series{.name = name, .x = std::move(x), .y = std::move(y)};
  series.style = series.x.size() <= 60 ? PlotSeries::Style::kLineAndPoints : PlotSeries::Style::kLine;
  return series;
}

Panel TimePanel(const std::string& title, const std::string& y_label) {
  Panel panel;
  panel.title = title;
  panel.x_label = "time (s)";
  panel.y_label = y_label;
  return panel;
}

// From 0 to a little above the largest value of the panel.
void BeginAtZero(Panel& panel) {
  double top = 0;
  for (const PlotSeries& series : panel.series) {
    for (const double y : series.y) top = std::fmax(top, y);
  }
  panel.y_range = {{0, top > 0 ? 1.05 * top : 1}};
}

Figure SeenFigure(const TrialFacts& facts) {
  Panel panel = TimePanel("nodes whose facet was seen", "% of nodes");
  panel.y_range = {{0, 105}};
  for (std::size_t t = 0; t < facts.tentacles.size(); ++t) {
    std::vector<double> percent;
    for (const double share : facts.tentacles[t].seen_by_frame) percent.push_back(100 * share);
    panel.series.push_back(Line(facts.tentacles[t].name, Numbers(facts.curves[t].time), std::move(percent)));
  }
  return {.panels = {std::move(panel)}, .columns = 1, .panel_width_px = 2 * kWidth, .panel_height_px = 260};
}

Figure SigmaFigure(const TrialFacts& facts) {
  Panel median;
  median.title = "sigma along the tentacle, median over frames";
  median.x_label = "node, from the base";
  median.y_label = "sigma (mm)";
  Panel worst = median;
  worst.title = "the largest of any frame";
  for (const TentacleFacts& tentacle : facts.tentacles) {
    std::vector<double> nodes;
    std::vector<double> middle_mm;
    std::vector<double> worst_mm;
    for (std::size_t i = 0; i < tentacle.median_sigma_at.size(); ++i) {
      nodes.push_back(static_cast<double>(i));
      middle_mm.push_back(1e3 * tentacle.median_sigma_at[i]);
      worst_mm.push_back(1e3 * tentacle.worst_sigma_at[i]);
    }
    median.series.push_back(Line(tentacle.name, nodes, std::move(middle_mm)));
    worst.series.push_back(Line(tentacle.name, std::move(nodes), std::move(worst_mm)));
  }
  BeginAtZero(median);
  BeginAtZero(worst);
  return {.panels = {std::move(median), std::move(worst)},
          .columns = 2,
          .panel_width_px = kWidth,
          .panel_height_px = 280};
}

std::string CameraTitle(const CameraFacts& camera) {
  return camera.name.empty() ? fmt::format("camera {}", camera.number)
                             : fmt::format("{}: {}", camera.number, camera.name);
}

// Outline of a histogram of the tags' RMS, as shares of the camera's tags.
PlotSeries Histogram(const CameraFacts& camera, double width, int bins) {
  std::vector<double> counts(static_cast<std::size_t>(bins), 0);
  for (const double rms : camera.tag_rms) {
    counts[static_cast<std::size_t>(std::min<double>(bins - 1, std::floor(rms / width)))] += 1;
  }
  PlotSeries outline{.name = CameraTitle(camera), .color = camera.number};
  for (int b = 0; b < bins; ++b) {
    const double share = 100 * counts[static_cast<std::size_t>(b)] /
                         std::max<double>(1, static_cast<double>(camera.tag_rms.size()));
    for (const double x : {b * width, (b + 1) * width}) {
      outline.x.push_back(x);
      outline.y.push_back(share);
    }
  }
  return outline;
}

Figure ResidualFigure(const TrialFacts& facts) {
  constexpr int kBins = 40;
  Panel over_time = TimePanel("tags against the chain, by camera", "RMS of the corners (px)");
  Panel histogram;
  histogram.title = "how the tags spread";
  histogram.x_label = "RMS of a tag's four corners (px); the last bin holds all beyond";
  histogram.y_label = "% of the camera's tags";
  std::vector<double> all;
  for (const CameraFacts& camera : facts.cameras) {
    all.insert(all.end(), camera.tag_rms.begin(), camera.tag_rms.end());
  }
  const double widest = all.empty() ? 1 : *std::max_element(all.begin(), all.end());
  const double width = std::max(1e-6, std::min(widest, 5 * (all.empty() ? 1 : Median(all)))) / kBins;
  for (const CameraFacts& camera : facts.cameras) {
    PlotSeries line = Line(CameraTitle(camera), Numbers(facts.curves.front().time), camera.rms_by_frame);
    line.color = camera.number;
    over_time.series.push_back(std::move(line));
    histogram.series.push_back(Histogram(camera, width, kBins));
  }
  BeginAtZero(over_time);
  BeginAtZero(histogram);
  return {.panels = {std::move(over_time), std::move(histogram)},
          .columns = 2,
          .panel_width_px = kWidth,
          .panel_height_px = 280};
}

// A line with its 95 % band. Where strands may have passed each other a mean says nothing: there the line has
// a gap, and each value that it may have is a point.
void AddBand(const TrialFacts& facts, const std::string& name, const std::vector<const LinkBand*>& bands,
             Panel& panel) {
  constexpr double kLeast = 0.05;  // share of a mode that is drawn
  PlotSeries series;
  series.name = name;
  series.color = static_cast<int>(panel.series.size() / 2) % 8;
  PlotSeries points{.style = PlotSeries::Style::kPoints, .color = series.color};
  for (std::size_t k = 0; k < bands.size(); ++k) {
    const double time = facts.curves.front().time[facts.link.frames[k]];
    // With less than 2.5 % elsewhere the band lies in the one that is left, and its value stands for the
    // mean.
    const std::vector<LinkMode>& modes = bands[k]->modes;
    const bool one = modes.size() < 2 || modes.front().share > 0.975;
    const double value = modes.empty() ? bands[k]->mean : modes.front().value;
    series.x.push_back(time);
    series.y.push_back(one ? value : kNone);
    series.low.push_back(one ? bands[k]->low95 : kNone);
    series.high.push_back(one ? bands[k]->high95 : kNone);
    if (one && bands.size() > 60) continue;
    if (one) {
      points.x.push_back(time);
      points.y.push_back(value);
    }
    for (const LinkMode& mode : modes) {
      if (one || mode.share < kLeast) continue;
      points.x.push_back(time);
      points.y.push_back(mode.value);
    }
  }
  panel.series.push_back(std::move(series));
  panel.series.push_back(std::move(points));
}

std::vector<Panel> LinkPanels(const TrialFacts& facts) {
  constexpr std::size_t kMostPairs = 6;
  const std::vector<LinkBands>& bands = facts.link.bands;
  std::vector<Panel> panels;
  const auto over = [&](const auto& pick) {
    std::vector<const LinkBand*> all;
    for (const LinkBands& moment : bands) all.push_back(&pick(moment));
    return all;
  };
  if (facts.link.axis) {
    Panel object = TimePanel("link with the object", "turns");
    for (std::size_t c = 0; c < facts.tentacles.size(); ++c) {
      AddBand(facts, facts.tentacles[c].name,
              over([c](const LinkBands& m) -> const LinkBand& { return m.curves[c].object_link; }), object);
    }
    panels.push_back(std::move(object));
  }
  Panel self = TimePanel("writhe", "turns");
  for (std::size_t c = 0; c < facts.tentacles.size(); ++c) {
    AddBand(facts, facts.tentacles[c].name,
            over([c](const LinkBands& m) -> const LinkBand& { return m.curves[c].writhe; }), self);
  }
  panels.push_back(std::move(self));
  const std::size_t pairs = bands.front().pairs.size();
  if (pairs > 0 && pairs <= kMostPairs) {
    Panel each = TimePanel("link of the pairs", "turns");
    for (std::size_t p = 0; p < pairs; ++p) {
      AddBand(facts, fmt::format("{} - {}", bands.front().pairs[p].a, bands.front().pairs[p].b),
              over([p](const LinkBands& m) -> const LinkBand& { return m.pairs[p].link; }), each);
    }
    panels.push_back(std::move(each));
  }
  if (pairs > 0) {
    Panel sums = TimePanel("means of the magnitude", "turns");
    AddBand(facts, "mutual link", over([](const LinkBands& m) -> const LinkBand& { return m.mutual_link; }),
            sums);
    if (facts.link.axis) {
      AddBand(facts, "object link", over([](const LinkBands& m) -> const LinkBand& { return m.object_link; }),
              sums);
      AddBand(facts, "performance (sum)",
              over([](const LinkBands& m) -> const LinkBand& { return m.performance; }), sums);
    }
    panels.push_back(std::move(sums));
  }
  return panels;
}

}  // namespace

Result<PageFigures> DrawPageFigures(const TrialFacts& facts, const Progress& progress) {
  PageFigures figures;
  int number = 0;
  const double steps = static_cast<double>(2 * facts.curves.size()) + 4;
  const auto add = [&](const Figure& figure, const std::string& caption,
                       std::vector<PageFigure>& to) -> Status {
    Result<std::string> svg = FigureForPage(figure, fmt::format("f{}", ++number), caption);
    if (!svg.ok()) return svg.error();
    to.push_back({std::move(svg).value(), caption});
    if (progress && !progress(std::min(1.0, number / steps))) {
      return Error{ErrorKind::kStopped, "stopped while plots were drawn; no page was written"};
    }
    return Ok{};
  };
  const std::pair<double, double> range = FoldRange(facts);
  for (std::size_t t = 0; t < facts.curves.size(); ++t) {
    const std::string& name = facts.curves[t].name;
    if (!facts.curves[t].angle.empty() && facts.curves[t].angle.front().size() > 0) {
      if (Status s = add(FoldMap(facts.curves[t], facts.tentacles[t], range),
                         name + ": fold angles over time", figures.folds);
          !s.ok()) {
        return s.error();
      }
    }
    if (Status s = add(SightMap(facts.curves[t], facts.tentacles[t]),
                       name + ": which nodes were seen, bridged and not seen, over time", figures.sights);
        !s.ok()) {
      return s.error();
    }
  }
  if (Status s = add(SeenFigure(facts), "share of the nodes whose facet was seen, over time", figures.seen);
      !s.ok())
    return s.error();
  const bool sigma = std::any_of(facts.tentacles.begin(), facts.tentacles.end(),
                                 [](const TentacleFacts& t) { return std::isfinite(t.worst_sigma); });
  if (sigma) {
    if (Status s = add(SigmaFigure(facts), "sigma of each node, median and largest", figures.sigma); !s.ok())
      return s.error();
  }
  if (facts.residuals_known && !facts.cameras.empty()) {
    if (Status s = add(ResidualFigure(facts), "residuals by camera, over time and as a histogram",
                       figures.residuals);
        !s.ok()) {
      return s.error();
    }
  }
  if (!facts.link.bands.empty()) {
    const Figure figure{
        .panels = LinkPanels(facts), .columns = 2, .panel_width_px = kWidth, .panel_height_px = 280};
    if (Status s = add(figure, "links over time with their 95 % bands", figures.link); !s.ok())
      return s.error();
  }
  return figures;
}

}  // namespace tendril::cli
