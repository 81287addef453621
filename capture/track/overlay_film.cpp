#include "capture/track/overlay_film.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "capture/rig/camera_model.h"
#include "db/files/curve_files.h"

namespace tendril {

namespace fs = std::filesystem;

std::int64_t CameraFilm::NearestTo(double time, std::int64_t started_ns) const {
  std::int64_t nearest = -1;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t f = 0; f < log.size(); ++f) {
    const double apart = std::abs(1e-9 * static_cast<double>(log[f].host_ns - started_ns) - time);
    if (apart >= least) continue;
    least = apart;
    nearest = static_cast<std::int64_t>(f);
  }
  return nearest;
}

Status CameraFilm::GoTo(std::int64_t frame) {
  while (at < frame) {
    Result<std::optional<VideoFrame>> next = reader.Next();
    if (!next.ok()) return next.error();
    if (!next.value()) {
      image.release();
      return Ok{};
    }
    ++at;
    image = next.value()->image;
  }
  return Ok{};
}

Result<TrialFilm> OpenTrialFilm(const fs::path& folder) {
  TrialFilm film;
  Result<TrialSpec> trial = ReadTrialToml(folder / "trial.toml");
  if (!trial.ok()) return trial.error();
  film.trial = std::move(trial).value();
  Result<Rig> rig = ParseRig(film.trial.rig_toml, (folder / "trial.toml").string() + ": rig");
  if (!rig.ok()) return rig.error();
  film.rig = std::move(rig).value();
  Result<TagLayout> tags =
      LayOutTags(film.trial.design, film.trial.gripper, LayoutOptionsOf(film.trial.tags));
  if (!tags.ok()) return tags.error();
  film.tags = std::move(tags).value();
  Result<std::vector<CurveSeries>> curves = ReadCurves(folder / "curves.h5");
  if (!curves.ok()) return curves.error();
  film.curves = std::move(curves).value();
  Result<std::vector<DetectionRow>> detections = ReadDetections(folder / "detections.csv");
  if (!detections.ok()) return detections.error();

  for (std::size_t c = 0; c < film.rig.cameras.size(); ++c) {
    Result<VideoReader> reader = VideoReader::Open(folder / fmt::format("cam{}.mkv", c));
    if (!reader.ok()) return reader.error();
    Result<std::vector<FrameRow>> log = ReadFrameLog(folder / fmt::format("cam{}.csv", c));
    if (!log.ok()) return log.error();
    CameraFilm camera{
        .reader = std::move(reader).value(), .log = std::move(log).value(), .rows = {}, .image = {}};
    camera.rows.resize(camera.log.size());
    for (const DetectionRow& row : detections.value()) {
      if (row.camera != static_cast<int>(c) || row.frame < 0) continue;
      if (row.frame < static_cast<std::int64_t>(camera.rows.size())) {
        camera.rows[static_cast<std::size_t>(row.frame)].push_back(row);
      }
    }
    film.cameras.push_back(std::move(camera));
  }
  return film;
}

cv::Rect AroundCurves(const TrialFilm& film, std::size_t camera, int frame) {
  constexpr int kRoom = 60;  // px
  const Camera& looks = film.rig.cameras[camera];
  Eigen::AlignedBox2d box;
  for (const CurveSeries& series : film.curves) {
    const FramedCurve& curve = series.curves[static_cast<std::size_t>(frame)];
    for (Eigen::Index i = 0; i < curve.points.cols(); ++i) {
      const std::optional<Eigen::Vector2d> pixel = Project(looks, curve.points.col(i));
      if (pixel) box.extend(*pixel);
    }
  }
  const cv::Rect whole(0, 0, looks.width_px, looks.height_px);
  if (box.isEmpty() || box.diagonal().norm() > 1e5) return whole;
  const cv::Rect around(static_cast<int>(box.min().x()) - kRoom, static_cast<int>(box.min().y()) - kRoom,
                        static_cast<int>(box.sizes().x()) + 2 * kRoom,
                        static_cast<int>(box.sizes().y()) + 2 * kRoom);
  const cv::Rect inside = around & whole;
  return inside.empty() ? whole : inside;
}

}  // namespace tendril
