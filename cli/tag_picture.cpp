#include "cli/tag_picture.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>
#include <vector>

#include "db/files/safe_file.h"

namespace tendril::cli {

cv::Mat DrawTags(const cv::Mat& gray, const std::vector<DrawnTag>& tags) {
  constexpr int kShift = 4;  // fractional bits of OpenCV's drawing coordinates
  const auto fixed = [](const Eigen::Vector2d& p) {
    return cv::Point(static_cast<int>(std::lround(p.x() * (1 << kShift))),
                     static_cast<int>(std::lround(p.y() * (1 << kShift))));
  };
  cv::Mat picture;
  cv::cvtColor(gray, picture, cv::COLOR_GRAY2BGR);
  const int thick = std::max(1, gray.cols / 800);
  for (const DrawnTag& tag : tags) {
    for (int i = 0; i < 4; ++i) {
      // The tag's lower edge in another colour shows which way is up.
      const cv::Scalar color = i == 0 ? cv::Scalar(0, 90, 255) : cv::Scalar(60, 220, 0);
      cv::line(picture, fixed(tag.corners_px.col(i)), fixed(tag.corners_px.col((i + 1) % 4)), color, thick,
               cv::LINE_AA, kShift);
    }
    const Eigen::Vector2d center = tag.corners_px.rowwise().mean();
    const std::string id = std::to_string(tag.id);
    const double scale = 0.5 * thick;
    int below = 0;
    const cv::Size size = cv::getTextSize(id, cv::FONT_HERSHEY_SIMPLEX, scale, thick, &below);
    const cv::Point at(static_cast<int>(center.x()) - size.width / 2,
                       static_cast<int>(center.y()) + size.height / 2);
    cv::putText(picture, id, at, cv::FONT_HERSHEY_SIMPLEX, scale, {0, 0, 0}, 3 * thick, cv::LINE_AA);
    cv::putText(picture, id, at, cv::FONT_HERSHEY_SIMPLEX, scale, {0, 230, 255}, thick, cv::LINE_AA);
  }
  return picture;
}

Status WritePicture(const cv::Mat& picture, const std::string& file) {
  std::vector<unsigned char> bytes;
  try {
    if (!cv::imencode(std::filesystem::path(file).extension().string(), picture, bytes)) {
      return Error{ErrorKind::kIo, file + ": the overlay cannot be written; expected .png or .jpg"};
    }
  } catch (const cv::Exception&) {
    return Error{ErrorKind::kIo, file + ": no format is known by this ending; expected .png or .jpg"};
  }
  const Status written = WriteText(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  if (!written.ok()) return Error{ErrorKind::kIo, written.error().message};
  return Ok{};
}

}  // namespace tendril::cli
