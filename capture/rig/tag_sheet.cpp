#include "capture/rig/tag_sheet.h"

#include <cairo/cairo-pdf.h>
#include <cairo/cairo-svg.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>

#include "capture/rig/tag_family.h"

namespace tendril {
namespace {

constexpr double kPointsPerMm = 72 / 25.4;

// Where things go, in mm from the page's top left.
struct Grid {
  double width = 0, height = 0, margin = 0;
  double largest = 0;  // footprint
  double cell_width = 0, cell_height = 0;
  size_t columns = 0, rows = 0;
  bool alike = true;  // all tags have one size
  size_t pages = 1;

  static constexpr double kHead = 20;       // title, what to do, scale bar
  static constexpr double kLabel = 5.5;     // two lines below a tag
  static constexpr double kGap = 3;         // room to cut
  static constexpr double kNarrowest = 11;  // a label's width

  size_t per_page() const { return columns * rows; }
  double CenterX(size_t column) const { return margin + cell_width * (static_cast<double>(column) + 0.5); }
  double Top(size_t row) const { return margin + kHead + cell_height * static_cast<double>(row); }
};

Result<Grid> GridOf(const TagLayout& layout, const TagSheetOptions& options) {
  Grid grid{
      .width = 1e3 * options.page_width, .height = 1e3 * options.page_height, .margin = 1e3 * options.margin};
  for (const TagPlace& tag : layout.tags) {
    grid.largest = std::max(grid.largest, 1e3 * tag.footprint);
    grid.alike = grid.alike && std::abs(tag.footprint - layout.tags.front().footprint) < 1e-9;
  }
  grid.cell_width = std::max(Grid::kNarrowest, grid.largest + Grid::kGap);
  grid.cell_height = grid.largest + Grid::kLabel + Grid::kGap;
  const double columns = (grid.width - 2 * grid.margin) / grid.cell_width;
  const double rows = (grid.height - 2 * grid.margin - Grid::kHead) / grid.cell_height;
  if (columns < 1 || rows < 1) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("a tag of {:.4g} mm does not fit a page of {:.4g} x {:.4g} mm", grid.largest,
                             grid.width, grid.height)};
  }
  grid.columns = static_cast<size_t>(columns);
  grid.rows = static_cast<size_t>(rows);
  grid.pages = std::max<size_t>(1, (layout.tags.size() + grid.per_page() - 1) / grid.per_page());
  return grid;
}

enum class Anchor { kLeft, kMiddle };

void Text(cairo_t* cr, double x, double y, double size, Anchor anchor, const std::string& text) {
  cairo_set_source_rgb(cr, 0, 0, 0);
  cairo_set_font_size(cr, size);
  if (anchor == Anchor::kMiddle) {
    cairo_text_extents_t extents;
    cairo_text_extents(cr, text.c_str(), &extents);
    x -= 0.5 * extents.x_advance;
  }
  cairo_move_to(cr, x, y);
  cairo_show_text(cr, text.c_str());
}

void Line(cairo_t* cr, double x0, double y0, double x1, double y1) {
  cairo_move_to(cr, x0, y0);
  cairo_line_to(cr, x1, y1);
}

// 100 mm with ends and a middle, from a point along x or y; the ends' outer edges are 100 mm apart.
void ScaleBar(cairo_t* cr, double x, double y, bool down) {
  cairo_save(cr);
  cairo_translate(cr, x, y);
  if (down) cairo_rotate(cr, 0.5 * std::numbers::pi);
  constexpr double kWidth = 0.2;
  Line(cr, 0, 0, 100, 0);
  for (const double at : {0.5 * kWidth, 50.0, 100 - 0.5 * kWidth}) {
    const double half = at == 50 ? 0.8 : 1.5;
    Line(cr, at, -half, at, half);
  }
  cairo_set_source_rgb(cr, 0, 0, 0);
  cairo_set_line_width(cr, kWidth);
  cairo_stroke(cr);
  cairo_restore(cr);
}

