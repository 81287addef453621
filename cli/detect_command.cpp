// tendril detect: which tags single pictures show, and where.
#include "cli/detect_command.h"

#include <filesystem>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "capture/record/picture_file.h"
#include "capture/track/tag_detect.h"

namespace tendril::cli {
namespace {

struct DetectCall {
  std::vector<std::string> images;
  TagDetectOptions options{.threads = 2};
  bool library_corners = false;
  std::string overlay;
};

Status DrawOverlay(const cv::Mat& gray, const std::vector<TagDetection>& tags, const std::string& file) {
  constexpr int kShift = 4;  // fractional bits of OpenCV's drawing coordinates
  const auto fixed = [](const Eigen::Vector2d& p) {
    return cv::Point(static_cast<int>(std::lround(p.x() * (1 << kShift))),
                     static_cast<int>(std::lround(p.y() * (1 << kShift))));
  };
  try {
    cv::Mat picture;
    cv::cvtColor(gray, picture, cv::COLOR_GRAY2BGR);
    const int thick = std::max(1, gray.cols / 800);
    for (const TagDetection& tag : tags) {
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
    if (cv::imwrite(file, picture)) return Ok{};
  } catch (const cv::Exception& error) {
    return Error{ErrorKind::kIo, file + ": the overlay cannot be written (" + error.err + ")"};
  }
  return Error{ErrorKind::kIo, file + ": the overlay cannot be written; expected a folder that exists"};
}

Status RunDetect(const DetectCall& call, Output& out) {
  if (!call.overlay.empty() && call.images.size() != 1) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("--overlay with {} pictures; expected one picture", call.images.size())};
  }
  TagDetectOptions options = call.options;
  options.corners = call.library_corners ? TagCorners::kLibrary : TagCorners::kRefined;
  auto detector = TagDetector::Create(options);
  if (!detector.ok()) return detector.error();

  auto& images = out.fields()["images"] = nlohmann::ordered_json::array();
  for (const std::string& file : call.images) {
    const auto gray = ReadGrayPicture(file);
    if (!gray.ok()) return gray.error();
    const cv::Mat& picture = gray.value();
    const auto tags =
        detector.value().Detect({picture.data, picture.cols, picture.rows, static_cast<int>(picture.step)});
    if (!tags.ok()) return Error(tags.error()).Within(file);

    nlohmann::ordered_json listed = nlohmann::ordered_json::array();
    out.Print("{}: {} tag{}", file, tags.value().size(), tags.value().size() == 1 ? "" : "s");
    if (!tags.value().empty()) out.Print("   id  wrong bits  margin  center x    center y   side, px");
    for (const TagDetection& tag : tags.value()) {
      nlohmann::ordered_json corners = nlohmann::ordered_json::array();
      double side = 0;
      for (int i = 0; i < 4; ++i) {
        corners.push_back({tag.corners_px(0, i), tag.corners_px(1, i)});
        side += 0.25 * (tag.corners_px.col((i + 1) % 4) - tag.corners_px.col(i)).norm();
      }
      listed.push_back(
          {{"id", tag.id}, {"corners_px", corners}, {"hamming", tag.hamming}, {"margin", tag.margin}});
      const Eigen::Vector2d center = tag.corners_px.rowwise().mean();
      out.Print("{:5}  {:10}  {:6.1f}  {:8.2f}    {:8.2f}   {:8.2f}", tag.id, tag.hamming, tag.margin,
                center.x(), center.y(), side);
    }
    images.push_back({{"file", file}, {"tags", listed}});
    if (!call.overlay.empty()) {
      if (auto s = DrawOverlay(picture, tags.value(), call.overlay); !s.ok()) return s;
      out.fields()["overlay"] = call.overlay;
      out.Print("overlay: {}", call.overlay);
    }
  }
  return Ok{};
}

}  // namespace

Command MakeDetectCommand() {
  auto call = std::make_shared<DetectCall>();
  return {
      .path = "detect",
      .help = "find AprilTags in pictures",
      .example = "tendril detect photo.png --family tag36h11 --overlay seen.png",
      .declare =
          [call](CLI::App& app) {
            app.add_option("images", call->images, "pictures (PNG, JPEG, ...)")->required();
            app.add_option("--family", call->options.family, "tag family (name)")->capture_default_str();
            app.add_option("--decimate", call->options.decimate,
                           "search in a picture this many times smaller (factor)")
                ->capture_default_str();
            app.add_option("--contrast", call->options.min_white_black_diff,
                           "smallest contrast of an edge (gray levels, 0 to 255)")
                ->capture_default_str();
            app.add_option("--max-hamming", call->options.max_hamming,
                           "code bits that may be wrong (bits, 0 to 2)")
                ->capture_default_str();
            app.add_option("--threads", call->options.threads, "threads (count)")->capture_default_str();
            app.add_flag("--library-corners", call->library_corners,
                         "corners exactly as libapriltag finds them, without the fit of the border's edges");
            app.add_flag("--refine-edges", call->options.refine_edges,
                         "take libapriltag's own edge refinement first");
            app.add_option("--overlay", call->overlay,
                           "write the picture with outlines and ids drawn in (file)");
          },
      .run = [call](Output& out) { return RunDetect(*call, out); },
  };
}

}  // namespace tendril::cli
