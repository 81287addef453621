#include "analysis/study/plots.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string_view>
#include <system_error>

#include "db/files/page_text.h"
#include "db/files/safe_file.h"

extern char** environ;

namespace tendril {
namespace {

namespace fs = std::filesystem;

// Okabe and Ito's palette: told apart by the colour-blind too; black last.
constexpr std::array<const char*, 8> kPalette = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                                 "#E69F00", "#56B4E9", "#7F7F7F", "#000000"};

// A gnuplot string without escapes: single quotes are doubled, control characters become blanks.
std::string Quoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) {
    if (c == '\'') quoted += '\'';
    quoted += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return quoted + "'";
}

// A number that gnuplot reads back; a gap is a blank line, which breaks a line.
void AppendRow(std::string& data, const PlotSeries& series, size_t i) {
  if (!std::isfinite(series.x[i]) || !std::isfinite(series.y[i])) {
    data += '\n';
    return;
  }
  data += fmt::format("{:.9g} {:.9g}", series.x[i], series.y[i]);
  if (!series.low.empty()) data += fmt::format(" {:.9g} {:.9g}", series.low[i], series.high[i]);
  data += '\n';
}

bool HasValue(const PlotSeries& series) {
  for (size_t i = 0; i < series.x.size(); ++i) {
    if (std::isfinite(series.x[i]) && std::isfinite(series.y[i])) return true;
  }
  return false;
}

std::string Range(const std::optional<std::pair<double, double>>& range) {
  return range ? fmt::format("[{:.9g}:{:.9g}]", range->first, range->second) : "[*:*]";
}

// How many dots a cell of a map has: so many that viewers which blur pictures leave its edges alone, and that
// hatching is as fine in wide cells as in narrow ones.
struct CellDots {
  int across = 1;
  int up = 1;
};

CellDots DotsOf(const PlotHeat& heat) {
  return {std::max(1, 480 / heat.columns), std::max(1, 240 / heat.rows)};
}

// The map as a matrix that gnuplot reads, a line per row of dots, the lowest first. Hatching leaves out dots.
std::string HeatRows(const PlotHeat& heat) {
  constexpr int kHatch = 6;  // dots from line to line
  const CellDots dots = DotsOf(heat);
  std::string text;
  for (int y = 0; y < heat.rows * dots.up; ++y) {
    for (int x = 0; x < heat.columns * dots.across; ++x) {
      const auto cell = static_cast<size_t>(y / dots.up * heat.columns + x / dots.across);
      const bool left_out = !heat.hatched.empty() && heat.hatched[cell] != 0 && (x + y) % kHatch < 2;
      const double value = heat.values[cell];
      text += left_out || !std::isfinite(value) ? "NaN " : fmt::format("{:.6g} ", value);
    }
    text += '\n';
  }
  return text;
}

// The datablocks come first, as a multiplot refuses to define them between its panels on some terminals.
std::string DataBlocks(const Panel& panel, size_t number) {
  std::string text;
  for (size_t s = 0; s < panel.series.size(); ++s) {
    text += fmt::format("$d{}_{} << EOD\n", number, s);
    for (size_t i = 0; i < panel.series[s].x.size(); ++i) AppendRow(text, panel.series[s], i);
    text += "EOD\n";
  }
  if (panel.heat) text += fmt::format("$h{} << EOD\n{}EOD\n", number, HeatRows(*panel.heat));
  return text;
}

// Polygons and text are objects and labels of the panel, counted from 1.
std::string PanelObjects(const Panel& panel) {
  std::string text = "unset object\nunset label\n";
  for (size_t i = 0; i < panel.polygons.size(); ++i) {
    const PlotPolygon& polygon = panel.polygons[i];
    text += fmt::format("set object {} polygon", i + 1);
    for (size_t k = 0; k <= polygon.x.size(); ++k) {
      const size_t at = k % polygon.x.size();
      text += fmt::format("{} {:.9g},{:.9g}", k == 0 ? " from" : " to", polygon.x[at], polygon.y[at]);
    }
    text += fmt::format(" front fc rgb {} fs solid 1 border lc rgb '#333333' lw 0.4\n", Quoted(polygon.fill));
  }
  for (size_t i = 0; i < panel.texts.size(); ++i) {
    const PlotText& t = panel.texts[i];
    text += fmt::format("set label {} {} at {:.9g},{:.9g} center front\n", i + 1, Quoted(t.text), t.x, t.y);
  }
  return text;
}

