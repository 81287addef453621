#include "cli/scene_video.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <future>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "analysis/study/scene_picture.h"
#include "cli/film_writer.h"
#include "db/files/safe_file.h"

namespace tendril::cli {
namespace {

namespace fs = std::filesystem;

Error Bad(const fs::path& file, const std::string& what) {
  return {ErrorKind::kBadInput, file.string() + ": " + what};
}

Status Check(const SceneFilm& film, const fs::path& file, const std::string& extension) {
  if (file.extension() != extension) return Bad(file, "expected a name that ends in " + extension);
  if (film.curves.empty() || film.curves[0].curves.empty()) {
    return Bad(file, "nothing to draw; expected at least one rod and one frame");
  }
  const std::size_t frames = film.curves[0].curves.size();
  if (film.radius.size() != film.curves.size()) {
    return Bad(file, fmt::format("radii of {} rods; expected {}", film.radius.size(), film.curves.size()));
  }
  const auto fits = [&](std::size_t count) { return count == 0 || count == frames; };
  if (!fits(film.lines.size()) || !fits(film.phases.size()) || !fits(film.carrier.size())) {
    return Bad(file, fmt::format("words for {} frames, phases for {}, the carrier at {}; expected {} or none",
                                 film.lines.size(), film.phases.size(), film.carrier.size(), frames));
  }
  if (film.poses.size() > film.objects.size()) {
    return Bad(file, fmt::format("poses of {} objects; expected {}", film.poses.size(), film.objects.size()));
  }
  for (const std::vector<Eigen::Isometry3d>& poses : film.poses) {
    if (!fits(poses.size())) {
      return Bad(file, fmt::format("{} poses of an object; expected {} or none", poses.size(), frames));
    }
  }
  for (std::size_t rod = 0; rod < film.curves.size(); ++rod) {
    const CurveSeries& series = film.curves[rod];
    if (series.curves.size() != frames || series.time.size() != static_cast<Eigen::Index>(frames)) {
      return Bad(file, fmt::format("rod {} has {} frames; expected {}", rod, series.curves.size(), frames));
    }
    for (const FramedCurve& curve : series.curves) {
      if (curve.points.cols() == film.radius[rod].size()) continue;
      return Bad(file, fmt::format("rod {} has {} nodes and {} radii", rod, curve.points.cols(),
                                   film.radius[rod].size()));
    }
  }
  return Ok{};
}

constexpr double kCarrierThickness = 0.006;  // m

// It is drawn straight, taut or not; where it comes from is often far above the scene, so it may run out of
// the picture.
Wire StringOf(const SceneObject& object, const Eigen::Isometry3d& pose) {
  Wire wire{.points = Eigen::Matrix3Xd(3, 2), .in_view = false};
  wire.points.col(0) = object.string.from;
  wire.points.col(1) = pose * object.string.to_in_body;
  constexpr double kTaut = 0.999;  // of its length
  wire.pale = (wire.points.col(1) - wire.points.col(0)).norm() < kTaut * object.string.length;
  return wire;
}

ScenePicture PictureOf(const SceneFilm& film, std::size_t frame) {
  ScenePicture picture{.title = film.name, .time = film.curves[0].time[static_cast<Eigen::Index>(frame)]};
  for (std::size_t rod = 0; rod < film.curves.size(); ++rod) {
    picture.tubes.push_back({.points = film.curves[rod].curves[frame].points,
                             .radius = film.radius[rod],
                             .name = film.curves[rod].name});
  }
  for (std::size_t o = 0; o < film.objects.size(); ++o) {
    const SceneObject& object = film.objects[o];
    const bool moved = o < film.poses.size() && !film.poses[o].empty();
    const Eigen::Isometry3d& pose = moved ? film.poses[o][frame] : object.pose;
    picture.objects.push_back({.shape = object.shape, .pose = pose, .name = object.name});
    if (object.motion == ObjectMotion::kHanging) picture.wires.push_back(StringOf(object, pose));
  }
  if (!film.carrier.empty()) {
    picture.wires.push_back({.points = film.carrier[frame], .radius = kCarrierThickness / 2});
  }
  if (!film.phases.empty()) picture.phase = film.phases[frame];
  if (!film.lines.empty()) picture.lines = film.lines[frame];
  return picture;
}

// Seconds of film per second of the scene: 1, or what brings its frames down to 60 a second.
double SlownessOf(const Eigen::VectorXd& time) {
  constexpr double kFastest = 60;
  const double span = time[time.size() - 1] - time[0];
  if (!(span > 0)) return 1;
  const double slowness = static_cast<double>(time.size() - 1) / span / kFastest;
  return slowness > 1.001 ? slowness : 1;
}

// Draws pictures in turn, some ahead of the one that is asked for, each on a thread of its own.
class FramesAhead {
 public:
  FramesAhead(const std::vector<ScenePicture>& pictures, const std::vector<SceneView>& views)
      : pictures_(pictures), views_(views) {
    constexpr std::size_t kMost = 8;  // a painter holds up to 80 MB
    const std::size_t threads = std::clamp<std::size_t>(std::thread::hardware_concurrency(), 1, kMost);
    for (std::size_t i = 0; i < std::min(threads, pictures.size()); ++i) painters_.emplace_back(views[i]);
    for (std::size_t i = 0; i < painters_.size(); ++i) Begin(i);
  }

