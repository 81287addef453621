#include "capture/track/overlay.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <optional>

#include "capture/track/overlay_film.h"
#include "db/files/safe_file.h"

namespace tendril {
namespace {

namespace fs = std::filesystem;

// Blue, green, red.
const cv::Scalar kSeenColor(255, 208, 64);
const cv::Scalar kBridgedColor(0, 165, 255);
const cv::Scalar kNotSeenColor(214, 92, 214);
const cv::Scalar kTagFitsColor(96, 208, 64);
const cv::Scalar kTagElsewhereColor(64, 64, 240);
const cv::Scalar kText(240, 240, 240);

constexpr int kShift = 4;  // fractional bits of OpenCV's drawing coordinates

cv::Point Fixed(const Eigen::Vector2d& p) {
  const double bounded_x = std::clamp(p.x(), -1e5, 1e5);
  const double bounded_y = std::clamp(p.y(), -1e5, 1e5);
  return {static_cast<int>(std::lround(bounded_x * (1 << kShift))),
          static_cast<int>(std::lround(bounded_y * (1 << kShift)))};
}

void Line(cv::Mat& picture, const Eigen::Vector2d& a, const Eigen::Vector2d& b, const cv::Scalar& color,
          int thickness) {
  cv::line(picture, Fixed(a), Fixed(b), color, thickness, cv::LINE_AA, kShift);
}

void DashedLine(cv::Mat& picture, const Eigen::Vector2d& a, const Eigen::Vector2d& b, const cv::Scalar& color,
                int thickness) {
  constexpr double kDash = 5;  // px
  const int pieces = std::max(1, 2 * static_cast<int>(std::lround((b - a).norm() / (2 * kDash))) - 1);
  for (int i = 0; i < std::min(pieces, 1000); i += 2) {
    Line(picture, a + (b - a) * i / pieces, a + (b - a) * (i + 1) / pieces, color, thickness);
  }
}

enum class NodeState { kSeen, kBridged, kNotSeen };

NodeState StateOf(const CurveSeries& series, int frame, int node) {
  const auto f = static_cast<std::size_t>(frame);
  if (f < series.sigma.size() && std::isnan(series.sigma[f][node])) return NodeState::kNotSeen;
  const bool bridged = f < series.interpolated.size() && series.interpolated[f][node] != 0;
  return bridged ? NodeState::kBridged : NodeState::kSeen;
}

const cv::Scalar& ColorOf(NodeState state) {
  if (state == NodeState::kSeen) return kSeenColor;
  return state == NodeState::kBridged ? kBridgedColor : kNotSeenColor;
}

// `scale`: px drawn per px of the camera. Pixel centres are integers in both.
Eigen::Vector2d Scaled(const Eigen::Vector2d& pixel, double scale) {
  return (pixel.array() + 0.5) * scale - 0.5;
}

void DrawCurve(const Camera& camera, const CurveSeries& series, int frame, double scale, cv::Mat& picture) {
  const FramedCurve& curve = series.curves[static_cast<std::size_t>(frame)];
  std::optional<Eigen::Vector2d> last;
  for (int node = 0; node < curve.points.cols(); ++node) {
    std::optional<Eigen::Vector2d> here = Project(camera, curve.points.col(node));
    if (here) here = Scaled(*here, scale);
    if (here && last) {
      // A segment is as good as the worse of its ends.
      const NodeState state = std::max(StateOf(series, frame, node - 1), StateOf(series, frame, node));
      if (state == NodeState::kNotSeen) {
        DashedLine(picture, *last, *here, ColorOf(state), 1);
      } else {
        Line(picture, *last, *here, ColorOf(state), 2);
      }
    }
    last = here;
  }
  for (int node = 0; node < curve.points.cols(); ++node) {
    const std::optional<Eigen::Vector2d> pixel = Project(camera, curve.points.col(node));
    const NodeState state = StateOf(series, frame, node);
    if (!pixel || state == NodeState::kNotSeen) continue;
    const Eigen::Vector2d at = Scaled(*pixel, scale);
    cv::circle(picture, Fixed(at), 2 << kShift, ColorOf(state), cv::FILLED, cv::LINE_AA, kShift);
    // Sigma, where it is large enough to be drawn.
    const double depth = (camera.camera_from_lab * curve.points.col(node)).z();
    const double sigma = series.sigma.empty() ? 0.0 : series.sigma[static_cast<std::size_t>(frame)][node];
    const double sigma_px = scale * camera.focal_x_px * sigma / depth;
    if (sigma_px > 4) {
      cv::circle(picture, Fixed(at), static_cast<int>(std::lround(sigma_px * (1 << kShift))), ColorOf(state),
                 1, cv::LINE_AA, kShift);
    }
  }
}

void Text(cv::Mat& picture, const std::string& text, const cv::Point& at, const cv::Scalar& color) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.5, color, 1, cv::LINE_AA);
}

