#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "calibrate/cameras/projection_uncertainty.h"

namespace tendril {
namespace {

constexpr int kPanelWidth = 560;
constexpr int kMargin = 16;
constexpr int kTitle = 34;
constexpr int kScale = 90;
constexpr double kLeast = 0.003;  // px; the scale's ends
constexpr double kMost = 10;

double Shade(double sigma_px) {
  return std::clamp(std::log(sigma_px / kLeast) / std::log(kMost / kLeast), 0.0, 1.0);
}

void Write(cv::Mat& picture, const std::string& text, const cv::Point& at, double size = 0.5) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, size, {30, 30, 30}, 1, cv::LINE_AA);
}

cv::Mat Colored(const cv::Mat& shade) {
  cv::Mat color;
  cv::applyColorMap(shade, color, cv::COLORMAP_VIRIDIS);
  return color;
}

cv::Mat Panel(const UncertaintyPanel& panel, int height) {
  const Eigen::MatrixXd& sigma = panel.uncertainty.sigma_px;
  cv::Mat log_sigma(static_cast<int>(sigma.rows()), static_cast<int>(sigma.cols()), CV_32F);
  for (int r = 0; r < log_sigma.rows; ++r) {
    for (int c = 0; c < log_sigma.cols; ++c) {
      const double s = sigma(r, c);
      log_sigma.at<float>(r, c) = static_cast<float>(std::isfinite(s) ? Shade(s) : 1.0);
    }
  }
  cv::Mat smooth;
  cv::resize(log_sigma, smooth, {kPanelWidth, height}, 0, 0, cv::INTER_LINEAR);
  cv::Mat shade;
  smooth.convertTo(shade, CV_8U, 255);
  cv::Mat color = Colored(shade);
  const double scale = static_cast<double>(kPanelWidth) / panel.width_px;
  for (const Eigen::Vector2d& p : panel.corners_px) {
    cv::circle(color, {static_cast<int>((p.x() + 0.5) * scale), static_cast<int>((p.y() + 0.5) * scale)}, 1,
               {255, 255, 255}, cv::FILLED, cv::LINE_AA);
  }
  for (const double level : {0.01, 0.03, 0.1, 0.3, 1.0, 3.0}) {
    cv::Mat above = smooth > Shade(level);
    std::vector<std::vector<cv::Point>> lines;
    cv::findContours(above, lines, cv::RETR_LIST, cv::CHAIN_APPROX_NONE);
    for (const auto& line : lines) {
      int labels = 0;
      for (size_t i = 1; i < line.size(); ++i) {
        const auto rim = [&](const cv::Point& p) {
          return p.x < 2 || p.y < 2 || p.x > color.cols - 3 || p.y > color.rows - 3;
        };
        if (rim(line[i]) || rim(line[i - 1])) continue;
        cv::line(color, line[i - 1], line[i], {40, 40, 40}, 1, cv::LINE_AA);
        if (labels++ == 20) {
          const std::string label = fmt::format("{:g}", level);
          int below = 0;
          const cv::Size size = cv::getTextSize(label, cv::FONT_HERSHEY_SIMPLEX, 0.5, 3, &below);
          // Whole within the picture.
          const cv::Point at(
              std::clamp(line[i].x, 2, std::max(2, color.cols - size.width - 2)),
              std::clamp(line[i].y, size.height + 2, std::max(size.height + 2, color.rows - 4)));
          cv::putText(color, label, at, cv::FONT_HERSHEY_SIMPLEX, 0.5, {0, 0, 0}, 3, cv::LINE_AA);
          cv::putText(color, label, at, cv::FONT_HERSHEY_SIMPLEX, 0.5, {255, 255, 255}, 1, cv::LINE_AA);
        }
      }
    }
  }
  return color;
}

}  // namespace

cv::Mat DrawUncertainty(const std::vector<UncertaintyPanel>& panels) {
  const int across = std::max(1, std::min(2, static_cast<int>(panels.size())));
  const int down = std::max(1, (static_cast<int>(panels.size()) + across - 1) / across);
  int tallest = 100;
  for (const UncertaintyPanel& p : panels) {
    tallest = std::max(tallest, static_cast<int>(std::lround(1.0 * kPanelWidth * p.height_px / p.width_px)));
  }
  cv::Mat picture(down * (tallest + kTitle + kMargin) + kMargin,
                  across * (kPanelWidth + kMargin) + kMargin + kScale, CV_8UC3, cv::Scalar(255, 255, 255));
  for (size_t i = 0; i < panels.size(); ++i) {
    const UncertaintyPanel& p = panels[i];
    const int height = static_cast<int>(std::lround(1.0 * kPanelWidth * p.height_px / p.width_px));
    const int x = kMargin + static_cast<int>(i) % across * (kPanelWidth + kMargin);
    const int y = kMargin + static_cast<int>(i) / across * (tallest + kTitle + kMargin);
    Write(picture,
          fmt::format("{}: median {:.2g} px, largest {:.2g} px (one sigma)", p.title, p.uncertainty.median_px,
                      p.uncertainty.largest_px),
          {x, y + 22});
    Panel(p, height).copyTo(picture(cv::Rect(x, y + kTitle, kPanelWidth, height)));
  }
  const int x = picture.cols - kScale;
  const int top = kMargin + kTitle;
  const int length = tallest - 1;
  cv::Mat ramp(length, 1, CV_8U);
  for (int i = 0; i < length; ++i) ramp.at<uchar>(i) = static_cast<uchar>(255 - 255 * i / (length - 1));
  cv::Mat bar;
  cv::resize(Colored(ramp), bar, {20, length}, 0, 0, cv::INTER_NEAREST);
  bar.copyTo(picture(cv::Rect(x, top, 20, length)));
  for (const double level : {0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0}) {
    const int y = top + static_cast<int>(std::lround((1 - Shade(level)) * (length - 1)));
    cv::line(picture, {x + 20, y}, {x + 25, y}, {30, 30, 30}, 1);
    Write(picture, fmt::format("{:g}", level), {x + 29, y + 5}, 0.45);
  }
  Write(picture, "px", {x + 4, top - 8});
  return picture;
}

}  // namespace tendril