// The black cells as one path, so that a viewer's smoothing leaves no seams; a run in a row is one rectangle.
void BlackCells(cairo_t* cr, const TagPattern& pattern, double left, double top, double module) {
  for (Eigen::Index row = 0; row < pattern.rows(); ++row) {
    for (Eigen::Index column = 0; column < pattern.cols();) {
      Eigen::Index end = column;
      while (end < pattern.cols() && pattern(row, end) < 128) ++end;
      if (end > column) {
        cairo_rectangle(cr, left + static_cast<double>(column) * module,
                        top + static_cast<double>(row) * module, static_cast<double>(end - column) * module,
                        module);
      }
      column = end + 1;
    }
  }
  cairo_set_source_rgb(cr, 0, 0, 0);
  cairo_fill(cr);
}

void Gray(cairo_t* cr) {
  cairo_set_source_rgb(cr, 0.7, 0.7, 0.7);
  cairo_set_line_width(cr, 0.1);
}

Status DrawTag(cairo_t* cr, const TagLayout& layout, const TagPlace& tag, double hole_diameter,
               double center_x, double top) {
  const auto pattern = PatternOf(layout.family, tag.id);
  if (!pattern.ok()) return pattern.error();
  const double side = 1e3 * tag.footprint;
  const double left = center_x - 0.5 * side;
  BlackCells(cr, pattern.value(), left, top, side / static_cast<double>(pattern.value().rows()));
  // The outline to cut along lies just outside of the printed side.
  cairo_rectangle(cr, left - 0.05, top - 0.05, side + 0.1, side + 0.1);
  Gray(cr);
  cairo_stroke(cr);
  if (tag.over_hole && hole_diameter > 0) {
    cairo_arc(cr, center_x, top + 0.5 * side, 500 * hole_diameter, 0, 2 * std::numbers::pi);
    cairo_stroke(cr);
  }
  Text(cr, center_x, top + side + 2.4, 2.1, Anchor::kMiddle, fmt::format("{}", tag.id));
  Text(cr, center_x, top + side + 4.5, 1.6, Anchor::kMiddle,
       fmt::format("t{} f{} {}", tag.tentacle, tag.facet, tag.side == TagSide::kOuter ? "out" : "in"));
  return Ok{};
}

// Marks at the rim that carry on the outlines of the first `count` tags' columns and rows.
void CutMarks(cairo_t* cr, const Grid& grid, size_t count) {
  const size_t columns = std::min(count, grid.columns);
  const size_t rows = (count + grid.columns - 1) / grid.columns;
  const double half = 0.5 * grid.largest + 0.05;
  const double first = grid.Top(0) - 1.0;
  const double last = grid.Top(rows - 1) + grid.largest + Grid::kLabel + 0.5;
  const double right = grid.CenterX(columns - 1) + 0.5 * grid.cell_width;
  for (size_t column = 0; column < columns; ++column) {
    for (const double x : {grid.CenterX(column) - half, grid.CenterX(column) + half}) {
      Line(cr, x, first - 2, x, first);
      Line(cr, x, last, x, last + 2);
    }
  }
  for (size_t row = 0; row < rows; ++row) {
    for (const double y : {grid.Top(row) - 0.05, grid.Top(row) + grid.largest + 0.05}) {
      Line(cr, grid.margin - 3, y, grid.margin - 1, y);
      Line(cr, right + 1, y, right + 3, y);
    }
  }
  Gray(cr);
  cairo_stroke(cr);
}

