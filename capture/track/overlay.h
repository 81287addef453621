#pragma once
// What the tracker made of a recording, drawn over its pictures: tags outlined, centerlines coloured by
// whether they were seen, bridged by the model or not seen. One file with all cameras side by side.

#include <cstdint>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "capture/rig/camera_model.h"
#include "capture/rig/tag_layout.h"
#include "db/files/recording_logs.h"
#include "model/geometry/framed_curve.h"
#include "model/progress.h"
#include "model/result.h"

namespace tendril {

struct OverlayOptions {
  int largest_height_px = 1080;  // of the drawn picture; cameras are scaled to fit
  int largest_width_px = 1920;
  double least_fps = 10;  // slower recordings repeat frames, because players stumble over 1 frame per second
};

// Draws one camera's part of a frame.
//   gray     the camera's picture; empty: it has none of this moment
//   rows     its detections in that picture. A tag counts as fitting if its centre lies within 15 mm of its
//            facet's hole as the curve has it.
//   scale    px drawn per px of the camera, in (0, 1]
cv::Mat DrawOverlay(const Camera& camera, const cv::Mat& gray, const std::vector<DetectionRow>& rows,
                    const TagLayout& tags, const std::vector<CurveSeries>& curves, int frame, double scale);

struct OverlayFiles {
  std::filesystem::path video;       // H.264 in MP4, or Motion JPEG in AVI where there is no H.264 encoder
  std::filesystem::path last_frame;  // PNG, only what is around the curves, so larger
};

// Reads a tracked trial's folder (trial.toml, cam<i>.mkv, cam<i>.csv, detections.csv, curves.h5) and writes
// overlay.mp4 (or .avi) and overlay.png into it.
//   errors  what the files' readers say; kNotFound the trial has not been tracked; kIo not writable;
//           kStopped (no file is left half-made)
Result<OverlayFiles> WriteOverlay(const std::filesystem::path& folder, const OverlayOptions& options = {},
                                  const Progress& progress = {});

// One camera's part of a frame, only what is around the curves; no text is drawn into it.
struct OverlayStill {
  int camera = 0;
  int frame = 0;    // of the curves
  double time = 0;  // s since the trial began
  cv::Mat picture;  // blue, green, red
};

// Frame by frame, in each its cameras; a camera without a picture of a moment is left out. Never larger than
// the camera's own picture.
//   frames   of the curves, ascending; each exists
//   errors   as WriteOverlay; nothing is written
Result<std::vector<OverlayStill>> DrawStills(const std::filesystem::path& folder,
                                             const std::vector<int>& frames, int largest_side_px,
                                             const Progress& progress = {});

}  // namespace tendril
