#include "capture/rig/tag_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "capture/rig/tag_family.h"

namespace tendril {
namespace {

std::string Escaped(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '&') {
      safe += "&amp;";
    } else if (c == '<') {
      safe += "&lt;";
    } else if (static_cast<unsigned char>(c) >= 32) {
      safe += c;
    }
  }
  return safe;
}

// The black cells as one path; a run of cells in a row is one rectangle.
std::string BlackCells(const TagPattern& pattern, double left, double top, double module) {
  std::string path;
  for (Eigen::Index row = 0; row < pattern.rows(); ++row) {
    for (Eigen::Index column = 0; column < pattern.cols();) {
      Eigen::Index end = column;
      while (end < pattern.cols() && pattern(row, end) < 128) ++end;
      if (end > column) {
        const double width = static_cast<double>(end - column) * module;
        path +=
            fmt::format("M{:.4f} {:.4f}h{:.4f}v{:.4f}h{:.4f}z", left + static_cast<double>(column) * module,
                        top + static_cast<double>(row) * module, width, module, -width);
      }
      column = end + 1;
    }
  }
  return path;
}

std::string Text(double x, double y, double size, const char* anchor, const std::string& text) {
  return fmt::format("<text x=\"{:.3f}\" y=\"{:.3f}\" font-size=\"{}\" text-anchor=\"{}\">{}</text>\n", x, y,
                     size, anchor, Escaped(text));
}

}  // namespace

Result<std::vector<std::string>> TagSheet(const TagLayout& layout, const TagSheetOptions& options) {
  // Millimetres from here on.
  const double page_width = 1e3 * options.page_width;
  const double page_height = 1e3 * options.page_height;
  const double margin = 1e3 * options.margin;
  constexpr double kHead = 16;       // title and scale bar
  constexpr double kLabel = 5.5;     // two lines below a tag
  constexpr double kGap = 3;         // room to cut
  constexpr double kNarrowest = 11;  // a label's width
  double largest = 0;
  for (const TagPlace& tag : layout.tags) largest = std::max(largest, 1e3 * tag.footprint);
  const double cell_width = std::max(kNarrowest, largest + kGap);
  const double cell_height = largest + kLabel + kGap;
  const int columns = static_cast<int>((page_width - 2 * margin) / cell_width);
  const int rows = static_cast<int>((page_height - 2 * margin - kHead) / cell_height);
  if (columns < 1 || rows < 1) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("a tag of {:.4g} mm does not fit a page of {:.4g} x {:.4g} mm", largest,
                             page_width, page_height)};
  }
  const size_t per_page = static_cast<size_t>(columns) * static_cast<size_t>(rows);
  const size_t pages = std::max<size_t>(1, (layout.tags.size() + per_page - 1) / per_page);
  std::vector<std::string> sheets;
  for (size_t page = 0; page < pages; ++page) {
    std::string svg = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}mm\" height=\"{1}mm\" viewBox=\"0 0 {0} {1}\" "
        "font-family=\"sans-serif\">\n<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n",
        page_width, page_height);
    svg += Text(margin, margin + 3, 3.2, "start",
                fmt::format("{}{}{}, tags of {:.4g} mm with their white ring, page {} of {}", options.title,
                            options.title.empty() ? "" : ": ", layout.family, largest, page + 1, pages));
    const double bar = margin + 8;
    svg += fmt::format(
        "<path d=\"M{0:.3f} {1:.3f}h100m-100 -1.5v3m50 -2v1m50 -2v3\" stroke=\"black\" "
        "stroke-width=\"0.2\" fill=\"none\"/>\n",
        margin, bar);
    svg += Text(margin + 102, bar + 1, 2.6, "start", "100 mm when printed at 100 %");
    for (size_t i = page * per_page; i < std::min(layout.tags.size(), (page + 1) * per_page); ++i) {
      const TagPlace& tag = layout.tags[i];
      const auto pattern = PatternOf(layout.family, tag.id);
      if (!pattern.ok()) return pattern.error();
      const size_t on_page = i - page * per_page;
      const double side = 1e3 * tag.footprint;
      const double cell = margin + cell_width * static_cast<double>(on_page % static_cast<size_t>(columns));
      const double left = cell + 0.5 * (cell_width - side);
      const size_t row = on_page / static_cast<size_t>(columns);
      const double top = margin + kHead + cell_height * static_cast<double>(row);
      // The outline to cut along lies just outside of the printed side.
      svg += fmt::format(
          "<rect x=\"{0:.4f}\" y=\"{1:.4f}\" width=\"{2:.4f}\" height=\"{2:.4f}\" fill=\"none\" "
          "stroke=\"#c0c0c0\" stroke-width=\"0.1\"/>\n",
          left - 0.05, top - 0.05, side + 0.1);
      svg += fmt::format(
          "<path d=\"{}\" fill=\"black\" shape-rendering=\"crispEdges\"/>\n",
          BlackCells(pattern.value(), left, top, side / static_cast<double>(pattern.value().rows())));
      svg += Text(cell + 0.5 * cell_width, top + side + 2.4, 2.0, "middle", fmt::format("{}", tag.id));
      svg += Text(
          cell + 0.5 * cell_width, top + side + 4.5, 1.6, "middle",
          fmt::format("t{} f{} {}", tag.tentacle, tag.facet, tag.side == TagSide::kOuter ? "out" : "in"));
    }
    sheets.push_back(svg + "</svg>\n");
  }
  return sheets;
}

}  // namespace tendril
