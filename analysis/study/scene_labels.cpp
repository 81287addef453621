#include "analysis/study/scene_labels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "analysis/study/scene_backdrop.h"
#include "analysis/study/scene_picture.h"

namespace tendril {
namespace {

constexpr double kColumn = 0.235;  // of the width
constexpr double kMargin = 0.034;  // of the height
constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kCapital = 21;  // height of the font's capitals at scale 1, px
constexpr int kFine = 4;  // letters are drawn this much larger and then shrunk: OpenCV's strokes are whole px
const cv::Scalar kInk(66, 52, 44);

double ScaleOf(double size_px) { return kFine * size_px / kCapital; }

int WidthOf(const std::string& text, double size_px) {
  int base = 0;
  const cv::Size size = cv::getTextSize(text, kFont, ScaleOf(size_px), 1, &base);
  return size.width / kFine + 3 + static_cast<int>(0.3 * size_px);
}

// OpenCV's fonts are ASCII.
std::string Ascii(const std::string& text) {
  std::string plain;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if ((byte & 0xC0U) == 0x80U) continue;  // goes on with a character that has its "?"
    plain += byte >= 0x20 && byte < 0x7F ? c : byte < 0x20 ? ' ' : '?';
  }
  return plain;
}

std::string Cut(std::string text, double size_px, int width) {
  if (WidthOf(text, size_px) <= width) return text;
  while (!text.empty() && WidthOf(text + "...", size_px) > width) text.pop_back();
  return text + "...";
}

std::vector<std::string> Broken(const std::string& text, double size_px, int width, std::size_t most) {
  std::vector<std::string> rows;
  std::istringstream words(Ascii(text));
  std::string word, row;
  while (words >> word) {
    std::string longer = row;
    if (!row.empty()) longer += ' ';
    longer += word;
    if (row.empty() || WidthOf(longer, size_px) <= width || rows.size() + 1 == most) {
      row = longer;
    } else {
      rows.push_back(Cut(row, size_px, width));
      row = word;
    }
  }
  if (!row.empty()) rows.push_back(Cut(row, size_px, width));
  return rows;
}

std::string LengthText(double length) {
  if (length >= 0.9995) return fmt::format("{:.4g} m", length);
  if (length >= 0.9995e-3) return fmt::format("{:.4g} mm", 1e3 * length);
  return fmt::format("{:.4g} um", 1e6 * length);
}

// Fills a column from both ends.
struct Column {
  int left, width, top, bottom;  // px; free: [top, bottom)
  std::vector<SceneLabel> labels;

  // Height of a row; with room for what hangs below the line.
  static int RowOf(double size_px) { return static_cast<int>(std::ceil(1.75 * size_px)); }

  bool Add(SceneLabel label, int height, int indent, bool from_below) {
    if (top + height > bottom) return false;
    const int y = from_below ? bottom - height : top;
    (from_below ? bottom : top) += from_below ? -height : height;
    label.box = {left, y, std::min(width, indent + WidthOf(label.text, label.size_px)), height};
    if (label.kind == SceneLabel::Kind::kBar) {
      label.box.width = std::clamp(static_cast<int>(std::ceil(label.bar_px)) + 2, label.box.width, width);
    }
    labels.push_back(std::move(label));
    return true;
  }

  void Leave(int height, bool from_below) {
    const int gap = std::max(0, std::min(height, bottom - top));
    (from_below ? bottom : top) += from_below ? -gap : gap;
  }
};

void DrawText(const SceneLabel& label, const cv::Point& baseline, cv::Mat& part) {
  const double stroke = label.kind == SceneLabel::Kind::kTitle ? 0.155 : 0.115;  // of the capitals' height
  const int thick = std::max(1, static_cast<int>(std::lround(kFine * label.size_px * stroke)));
  cv::Mat fine(part.rows * kFine, part.cols * kFine, CV_8UC1, cv::Scalar(0)), mask;
  cv::putText(fine, label.text, kFine * baseline, kFont, ScaleOf(label.size_px), cv::Scalar(255), thick,
              cv::LINE_AA);
  cv::resize(fine, mask, part.size(), 0, 0, cv::INTER_AREA);
  for (int y = 0; y < part.rows; ++y) {
    for (int x = 0; x < part.cols; ++x) {
      const int share = mask.at<std::uint8_t>(y, x);
      auto& pixel = part.at<cv::Vec3b>(y, x);
      for (int k = 0; k < 3; ++k) {
        pixel[k] = static_cast<std::uint8_t>((pixel[k] * (255 - share) + kInk[k] * share) / 255);
      }
    }
  }
}

}  // namespace

PictureRoom RoomBesideLabels(int width_px, int height_px) {
  const double margin = 1.3 * kMargin * height_px;
  return {
      .left = kColumn * width_px, .right = width_px - margin, .top = margin, .bottom = height_px - margin};
}

