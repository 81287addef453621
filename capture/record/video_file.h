#pragma once
// Recorded pictures as Matroska files: 8-bit gray, FFV1 (lossless, a checksum per slice), one time per frame.
//
// Written and read through libav itself: OpenCV's writer leaves the pixel format, the checksums and a time
// per frame to the codec's wrapper. The reader also takes other videos (any codec of libav's) and gives their
// brightness.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "model/result.h"

namespace tendril {

class VideoWriter {
 public:
  // Creates the file; it replaces one that is there.
  //   errors  kBadInput a size below 16 px; kIo the file cannot be made
  static Result<VideoWriter> Open(const std::filesystem::path& file, int width_px, int height_px);

  // image: CV_8UC1 of the size given. time: s since the recording began; in the file it is rounded to 1 ms
  // and kept rising.
  //   errors  kBadInput wrong size or type; kIo disk full
  Status Write(const cv::Mat& image, double time);

  // Ends the file. Without it (a crash) the frames so far can still be read.
  Status Close();

  ~VideoWriter();
  VideoWriter(VideoWriter&&) noexcept;
  VideoWriter& operator=(VideoWriter&&) noexcept;

 private:
  struct State;
  explicit VideoWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

struct VideoFrame {
  std::int64_t index = 0;
  double time = 0;  // s, as the file says
  cv::Mat image;    // CV_8UC1
};

class VideoReader {
 public:
  //   errors  kNotFound no such file; kBadInput an empty file, no video in it, a codec that is not known
  static Result<VideoReader> Open(const std::filesystem::path& file);

  // The next frame; none at the end.
  //   errors  kBadInput a frame is damaged (named); the Matroska file is shorter than it says itself (how
  //   many
  //           frames are whole)
  Result<std::optional<VideoFrame>> Next();

  int width_px() const;
  int height_px() const;

  ~VideoReader();
  VideoReader(VideoReader&&) noexcept;
  VideoReader& operator=(VideoReader&&) noexcept;

 private:
  struct State;
  explicit VideoReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace tendril