constexpr int kTitle = 26;       // rows above a camera's picture, px
constexpr int kLegend = 52;      // rows below, px
constexpr int kNarrowest = 300;  // of a camera's column, px

void DrawLegend(cv::Mat& picture) {
  const int first = picture.rows - kLegend + 20;
  const auto line = [&](int x, int y, const cv::Scalar& color, const std::string& meaning) {
    cv::line(picture, {x, y - 5}, {x + 26, y - 5}, color, 2, cv::LINE_AA);
    Text(picture, meaning, {x + 34, y}, kText);
  };
  const auto box = [&](int x, int y, const cv::Scalar& color, const std::string& meaning) {
    cv::rectangle(picture, {x + 8, y - 10, 10, 10}, color, 1, cv::LINE_AA);
    Text(picture, meaning, {x + 34, y}, kText);
  };
  line(10, first, kSeenColor, "seen");
  line(96, first, kBridgedColor, "bridged (circle: sigma)");
  DashedLine(picture, {322, first - 5.0}, {348, first - 5.0}, kNotSeenColor, 1);
  Text(picture, "not seen: model only", {356, first}, kText);
  box(10, first + 22, kTagFitsColor, "tag on its facet");
  box(192, first + 22, kTagElsewhereColor, "tag elsewhere");
}

Error CannotWrite(const fs::path& file) {
  return {ErrorKind::kIo,
          file.string() + ": cannot be written; expected room on the disk and a writable folder"};
}

// How many times each frame is written so that the video has at least `least_fps`.
struct Pace {
  double fps = 10;
  int repeats = 1;
};

Pace PaceOf(const Eigen::VectorXd& time, double least_fps) {
  double rate = least_fps;
  if (time.size() > 1) {
    const double span = time[time.size() - 1] - time[0];
    if (span > 0) rate = static_cast<double>(time.size() - 1) / span;
  }
  rate = std::clamp(rate, 0.5, 60.0);
  const int repeats = std::max(1, static_cast<int>(std::ceil(least_fps / rate)));
  return {.fps = rate * repeats, .repeats = repeats};
}

// All cameras of one frame, side by side, with a title each and one legend below.
//   close_up  only what is around the curves
Result<cv::Mat> DrawFrame(TrialFilm& film, int frame, const OverlayOptions& options, bool close_up) {
  const double time = film.curves.front().time[frame];
  std::vector<cv::Rect> parts;
  int width = 1;
  int height = 1;
  for (std::size_t c = 0; c < film.cameras.size(); ++c) {
    const Camera& camera = film.rig.cameras[c];
    parts.push_back(close_up ? AroundCurves(film, c, frame)
                             : cv::Rect(0, 0, camera.width_px, camera.height_px));
    width += parts.back().width;
    height = std::max(height, parts.back().height);
  }
  const double scale =
      std::min({1.0, static_cast<double>(options.largest_height_px - kTitle - kLegend) / height,
                static_cast<double>(options.largest_width_px) / width});
  const int rows = kTitle + static_cast<int>(std::ceil(scale * height)) + kLegend;
  std::vector<cv::Mat> views;
  for (std::size_t c = 0; c < film.cameras.size(); ++c) {
    CameraFilm& camera = film.cameras[c];
    const std::int64_t its_frame = camera.NearestTo(time, film.trial.started_ns);
    if (Status s = camera.GoTo(its_frame); !s.ok()) return s.error();
    const std::vector<DetectionRow> none;
    const bool known = its_frame >= 0 && !camera.image.empty();
    const cv::Mat drawn = DrawOverlay(film.rig.cameras[c], camera.image,
                                      known ? camera.rows[static_cast<std::size_t>(its_frame)] : none,
                                      film.tags, film.curves, frame, scale);
    const cv::Rect part = cv::Rect(static_cast<int>(scale * parts[c].x), static_cast<int>(scale * parts[c].y),
                                   static_cast<int>(std::ceil(scale * parts[c].width)),
                                   static_cast<int>(std::ceil(scale * parts[c].height))) &
                          cv::Rect(0, 0, drawn.cols, drawn.rows);
    // Wide enough for the title, and of even size, because video codecs halve colour.
    const cv::Size size(2 * ((std::max(part.width, kNarrowest) + 1) / 2), 2 * ((rows + 1) / 2));
    cv::Mat view(size, CV_8UC3, cv::Scalar::all(0));
    drawn(part).copyTo(view(cv::Rect(0, kTitle, part.width, part.height)));
    Text(view,
         fmt::format("{}  {}  frame {}  t = {:.2f} s", film.trial.label, film.rig.cameras[c].name, frame,
                     time),
         {10, 18}, kText);
    views.push_back(view);
  }
  cv::Mat all;
  cv::hconcat(views, all);
  DrawLegend(all);
  return all;
}

