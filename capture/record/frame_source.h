#pragma once
// Where a recording's pictures and servo readings come from.
//
// A paced source (files, the virtual rig) waits for the recorder; any other (a camera) goes on by itself, and
// what the recorder cannot take in time is dropped and counted.

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "db/files/recording_logs.h"
#include "model/result.h"

namespace tendril {

struct SourceFrame {
  cv::Mat image;              // CV_8UC1; every picture of a source has the same size
  double time = 0;            // s since the trial began; used where host_ns is not known
  std::int64_t frame_id = 0;  // the source's counter; a gap is a loss before the recorder
  std::int64_t device_ns = 0;
  std::optional<std::int64_t> host_ns;
  std::string status = "ok";
};

class FrameSource {
 public:
  virtual ~FrameSource() = default;
  // The next picture; none at the end. Called from one thread only.
  virtual Result<std::optional<SourceFrame>> Next() = 0;
  virtual bool paced() const = 0;
  // How many pictures it will give, where that is known.
  virtual std::optional<std::int64_t> frames() const { return std::nullopt; }
  // The host's time of its first picture, where a log says so.
  virtual std::optional<std::int64_t> first_host_ns() const { return std::nullopt; }
};

struct ServoSample {
  double time = 0;  // s since the trial began; used where row.host_ns is 0
  ServoRow row;
};

class ServoSource {
 public:
  virtual ~ServoSource() = default;
  virtual Result<std::optional<ServoSample>> Next() = 0;
  virtual std::optional<std::int64_t> first_host_ns() const { return std::nullopt; }
};

}  // namespace tendril
