#pragma once
// Figures of curves, rates and time series, drawn by gnuplot as SVG or PNG.
//
// A figure is a grid of panels that share one legend style; values are drawn as they are given, so the axes'
// labels state their units. NaN breaks a line.

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "model/result.h"

namespace tendril {

struct PlotSeries {
  enum class Style { kLine, kPoints, kLineAndPoints };

  std::string name = {};  // in the legend; empty: not listed
  std::vector<double> x = {};
  std::vector<double> y = {};
  std::vector<double> low = {};  // interval about y: bars at points, a band about lines; no entries: none
  std::vector<double> high = {};
  Style style = Style::kLine;
  int color = -1;  // of the palette, 0 .. 7; -1: the series' place in the panel
};

// A filled outline; later ones cover earlier ones.
struct PlotPolygon {
  std::vector<double> x = {};
  std::vector<double> y = {};
  std::string fill = {};  // "#rrggbb"
};

struct PlotText {
  double x = 0;
  double y = 0;  // its middle
  std::string text = {};
};

struct Panel {
  std::string title = {};
  std::string x_label = {};  // with the unit
  std::string y_label = {};
  std::vector<PlotSeries> series = {};
  std::vector<PlotPolygon> polygons = {};  // need both ranges
  std::vector<PlotText> texts = {};
  bool equal_axes = false;  // one metre is as long on x as on y
  std::optional<std::pair<double, double>> x_range = {};
  std::optional<std::pair<double, double>> y_range = {};
};

struct Figure {
  std::vector<Panel> panels = {};  // row by row
  int columns = 1;
  int panel_width_px = 620;
  int panel_height_px = 420;
};

// Draws into `file`, .svg or .png by its extension; written beside it and renamed.
//   errors  kBadInput  another extension, no panel, a series or polygon whose arrays differ in length
//           kIo        gnuplot is missing or fails (its message), the disk
Status DrawFigure(const Figure& figure, const std::filesystem::path& file);

}  // namespace tendril
