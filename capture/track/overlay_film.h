#pragma once
// A tracked trial's folder opened for drawing: its pictures, the tags found in them, and its curves.

#include <cstdint>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "capture/record/video_file.h"
#include "capture/rig/rig.h"
#include "capture/rig/tag_layout.h"
#include "db/files/recording_logs.h"
#include "db/files/trial_toml.h"
#include "model/geometry/framed_curve.h"
#include "model/result.h"

namespace tendril {

// One camera of the recording: its video, read forward to the frame that is asked for.
struct CameraFilm {
  VideoReader reader;
  std::vector<FrameRow> log;
  std::vector<std::vector<DetectionRow>> rows;  // of each of its frames
  std::int64_t at = -1;                         // frame that `image` holds
  cv::Mat image;                                // gray; empty: beyond the video's end

  // The frame whose time is nearest; -1: it has none.
  std::int64_t NearestTo(double time, std::int64_t started_ns) const;
  // Never backwards.
  Status GoTo(std::int64_t frame);
};

// Everything that is drawn.
struct TrialFilm {
  TrialSpec trial;
  Rig rig;
  TagLayout tags;
  std::vector<CurveSeries> curves;
  std::vector<CameraFilm> cameras;
};

// Reads trial.toml, cam<i>.mkv, cam<i>.csv, detections.csv and curves.h5.
//   errors  what the files' readers say
Result<TrialFilm> OpenTrialFilm(const std::filesystem::path& folder);

// Where the curves of one frame are in a camera's picture, with some room around; px of the camera.
cv::Rect AroundCurves(const TrialFilm& film, std::size_t camera, int frame);

}  // namespace tendril