Result<OverlayFiles> Draw(const fs::path& folder, TrialFilm& film, const OverlayOptions& options,
                          fs::path& beside, const Progress& progress) {
  OverlayFiles files{.video = folder / "overlay.mp4", .last_frame = folder / "overlay.png"};
  const int frames = static_cast<int>(film.curves.front().curves.size());
  const Pace pace = PaceOf(film.curves.front().time, options.least_fps);
  cv::VideoWriter writer;
  cv::Mat drawn;
  for (int frame = 0; frame < frames; ++frame) {
    Result<cv::Mat> next = DrawFrame(film, frame, options, false);
    if (!next.ok()) return next.error();
    drawn = next.value();
    if (frame == 0) {
      beside = folder / "overlay.part.mp4";
      const int h264 = cv::VideoWriter::fourcc('a', 'v', 'c', '1');
      if (!writer.open(beside.string(), cv::CAP_FFMPEG, h264, pace.fps, drawn.size())) {
        std::error_code ignored;
        fs::remove(beside, ignored);
        beside = folder / "overlay.part.avi";
        files.video = folder / "overlay.avi";
        const int jpeg = cv::VideoWriter::fourcc('M', 'J', 'P', 'G');
        if (!writer.open(beside.string(), jpeg, pace.fps, drawn.size())) return CannotWrite(files.video);
      }
    }
    for (int k = 0; k < pace.repeats; ++k) writer.write(drawn);
    if (progress && !progress((frame + 1.0) / frames)) {
      return Error{ErrorKind::kStopped, "stopped while drawing the overlay"};
    }
  }
  writer.release();
  fs::rename(beside, files.video);
  Result<cv::Mat> last = DrawFrame(film, frames - 1, options, true);
  if (!last.ok()) return last.error();
  drawn = last.value();
  const Status saved = WriteBeside(files.last_frame, [&](const fs::path& file) -> Status {
    if (cv::imwrite(file.string(), drawn)) return Ok{};
    return CannotWrite(file);
  });
  if (!saved.ok()) return saved.error();
  return files;
}

// An exception of OpenCV or the file system while something is drawn from a folder.
template <class Work>
auto Drawing(const fs::path& folder, const Work& work) -> decltype(work()) {
  try {
    return work();
  } catch (const cv::Exception& error) {
    return Error{ErrorKind::kIo, fmt::format("{}: overlay: {}", folder.string(), error.err)};
  } catch (const fs::filesystem_error& error) {
    return Error{ErrorKind::kIo, fmt::format("{}: overlay: {}", folder.string(), error.code().message())};
  }
}

}  // namespace