  cv::Mat Next() {
    const std::size_t frame = next_++;
    cv::Mat drawn = drawn_.front().get();
    drawn_.pop_front();
    // Its painter is free again.
    if (frame + painters_.size() < pictures_.size()) Begin(frame + painters_.size());
    return drawn;
  }

 private:
  void Begin(std::size_t frame) {
    ScenePainter& painter = painters_[frame % painters_.size()];
    drawn_.push_back(
        std::async(std::launch::async, [&painter, &picture = pictures_[frame], &view = views_[frame]] {
          painter.LookFrom(view);
          return painter.Draw(picture);
        }));
  }

  const std::vector<ScenePicture>& pictures_;
  const std::vector<SceneView>& views_;
  std::size_t next_ = 0;
  std::vector<ScenePainter> painters_;
  std::deque<std::future<cv::Mat>> drawn_;  // ends before the painters do: a future waits for its thread
};

// Exceptions of OpenCV's end here.
template <class Draw>
Status Guarded(const fs::path& file, const Draw& draw) {
  try {
    return draw();
  } catch (const cv::Exception& error) {
    return Error{ErrorKind::kIo, fmt::format("{}: {}", file.string(), error.err)};
  }
}

}  // namespace

Eigen::VectorXd RadiusAtNodes(const Eigen::VectorXd& radius_of_elements) {
  const Eigen::Index elements = radius_of_elements.size();
  if (elements == 0) return {};
  Eigen::VectorXd at_nodes(elements + 1);
  at_nodes[0] = radius_of_elements[0];
  at_nodes[elements] = radius_of_elements[elements - 1];
  for (Eigen::Index i = 1; i < elements; ++i) {
    at_nodes[i] = 0.5 * (radius_of_elements[i - 1] + radius_of_elements[i]);
  }
  return at_nodes;
}

Status WriteSceneVideo(const SceneFilm& film, const fs::path& file, const Progress& progress) {
  constexpr int kWidth = 1280, kHeight = 720;  // px
  if (Status fits = Check(film, file, ".mp4"); !fits.ok()) return fits;
  return Guarded(file, [&]() -> Status {
    const Eigen::VectorXd& time = film.curves[0].time;
    const double slowness = SlownessOf(time);
    std::vector<ScenePicture> pictures;
    for (std::size_t frame = 0; frame < film.curves[0].curves.size(); ++frame) {
      pictures.push_back(PictureOf(film, frame));
      if (slowness > 1) pictures.back().lines.push_back(fmt::format("shown {:.3g} times slower", slowness));
    }
    const std::vector<SceneView> views = FollowViews(pictures, time, kWidth, kHeight);
    return WriteBeside(file, [&](const fs::path& beside) -> Status {
      Result<FilmWriter> writer = FilmWriter::Open(beside, kWidth, kHeight);
      if (!writer.ok()) return writer.error();
      const std::size_t frames = pictures.size();
      FramesAhead ahead(pictures, views);
      for (std::size_t frame = 0; frame < frames; ++frame) {
        const double shown_at = (time[static_cast<Eigen::Index>(frame)] - time[0]) * slowness;
        if (Status s = writer.value().Write(ahead.Next(), shown_at); !s.ok()) return s;
        if (progress && !progress(static_cast<double>(frame + 1) / static_cast<double>(frames))) {
          return Error{ErrorKind::kStopped, file.string() + ": stopped while drawing"};
        }
      }
      return writer.value().Close();
    });
  });
}

Status WriteScenePicture(const SceneFilm& film, const fs::path& file) {
  constexpr int kWidth = 1600, kHeight = 1000;  // px
  if (Status fits = Check(film, file, ".png"); !fits.ok()) return fits;
  return Guarded(file, [&]() -> Status {
    const ScenePicture last = PictureOf(film, film.curves[0].curves.size() - 1);
    const cv::Mat drawn = DrawScene(last, FitView({last}, kWidth, kHeight));
    return WriteBeside(file, [&](const fs::path& beside) -> Status {
      if (cv::imwrite(beside.string(), drawn)) return Ok{};
      return Error{ErrorKind::kIo,
                   file.string() + ": cannot be written; expected room on the disk and a writable folder"};
    });
  });
}

}  // namespace tendril::cli
