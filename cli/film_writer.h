#pragma once
// A film that browsers play: H.264 in MP4, 4:2:0, the index at the file's beginning. Where libavcodec has no
// H.264 encoder, MPEG-4 (which browsers may refuse).
//
// Recordings are not written by this: it is lossy (capture/record/video_file.h is not).

#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>

#include "model/result.h"

namespace tendril::cli {

class FilmWriter {
 public:
  // Creates the file; it replaces one that is there.
  //   width_px, height_px  even, 16 .. 8192
  //   errors  kBadInput a size that is not; kIo no encoder, the file cannot be made
  static Result<FilmWriter> Open(const std::filesystem::path& file, int width_px, int height_px);

  // image: CV_8UC3 (blue, green, red) of the size given. time: s since the film began, rounded to 1/90000 s
  // and kept rising; a frame is shown until the next.
  //   errors  kBadInput wrong size or type; kIo disk full
  Status Write(const cv::Mat& image, double time);

  // Ends the file; without it the file cannot be played.
  Status Close();

  ~FilmWriter();
  FilmWriter(FilmWriter&&) noexcept;
  FilmWriter& operator=(FilmWriter&&) noexcept;

 private:
  struct State;
  explicit FilmWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace tendril::cli