// Colours, gray for what is not known, and the plot command's part that draws the map; without a map the
// colour bar of the panel before goes.
std::string HeatCommands(const PlotHeat& heat, size_t number, std::string& plot) {
  const CellDots dots = DotsOf(heat);
  const double across = (heat.right - heat.left) / (heat.columns * dots.across);
  const double up = (heat.top - heat.bottom) / (heat.rows * dots.up);
  plot = fmt::format("$h{} matrix using ({:.12g}+{:.12g}*$1):({:.12g}+{:.12g}*$2):3 with image notitle, ",
                     number, heat.left + 0.5 * across, across, heat.bottom + 0.5 * up, up);
  std::string text =
      "set object 100000 rectangle from graph 0,0 to graph 1,1 behind fc rgb '#b8b8b8' fs solid noborder\n";
  text += fmt::format("set cblabel {}\nset colorbox\n", Quoted(heat.label));
  if (heat.classes.empty()) {
    return text + fmt::format(
                      "set palette defined (0 '#440154', 1 '#3b528b', 2 '#21918c', 3 '#5ec962', 4 '#fde725') "
                      "maxcolors 0\n"
                      "set cbrange [{:.9g}:{:.9g}]\nset cbtics autofreq\n",
                      heat.range.first, heat.range.second);
  }
  std::string colors;
  std::string names;
  for (size_t i = 0; i < heat.classes.size(); ++i) {
    const auto& [name, color] = heat.classes[i];
    colors += fmt::format("{}{} {}", i == 0 ? "" : ", ", i, Quoted(color));
    names += fmt::format("{}{} {}", i == 0 ? "" : ", ", Quoted(name), i);
  }
  const auto count = heat.classes.size();
  return text +
         fmt::format("set palette defined ({}) maxcolors {}\nset cbrange [-0.5:{}.5]\nset cbtics ({})\n",
                     colors, count, count - 1, names);
}

std::string PanelCommands(const Panel& panel, size_t number) {
  std::string text = fmt::format("set title {}\nset xlabel {}\nset ylabel {}\nset xrange {}\nset yrange {}\n",
                                 Quoted(panel.title), Quoted(panel.x_label), Quoted(panel.y_label),
                                 Range(panel.x_range), Range(panel.y_range));
  text += PanelObjects(panel);
  text += panel.equal_axes ? "set size ratio -1\n" : "set size noratio\n";
  std::string bands;
  std::string marks;
  if (panel.heat) {
    text += HeatCommands(*panel.heat, number, bands);
  } else {
    text += "unset colorbox\n";
  }
  for (size_t s = 0; s < panel.series.size(); ++s) {
    const PlotSeries& series = panel.series[s];
    if (!HasValue(series)) continue;
    const std::string data = fmt::format("$d{}_{}", number, s);
    const std::string color =
        kPalette[static_cast<size_t>(series.color < 0 ? static_cast<int>(s) : series.color) %
                 kPalette.size()];
    const std::string title = series.name.empty() ? "notitle" : "title " + Quoted(series.name);
    const bool interval = !series.low.empty();
    if (interval && series.style == PlotSeries::Style::kLine) {
      bands += fmt::format(
          "{} using 1:3:4 with filledcurves fc rgb '{}' fs transparent solid 0.18 noborder "
          "notitle, ",
          data, color);
    }
    if (interval && series.style != PlotSeries::Style::kLine) {
      marks += fmt::format("{} using 1:2:3:4 with yerrorbars lc rgb '{}' lw 1.6 pt 7 ps 0.9 {}, ", data,
                           color, series.style == PlotSeries::Style::kPoints ? title : "notitle");
    }
    if (series.style != PlotSeries::Style::kPoints) {
      marks += fmt::format("{} using 1:2 with {} lc rgb '{}' lw 2 pt 7 ps 0.7 {}, ", data,
                           series.style == PlotSeries::Style::kLine ? "lines" : "linespoints", color, title);
    } else if (!interval) {
      marks += fmt::format("{} using 1:2 with points lc rgb '{}' pt 7 ps 0.9 {}, ", data, color, title);
    }
  }
  const std::string all = bands + marks;
  // Nothing to show: empty axes, on which a line beyond the range leaves no mark.
  if (all.empty() && !panel.polygons.empty()) return text + "plot NaN notitle\n";
  if (all.empty()) return text + "set xrange [0:1]\nset yrange [0:1]\nplot 2 notitle\n";
  return text + "plot " + all.substr(0, all.size() - 2) + "\n";
}