cv::Mat DrawOverlay(const Camera& camera, const cv::Mat& gray, const std::vector<DetectionRow>& rows,
                    const TagLayout& tags, const std::vector<CurveSeries>& curves, int frame, double scale) {
  constexpr double kFits = 0.015;  // m
  // Even sizes, because video codecs halve colour.
  const cv::Size size(2 * std::max(8, static_cast<int>(scale * camera.width_px / 2)),
                      2 * std::max(8, static_cast<int>(scale * camera.height_px / 2)));
  cv::Mat picture(size, CV_8UC3, cv::Scalar::all(0));
  if (!gray.empty()) {
    cv::Mat small;
    cv::resize(gray, small, size, 0, 0, cv::INTER_AREA);
    cv::cvtColor(small, picture, cv::COLOR_GRAY2BGR);
    picture.convertTo(picture, -1, 0.7);  // a little darker, so that lines stand out
  }
  for (const DetectionRow& row : rows) {
    bool fits = false;
    const TagPlace* place = tags.Find(row.tag);
    if (place != nullptr && place->tentacle < static_cast<int>(curves.size())) {
      const FramedCurve& curve =
          curves[static_cast<std::size_t>(place->tentacle)].curves[static_cast<std::size_t>(frame)];
      if (place->facet < curve.points.cols()) {
        const Eigen::Vector3d hole = curve.points.col(place->facet);
        const std::optional<Eigen::Vector2d> expected = Project(camera, hole);
        const double depth = (camera.camera_from_lab * hole).z();
        fits = expected &&
               (row.corners_px.rowwise().mean() - *expected).norm() < kFits * camera.focal_x_px / depth;
      }
    }
    const cv::Scalar& color = fits ? kTagFitsColor : kTagElsewhereColor;
    for (int k = 0; k < 4; ++k) {
      Line(picture, Scaled(row.corners_px.col(k), scale), Scaled(row.corners_px.col((k + 1) % 4), scale),
           color, 1);
    }
  }
  for (const CurveSeries& series : curves) DrawCurve(camera, series, frame, scale, picture);
  return picture;
}

Result<OverlayFiles> WriteOverlay(const fs::path& folder, const OverlayOptions& options,
                                  const Progress& progress) {
  Result<TrialFilm> film = OpenTrialFilm(folder);
  if (!film.ok()) return film.error();
  if (film.value().cameras.empty() || film.value().curves.empty() ||
      film.value().curves.front().curves.empty()) {
    return Error{ErrorKind::kBadInput,
                 folder.string() + ": nothing to draw; expected at least one camera and one tracked frame"};
  }
  fs::path beside;
  std::error_code ignored;
  Result<OverlayFiles> files =
      Drawing(folder, [&] { return Draw(folder, film.value(), options, beside, progress); });
  if (!files.ok() && !beside.empty()) fs::remove(beside, ignored);
  return files;
}

Result<std::vector<OverlayStill>> DrawStills(const fs::path& folder, const std::vector<int>& frames,
                                             int largest_side_px, const Progress& progress) {
  Result<TrialFilm> opened = OpenTrialFilm(folder);
  if (!opened.ok()) return opened.error();
  TrialFilm& film = opened.value();
  return Drawing(folder, [&]() -> Result<std::vector<OverlayStill>> {
    std::vector<OverlayStill> stills;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const int frame = frames[i];
      const double time = film.curves.front().time[frame];
      for (std::size_t c = 0; c < film.cameras.size(); ++c) {
        CameraFilm& camera = film.cameras[c];
        const std::int64_t its_frame = camera.NearestTo(time, film.trial.started_ns);
        if (Status s = camera.GoTo(its_frame); !s.ok()) return s.error();
        if (its_frame < 0 || camera.image.empty()) continue;
        const cv::Rect part = AroundCurves(film, c, frame);
        const double scale =
            std::min(1.0, static_cast<double>(largest_side_px) / std::max(part.width, part.height));
        const cv::Mat drawn =
            DrawOverlay(film.rig.cameras[c], camera.image, camera.rows[static_cast<std::size_t>(its_frame)],
                        film.tags, film.curves, frame, scale);
        const cv::Rect shown = cv::Rect(static_cast<int>(scale * part.x), static_cast<int>(scale * part.y),
                                        static_cast<int>(std::ceil(scale * part.width)),
                                        static_cast<int>(std::ceil(scale * part.height))) &
                               cv::Rect(0, 0, drawn.cols, drawn.rows);
        stills.push_back(
            {.camera = static_cast<int>(c), .frame = frame, .time = time, .picture = drawn(shown).clone()});
      }
      if (progress && !progress((static_cast<double>(i) + 1) / static_cast<double>(frames.size()))) {
        return Error{ErrorKind::kStopped, "stopped while drawing the overlay"};
      }
    }
    return stills;
  });
}

}  // namespace tendril
