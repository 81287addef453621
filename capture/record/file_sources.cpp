#include "capture/record/file_sources.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <system_error>
#include <utility>
#include <vector>

#include "capture/record/picture_file.h"
#include "capture/record/video_file.h"

namespace tendril {
namespace {

namespace fs = std::filesystem;

class VideoSource : public FrameSource {
 public:
  VideoSource(fs::path file, VideoReader reader, std::optional<std::vector<FrameRow>> log)
      : file_(std::move(file)), reader_(std::move(reader)), log_(std::move(log)) {}

  bool paced() const override { return true; }
  std::optional<std::int64_t> frames() const override {
    if (!log_) return std::nullopt;
    return static_cast<std::int64_t>(log_->size());
  }
  std::optional<std::int64_t> first_host_ns() const override {
    if (!log_ || log_->empty()) return std::nullopt;
    return log_->front().host_ns;
  }

  Result<std::optional<SourceFrame>> Next() override {
    Result<std::optional<VideoFrame>> next = reader_.Next();
    if (!next.ok()) return next.error();
    const std::size_t index = read_++;
    if (!next.value()) {
      if (log_ && index < log_->size()) {
        return Error{ErrorKind::kBadInput,
                     fmt::format("{}: {} pictures, but its log has {} rows; expected one each",
                                 file_.string(), index, log_->size())};
      }
      return std::optional<SourceFrame>();
    }
    SourceFrame frame;
    frame.image = next.value()->image;
    frame.time = next.value()->time;
    frame.frame_id = static_cast<std::int64_t>(index);
    frame.device_ns = std::llround(1e9 * frame.time);
    if (log_) {
      if (index >= log_->size()) {
        return Error{ErrorKind::kBadInput,
                     fmt::format("{}: more pictures than the {} rows of its log; expected one "
                                 "each",
                                 file_.string(), log_->size())};
      }
      const FrameRow& row = (*log_)[index];
      frame.frame_id = row.frame_id;
      frame.device_ns = row.device_ns;
      frame.host_ns = row.host_ns;
      frame.status = row.status;
    }
    return std::optional<SourceFrame>(std::move(frame));
  }

 private:
  fs::path file_;
  VideoReader reader_;
  std::optional<std::vector<FrameRow>> log_;
  std::size_t read_ = 0;
};

class ImageSource : public FrameSource {
 public:
  ImageSource(std::vector<fs::path> files, double interval) : files_(std::move(files)), interval_(interval) {}

  bool paced() const override { return true; }
  std::optional<std::int64_t> frames() const override { return static_cast<std::int64_t>(files_.size()); }

  Result<std::optional<SourceFrame>> Next() override {
    if (read_ == files_.size()) return std::optional<SourceFrame>();
    const fs::path& file = files_[read_];
    Result<cv::Mat> gray = ReadGrayPicture(file);
    if (!gray.ok()) return gray.error();
    SourceFrame frame;
    frame.image = std::move(gray).value();
    if (read_ == 0) size_ = frame.image.size();
    if (frame.image.size() != size_) {
      return Error{ErrorKind::kBadInput,
                   fmt::format("{}: {} x {} px; expected {} x {} px as the first picture", file.string(),
                               frame.image.cols, frame.image.rows, size_.width, size_.height)};
    }
    frame.frame_id = static_cast<std::int64_t>(read_);
    frame.time = interval_ * static_cast<double>(read_);
    frame.device_ns = std::llround(1e9 * frame.time);
    ++read_;
    return std::optional<SourceFrame>(std::move(frame));
  }

 private:
  std::vector<fs::path> files_;
  double interval_;
  cv::Size size_;
  std::size_t read_ = 0;
};

class ServoFileSource : public ServoSource {
 public:
  explicit ServoFileSource(std::vector<ServoRow> rows) : rows_(std::move(rows)) {}

  Result<std::optional<ServoSample>> Next() override {
    if (read_ == rows_.size()) return std::optional<ServoSample>();
    ServoSample sample;
    sample.row = rows_[read_++];
    return std::optional<ServoSample>(sample);
  }
  std::optional<std::int64_t> first_host_ns() const override {
    if (rows_.empty()) return std::nullopt;
    return rows_.front().host_ns;
  }

 private:
  std::vector<ServoRow> rows_;
  std::size_t read_ = 0;
};

}  // namespace

Result<std::unique_ptr<FrameSource>> MakeVideoSource(const fs::path& file) {
  Result<VideoReader> reader = VideoReader::Open(file);
  if (!reader.ok()) return reader.error();
  std::optional<std::vector<FrameRow>> log;
  const fs::path beside = fs::path(file).replace_extension(".csv");
  std::error_code ignored;
  if (fs::exists(beside, ignored)) {
    Result<std::vector<FrameRow>> rows = ReadFrameLog(beside);
    if (!rows.ok()) return rows.error();
    log = std::move(rows).value();
  }
  return std::unique_ptr<FrameSource>(
      std::make_unique<VideoSource>(file, std::move(reader).value(), std::move(log)));
}

Result<std::unique_ptr<FrameSource>> MakeImageSource(const fs::path& folder, double interval) {
  if (!(interval > 0) || interval > 1e6) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("an interval of {} s; expected above 0 and up to 1e6", interval)};
  }
  std::error_code failed;
  std::vector<fs::path> files;
  for (auto it = fs::directory_iterator(folder, failed); !failed && it != fs::directory_iterator();
       it.increment(failed)) {
    if (IsPictureFile(it->path())) files.push_back(it->path());
  }
  if (failed) {
    return Error{ErrorKind::kNotFound,
                 fmt::format("{}: {}; expected a folder of pictures", folder.string(), failed.message())};
  }
  if (files.empty()) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("{}: no pictures; expected png, jpg, bmp, pgm or tif", folder.string())};
  }
  std::sort(files.begin(), files.end());
  return std::unique_ptr<FrameSource>(std::make_unique<ImageSource>(std::move(files), interval));
}

Result<std::unique_ptr<ServoSource>> MakeServoFileSource(const fs::path& file) {
  Result<std::vector<ServoRow>> rows = ReadServoLog(file);
  if (!rows.ok()) return rows.error();
  return std::unique_ptr<ServoSource>(std::make_unique<ServoFileSource>(std::move(rows).value()));
}

}  // namespace tendril
