#pragma once
// The text files of a recording: frame times, servo log, tag detections, as CSV (docs/formats.md).
//
// Recorded stamps stay integers: ns of the clock that the name says (host: UTC since 1970). Readers check
// every field; an error names file:line, field, value and what was expected. Lines may end in LF or CRLF.

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/result.h"

namespace tendril {

// cam<i>.csv: frame,frame_id,device_ns,host_ns,status,dropped_before
struct FrameRow {
  std::int64_t frame = 0;     // index in the video file, 0, 1, 2, ...
  std::int64_t frame_id = 0;  // the camera's own counter
  std::int64_t device_ns = 0;
  std::int64_t host_ns = 0;
  std::string status = "ok";
  std::int64_t dropped_before = 0;  // frames lost between the one before and this one
};

// servo.csv: host_ns,device_ms,servo,command,position_deg,current_mA,voltage_V,temperature_degC; empty where
// a servo does not report it.
struct ServoRow {
  std::int64_t host_ns = 0;
  std::optional<std::int64_t> device_ms{};
  int servo = 0;
  std::optional<double> command{};  // commanded pull, fraction of the flat tendon length
  std::optional<double> position_deg{};
  std::optional<double> current_mA{};
  std::optional<double> voltage_V{};
  std::optional<double> temperature_degC{};
};

// detections.csv: camera,frame,tag,hamming,margin,x0,y0,x1,y1,x2,y2,x3,y3,sigma_px. Files without the last
// column are read as well.
struct DetectionRow {
  int camera = 0;
  std::int64_t frame = 0;
  int tag = 0;
  // Wrong bits and decision margin; none and NaN where the tag was followed and not decoded in this picture.
  std::optional<int> hamming{};
  double margin = std::numeric_limits<double>::quiet_NaN();
  Eigen::Matrix<double, 2, 4> corners_px;  // in the detector's order (capture/rig/tag_layout.h)
  // Stated 1-sigma error of a corner's coordinate, root mean square of the eight; NaN: not known.
  double sigma_px = std::numeric_limits<double>::quiet_NaN();
};

// residuals.csv: camera,frame,tag,used,x0,y0,x1,y1,x2,y2,x3,y3. What a tag that was found says against the
// reconstructed chain.
struct ResidualRow {
  int camera = 0;
  std::int64_t frame = 0;  // of curves.h5, which is camera 0's
  int tag = 0;
  bool used = false;  // false: the solver left this sighting out
  // Found minus where the chain has it, the tag at its nominal place on its facet; NaN: behind the camera.
  Eigen::Matrix<double, 2, 4> corners_px;
};

//   errors  kNotFound no such file; kBadInput a bad header or field, a truncated last line. A file of a
//   header
//           alone is a recording of nothing: no rows, no error.
//   ReadFrameLog also demands frame = 0, 1, 2, ...; frame_id and host_ns that never fall.
Result<std::vector<FrameRow>> ReadFrameLog(const std::filesystem::path& file);
Result<std::vector<ServoRow>> ReadServoLog(const std::filesystem::path& file);
Result<std::vector<DetectionRow>> ReadDetections(const std::filesystem::path& file);
Result<std::vector<ResidualRow>> ReadResiduals(const std::filesystem::path& file);

// Written beside the target and renamed: a reader sees the whole file or none.
Status WriteFrameLog(const std::filesystem::path& file, std::span<const FrameRow> rows);
Status WriteServoLog(const std::filesystem::path& file, std::span<const ServoRow> rows);
Status WriteDetections(const std::filesystem::path& file, std::span<const DetectionRow> rows);
Status WriteResiduals(const std::filesystem::path& file, std::span<const ResidualRow> rows);

// For a recorder that appends as it goes: the header line, and one row's line (both with their newline).
std::string FrameLogHeader();
std::string FrameLogLine(const FrameRow& row);
std::string ServoLogHeader();
std::string ServoLogLine(const ServoRow& row);

}  // namespace tendril