std::string Script(const Figure& figure, const std::string& terminal, const fs::path& output) {
  const int columns = std::max(1, std::min<int>(figure.columns, static_cast<int>(figure.panels.size())));
  const int rows = (static_cast<int>(figure.panels.size()) + columns - 1) / columns;
  std::string text = fmt::format(
      "set terminal {} size {},{} font 'Helvetica,12' noenhanced\nset output {}\nset encoding utf8\n",
      terminal, columns * figure.panel_width_px, rows * figure.panel_height_px, Quoted(output.string()));
  text +=
      "set border 3 lc rgb '#555555'\nset tics nomirror out textcolor rgb '#333333'\n"
      "set grid lc rgb '#dddddd' lw 0.7\nset key outside right top vertical samplen 1.5 spacing 1.15\n"
      "set bars 0.6\nset style fill noborder\n";
  for (size_t p = 0; p < figure.panels.size(); ++p) text += DataBlocks(figure.panels[p], p);
  if (figure.panels.size() > 1) text += fmt::format("set multiplot layout {},{}\n", rows, columns);
  for (size_t p = 0; p < figure.panels.size(); ++p) text += PanelCommands(figure.panels[p], p);
  return text;
}

// Runs gnuplot on a script; its own words if it fails.
Status RunGnuplot(const fs::path& script, const fs::path& messages) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, messages.c_str(), O_WRONLY | O_CREAT | O_TRUNC,
                                   0600);
  std::string program = "gnuplot";
  std::string argument = script.string();
  std::array<char*, 3> argv = {program.data(), argument.data(), nullptr};
  pid_t child = 0;
  const int started = posix_spawnp(&child, "gnuplot", &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (started != 0) {
    return Error{ErrorKind::kIo, "gnuplot could not be started (" + std::system_category().message(started) +
                                     "): install the package gnuplot-nox"};
  }
  int status = 0;
  waitpid(child, &status, 0);
  std::ostringstream said;
  said << std::ifstream(messages).rdbuf();
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    return Error{ErrorKind::kIo, "gnuplot failed: " + said.str().substr(0, 300)};
  }
  return Ok{};
}