Status DrawPage(cairo_t* cr, const TagLayout& layout, const TagSheetOptions& options, const Grid& grid,
                size_t page) {
  cairo_save(cr);
  cairo_scale(cr, kPointsPerMm, kPointsPerMm);
  cairo_select_font_face(cr, "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  cairo_rectangle(cr, 0, 0, grid.width, grid.height);
  cairo_set_source_rgb(cr, 1, 1, 1);
  cairo_fill(cr);
  const size_t begin = page * grid.per_page();
  const size_t end = std::min(layout.tags.size(), begin + grid.per_page());
  const std::string size = grid.alike ? fmt::format("tags of {:.4g} mm", grid.largest)
                                      : fmt::format("tags of up to {:.4g} mm", grid.largest);
  Text(cr, grid.margin, grid.margin + 3, 3.2, Anchor::kLeft,
       fmt::format("{}{}{}, {} with their white ring, page {} of {}", options.title,
                   options.title.empty() ? "" : ": ", layout.family, size, page + 1, grid.pages));
  Text(cr, grid.margin, grid.margin + 7, 2.2, Anchor::kLeft,
       "Print at 100 %, not fitted to the page, on matt paper; both bars must measure 100 mm. Cut along the "
       "gray "
       "outlines: the white ring belongs to the tag.");
  Text(cr, grid.margin, grid.margin + 10, 2.2, Anchor::kLeft,
       "Below a tag: its id, then tentacle, facet (0 at the base) and side. Its top, away from the text, "
       "points to "
       "the tentacle's tip.");
  ScaleBar(cr, grid.margin, grid.margin + 13.5, false);
  Text(cr, grid.margin + 102, grid.margin + 14.3, 2.4, Anchor::kLeft, "100 mm");
  ScaleBar(cr, grid.width - 0.7 * grid.margin, grid.margin + Grid::kHead, true);
  if (grid.alike && end > begin) CutMarks(cr, grid, end - begin);
  for (size_t i = begin; i < end; ++i) {
    const size_t on_page = i - begin;
    if (Status drawn = DrawTag(cr, layout, layout.tags[i], options.hole_diameter,
                               grid.CenterX(on_page % grid.columns), grid.Top(on_page / grid.columns));
        !drawn.ok()) {
      return drawn;
    }
  }
  cairo_restore(cr);
  return Ok{};
}

cairo_status_t Append(void* text, const unsigned char* bytes, unsigned int count) {
  static_cast<std::string*>(text)->append(reinterpret_cast<const char*>(bytes), count);
  return CAIRO_STATUS_SUCCESS;
}

using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;

// Draws on a surface that writes to a string; the surface is done when this returns.
Status DrawOn(const Surface& surface, const std::function<Status(cairo_t*)>& draw) {
  const std::unique_ptr<cairo_t, decltype(&cairo_destroy)> cr(cairo_create(surface.get()), cairo_destroy);
  if (Status drawn = draw(cr.get()); !drawn.ok()) return drawn;
  cairo_status_t status = cairo_status(cr.get());
  cairo_surface_finish(surface.get());
  if (status == CAIRO_STATUS_SUCCESS) status = cairo_surface_status(surface.get());
  if (status == CAIRO_STATUS_SUCCESS) return Ok{};
  return Error{ErrorKind::kIo,
               fmt::format("the tag sheet cannot be drawn: {}", cairo_status_to_string(status))};
}

}  // namespace

Result<std::vector<std::string>> TagSheetSvg(const TagLayout& layout, const TagSheetOptions& options) {
  const auto grid = GridOf(layout, options);
  if (!grid.ok()) return grid.error();
  std::vector<std::string> sheets;
  for (size_t page = 0; page < grid.value().pages; ++page) {
    std::string text;
    const Surface surface(
        cairo_svg_surface_create_for_stream(Append, &text, kPointsPerMm * grid.value().width,
                                            kPointsPerMm * grid.value().height),
        cairo_surface_destroy);
    const Status drawn =
        DrawOn(surface, [&](cairo_t* cr) { return DrawPage(cr, layout, options, grid.value(), page); });
    if (!drawn.ok()) return drawn.error();
    sheets.push_back(std::move(text));
  }
  return sheets;
}

Result<std::string> TagSheetPdf(const TagLayout& layout, const TagSheetOptions& options) {
  const auto grid = GridOf(layout, options);
  if (!grid.ok()) return grid.error();
  std::string text;
  const Surface surface(cairo_pdf_surface_create_for_stream(Append, &text, kPointsPerMm * grid.value().width,
                                                            kPointsPerMm * grid.value().height),
                        cairo_surface_destroy);
  cairo_pdf_surface_set_metadata(surface.get(), CAIRO_PDF_METADATA_TITLE,
                                 (options.title.empty() ? "tags" : options.title + ": tags").c_str());
  const Status drawn = DrawOn(surface, [&](cairo_t* cr) -> Status {
    for (size_t page = 0; page < grid.value().pages; ++page) {
      if (Status s = DrawPage(cr, layout, options, grid.value(), page); !s.ok()) return s;
      cairo_show_page(cr);
    }
    return Ok{};
  });
  if (!drawn.ok()) return drawn.error();
  return text;
}

}  // namespace tendril
