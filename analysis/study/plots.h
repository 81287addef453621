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

// A map of numbers: cells of one size that fill a rectangle of the panel.
struct PlotHeat {
  int columns = 0;
  int rows = 0;
  std::vector<double> values = {};  // row by row, the lowest first; NaN: gray        (rows columns)
  std::vector<char> hatched = {};   // likewise; 1: gray hatching over the colour; no entries: none
  double left = 0, right = 1;       // outer edges of the map, on the panel's axes
  double bottom = 0, top = 1;
  std::pair<double, double> range = {0, 1};  // values that the ends of the colour bar stand for
  std::string label = {};                    // of the colour bar, with the unit
  // Names of the values 0, 1, ..., each with its colour ("#rrggbb"), instead of a scale.
  std::vector<std::pair<std::string, std::string>> classes = {};
};

struct Panel {
  std::string title = {};
  std::string x_label = {};  // with the unit
  std::string y_label = {};
  std::vector<PlotSeries> series = {};
  std::vector<PlotPolygon> polygons = {};  // need both ranges
  std::vector<PlotText> texts = {};
  std::optional<PlotHeat> heat = {};  // below everything else
  bool equal_axes = false;            // one metre is as long on x as on y
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
//   errors  kBadInput  another extension, no panel, a series, polygon or map whose arrays differ in length
//           kIo        gnuplot is missing or fails (its message), the disk
Status DrawFigure(const Figure& figure, const std::filesystem::path& file);

// The same as an <svg> element for a page: no declaration, no reference to anything outside, its ids begin
// with `id`.
//   id      letters and digits, another one for each figure of a page
//   title   what the figure shows, in words, for those who cannot see it
//   errors  as DrawFigure
Result<std::string> FigureForPage(const Figure& figure, const std::string& id, const std::string& title);

}  // namespace tendril