void ReplaceAll(std::string& text, std::string_view from, std::string_view to) {
  for (size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
}

// Takes out every <name>...</name>.
void Remove(std::string& text, std::string_view name) {
  const std::string begin = fmt::format("<{}>", name);
  const std::string end = fmt::format("</{}>", name);
  for (size_t at = text.find(begin); at != std::string::npos; at = text.find(begin, at)) {
    const size_t stop = text.find(end, at);
    if (stop == std::string::npos) return;
    text.erase(at, stop + end.size() - at);
  }
}

// gnuplot's own titles ("$d0_0 using 1:2") would show up as tooltips, and its ids repeat from figure to
// figure.
std::string SvgForPage(std::string svg, const std::string& id, const std::string& title) {
  svg.erase(0, svg.find("<svg"));
  Remove(svg, "title");
  Remove(svg, "desc");
  ReplaceAll(svg, " id='", " id='" + id + "_");
  ReplaceAll(svg, " id=\"", " id=\"" + id + "_");
  ReplaceAll(svg, "href='#", "href='#" + id + "_");
  ReplaceAll(svg, "url(#", "url(#" + id + "_");
  ReplaceAll(svg, "xlink:href=", "href=");
  ReplaceAll(svg, "<image ", "<image style='image-rendering:pixelated' ");
  ReplaceAll(svg, " xmlns:xlink=\"http://www.w3.org/1999/xlink\"", "");
  ReplaceAll(svg, " xmlns=\"http://www.w3.org/2000/svg\"", "");
  svg.replace(0, 4, fmt::format("<svg role=\"img\" aria-label=\"{}\"", XmlText(title)));
  return svg;
}

Status Check(const Figure& figure) {
  if (figure.panels.empty()) return Error{ErrorKind::kBadInput, "a figure needs at least one panel"};
  for (const Panel& panel : figure.panels) {
    for (const PlotPolygon& polygon : panel.polygons) {
      if (!polygon.x.empty() && polygon.x.size() == polygon.y.size() && panel.x_range && panel.y_range)
        continue;
      return Error{ErrorKind::kBadInput, "a polygon needs as many x as y, and a panel with both ranges"};
    }
    if (panel.heat) {
      const PlotHeat& heat = *panel.heat;
      const auto cells = static_cast<size_t>(std::max(0, heat.rows) * std::max(0, heat.columns));
      if (cells == 0 || heat.values.size() != cells ||
          (!heat.hatched.empty() && heat.hatched.size() != cells)) {
        return Error{ErrorKind::kBadInput,
                     fmt::format("a map of {} by {} cells has {} values, expected one per cell", heat.rows,
                                 heat.columns, heat.values.size())};
      }
    }
    for (const PlotSeries& s : panel.series) {
      const bool bars = s.low.empty() && s.high.empty();
      if (s.x.size() == s.y.size() && (bars || (s.low.size() == s.x.size() && s.high.size() == s.x.size())))
        continue;
      return Error{ErrorKind::kBadInput,
                   fmt::format("series '{}': {} x, {} y, {} low and {} high values, expected as many of each",
                               s.name, s.x.size(), s.y.size(), s.low.size(), s.high.size())};
    }
  }
  return Ok{};
}

}  // namespace

Status DrawFigure(const Figure& figure, const fs::path& file) {
  const std::string extension = file.extension().string();
  if (extension != ".svg" && extension != ".png") {
    return Error{ErrorKind::kBadInput,
                 fmt::format("{}: a plot's name ends in .svg or .png, not '{}'", file.string(), extension)};
  }
  if (Status checked = Check(figure); !checked.ok()) return std::move(checked).error().Within(file.string());

  std::string scratch = (fs::absolute(file).parent_path() / ".tendril-plot-XXXXXX").string();
  if (mkdtemp(scratch.data()) == nullptr) {
    return Error{ErrorKind::kIo, fmt::format("{}: cannot write in that folder ({})", file.string(),
                                             std::system_category().message(errno))};
  }
  const fs::path folder = scratch;
  const fs::path drawn = folder / ("figure" + extension);
  {
    std::ofstream script(folder / "script.gp");
    script << Script(figure, extension == ".svg" ? "svg background rgb 'white'" : "pngcairo", drawn);
  }
  Status done = RunGnuplot(folder / "script.gp", folder / "messages");
  std::error_code failed;
  if (done.ok()) {
    fs::rename(drawn, file, failed);
    if (failed) done = Error{ErrorKind::kIo, failed.message()};
  }
  fs::remove_all(folder, failed);
  return done.ok() ? Status(Ok{}) : std::move(done).error().Within(file.string());
}

Result<std::string> FigureForPage(const Figure& figure, const std::string& id, const std::string& title) {
  std::error_code failed;
  std::string scratch = (fs::temp_directory_path(failed) / "tendril-figure-XXXXXX").string();
  if (failed || mkdtemp(scratch.data()) == nullptr) {
    return Error{ErrorKind::kIo, "no folder for temporary files to draw in; TMPDIR can name one"};
  }
  const fs::path file = fs::path(scratch) / "figure.svg";
  Result<std::string> page = std::string();
  if (Status drawn = DrawFigure(figure, file); drawn.ok()) {
    page = ReadText(file);
    if (page.ok()) page = SvgForPage(page.value(), id, title);
  } else {
    page = drawn.error();
  }
  fs::remove_all(scratch, failed);
  return page;
}

}  // namespace tendril
