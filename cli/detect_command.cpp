// tendril detect: which tags single pictures show, and where.
#include "cli/detect_command.h"

#include <filesystem>
#include <memory>
#include <vector>

#include "capture/record/picture_file.h"
#include "capture/track/tag_detect.h"
#include "cli/detect_live.h"
#include "cli/tag_picture.h"

namespace tendril::cli {
namespace {

struct DetectCall {
  std::vector<std::string> images;
  TagDetectOptions options{.threads = 2};
  bool library_corners = false;
  std::string overlay;
  bool live = false;
  LiveCall watch;
};

Status RunDetect(const DetectCall& call, Output& out) {
  if (call.live) {
    LiveCall watch = call.watch;
    watch.sources = call.images;
    watch.detect = call.options;
    watch.detect.threads = 1;  // cameras share the processor already
    watch.overlay = call.overlay;
    return DetectLive(watch, out);
  }
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
      std::vector<DrawnTag> drawn;
      for (const TagDetection& tag : tags.value()) drawn.push_back({tag.id, tag.corners_px});
      if (auto s = WritePicture(DrawTags(picture, drawn), call.overlay); !s.ok()) return s;
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
            app.add_option("images", call->images,
                           "pictures (PNG, JPEG, ...); with --live one source per camera: /dev/video0, "
                           "rtsp://..., udp://..., tcp://..., http://..., a named pipe, a video file")
                ->required();
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
            app.add_option(
                "--overlay", call->overlay,
                "write the picture with outlines and ids drawn in (file); with --live once a second, "
                "cameras side by side");
            CLI::Option* live = app.add_flag("--live", call->live,
                                             "watch cameras: which tags each one sees now, until Ctrl-C");
            app.add_option("--seconds", call->watch.seconds, "with --live: end after so long (s)")
                ->check(CLI::PositiveNumber)
                ->needs(live);
            app.add_option("--level", call->watch.level,
                           "with --live: how tags are followed: preview, standard, best (name)")
                ->check(CLI::IsMember({"preview", "standard", "best"}))
                ->needs(live)
                ->capture_default_str();
            app.add_option(
                   "--expect", call->watch.expect,
                   "with --live: ids that should be seen, such as 0-97,120; says which of them fewer than "
                   "two cameras see (ids)")
                ->needs(live);
          },
      .run = [call](Output& out) { return RunDetect(*call, out); },
  };
}

}  // namespace tendril::cli