std::vector<SceneLabel> LayOutLabels(const ScenePicture& picture, const SceneView& view,
                                     const std::vector<std::string>& names,
                                     const std::vector<cv::Scalar>& colors, double grid_step) {
  // Letters grow with the picture, by the side that is shorter against 16:9.
  const double unit = std::min(view.height_px / 720.0, view.width_px / 1280.0);
  const int margin = static_cast<int>(kMargin * view.height_px);
  Column column{.left = margin,
                .width = static_cast<int>(kColumn * view.width_px) - margin,
                .top = margin,
                .bottom = view.height_px - margin,
                .labels = {}};
  if (column.width <= 0) return {};
  const double large = 18 * unit, middle = 14 * unit, small = 11.5 * unit;
  using Kind = SceneLabel::Kind;
  for (const std::string& row : Broken(picture.title, large, column.width, 3)) {
    column.Add({.kind = Kind::kTitle, .text = row, .size_px = large}, Column::RowOf(large), 0, false);
  }
  column.Leave(static_cast<int>(6 * unit), false);
  if (std::isfinite(picture.time)) {
    column.Add(
        {.text = Cut(fmt::format("t = {:.2f} s", picture.time), middle, column.width), .size_px = middle},
        Column::RowOf(middle), 0, false);
  }

  for (const std::string& row : Broken(picture.phase, middle, column.width, 2)) {
    column.Add({.text = row, .size_px = middle}, Column::RowOf(middle), 0, false);
  }

  const double depth = DepthOf(view, view.subject);
  if (depth > 0) {
    column.Add({.text = Cut((view.floor_is_table ? "table's grid " : "floor's grid ") + LengthText(grid_step),
                            small, column.width),
                .size_px = small},
               Column::RowOf(small), 0, true);
    const double px_per_m = view.focal_px / depth;
    const double length = RoundLength(0.72 * column.width / px_per_m);
    column.Add({.kind = Kind::kBar,
                .text = Cut(LengthText(length), small, column.width),
                .size_px = small,
                .bar_px = length * px_per_m},
               Column::RowOf(small) + static_cast<int>(10 * unit), 0, true);
    column.Leave(static_cast<int>(14 * unit), true);
  }
  if (names.size() >= 2 && names.size() <= 12) {
    const int indent = static_cast<int>(2.0 * small);
    for (std::size_t i = names.size(); i-- > 0;) {
      column.Add({.kind = Kind::kSwatch,
                  .text = Cut(Ascii(names[i]), small, column.width - indent),
                  .size_px = small,
                  .color = colors[i]},
                 Column::RowOf(small), indent, true);
    }
    column.Leave(static_cast<int>(10 * unit), true);
  }
  column.Leave(static_cast<int>(4 * unit), false);
  for (const std::string& line : picture.lines) {
    for (const std::string& row : Broken(line, small, column.width, 2)) {
      column.Add({.text = row, .size_px = small}, Column::RowOf(small), 0, false);
    }
  }
  return column.labels;
}

void DrawLabels(const std::vector<SceneLabel>& labels, cv::Mat& picture) {
  constexpr int kShift = 4;  // fractional bits of OpenCV's drawing coordinates
  for (const SceneLabel& label : labels) {
    const cv::Rect inside = label.box & cv::Rect(0, 0, picture.cols, picture.rows);
    if (inside.empty()) continue;
    cv::Mat part = picture(inside);  // nothing is drawn outside
    const double size = label.size_px;
    // Half a stroke lies to the left of where a letter begins.
    cv::Point baseline(static_cast<int>(std::ceil(0.08 * size)), static_cast<int>(std::lround(1.3 * size)));
    if (label.kind == SceneLabel::Kind::kSwatch) {
      const cv::Point center(static_cast<int>(0.62 * size * (1 << kShift)),
                             static_cast<int>((baseline.y - 0.5 * size) * (1 << kShift)));
      cv::circle(part, center, static_cast<int>(0.55 * size * (1 << kShift)), label.color, cv::FILLED,
                 cv::LINE_AA, kShift);
      baseline.x += static_cast<int>(2.0 * size);
    }
    if (label.kind == SceneLabel::Kind::kBar) {
      // A flat bar with feet at its ends.
      const int thick = std::max(1, static_cast<int>(std::lround(0.18 * size)));
      const int right = static_cast<int>(std::lround(label.bar_px));
      const int foot = static_cast<int>(std::lround(0.7 * size));
      cv::rectangle(part, {0, 0, right, thick}, kInk, cv::FILLED);
      cv::rectangle(part, {0, 0, thick, foot}, kInk, cv::FILLED);
      cv::rectangle(part, {right - thick, 0, thick, foot}, kInk, cv::FILLED);
      baseline.y = part.rows - static_cast<int>(std::lround(0.45 * size));
    }
    DrawText(label, baseline, part);
  }
}

}  // namespace tendril
