#include "capture/track/sightings.h"

#include <fmt/core.h>

#include <cstddef>

namespace tendril {

Sightings SortSightings(const std::vector<DetectionRow>& rows, const std::vector<FrameLog>& cameras,
                        const TagLayout& tags, const TrialSpec& trial, double same_moment) {
  Sightings sorted;
  const std::vector<FrameRow>& first = cameras.front();
  const auto moments = SameMoments(cameras, same_moment);
  std::vector<std::vector<int>> frame_of(cameras.size());  // camera's own frame -> frame of camera 0
  for (std::size_t c = 0; c < cameras.size(); ++c) frame_of[c].assign(cameras[c].size(), -1);
  for (std::size_t f = 0; f < moments.size(); ++f) {
    sorted.time.push_back(1e-9 * static_cast<double>(first[f].host_ns - trial.started_ns));
    for (std::size_t c = 0; c < cameras.size(); ++c) {
      if (moments[f][c] >= 0) frame_of[c][static_cast<std::size_t>(moments[f][c])] = static_cast<int>(f);
    }
  }
  sorted.views.assign(moments.size(),
                      std::vector<std::vector<TagView>>(static_cast<std::size_t>(trial.gripper.tentacles)));
  for (const DetectionRow& row : rows) {
    const auto camera = static_cast<std::size_t>(row.camera);
    const int frame = frame_of[camera][static_cast<std::size_t>(row.frame)];
    const TagPlace* place = tags.Find(row.tag);
    if (place == nullptr) ++sorted.unknown_tags;
    if (place == nullptr || frame < 0) continue;
    sorted.views[static_cast<std::size_t>(frame)][static_cast<std::size_t>(place->tentacle)].push_back(
        {.camera = row.camera, .place = place, .corners_px = row.corners_px, .sigma_px = row.sigma_px});
  }
  return sorted;
}

Status CheckDetections(const std::vector<DetectionRow>& rows, const std::vector<FrameLog>& cameras,
                       const std::filesystem::path& file) {
  for (const DetectionRow& row : rows) {
    if (row.camera < 0 || static_cast<std::size_t>(row.camera) >= cameras.size()) {
      return Error{ErrorKind::kBadInput, fmt::format("{}: camera {}, but the rig has cameras 0 .. {}",
                                                     file.string(), row.camera, cameras.size() - 1)};
    }
    const std::size_t frames = cameras[static_cast<std::size_t>(row.camera)].size();
    if (row.frame < 0 || static_cast<std::size_t>(row.frame) >= frames) {
      return Error{ErrorKind::kBadInput,
                   fmt::format("{}: frame {} of camera {}, but its frame log has {} rows", file.string(),
                               row.frame, row.camera, frames)};
    }
  }
  return Ok{};
}

}  // namespace tendril
