// What libavformat reads: a network stream, a named pipe, a video file at its own pace.
#include <fcntl.h>
#include <fmt/core.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

#include "capture/record/gray_frame.h"
#include "capture/record/libav.h"
#include "capture/record/live_kinds.h"

namespace tendril {
namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

struct FreeAvio {
  void operator()(AVIOContext* io) const {
    av_freep(static_cast<void*>(&io->buffer));
    avio_context_free(&io);
  }
};

class LiveStream : public LiveSource {
 public:
  LiveStream(std::string name, StreamKind kind, LiveSourceOptions options)
      : name_(std::move(name)), kind_(kind), options_(std::move(options)) {}
  LiveStream(const LiveStream&) = delete;
  LiveStream& operator=(const LiveStream&) = delete;
  ~LiveStream() override {
    demuxer_.reset();  // before the pipe that it reads
    if (pipe_ >= 0) close(pipe_);
  }

  Status Open();
  Result<std::optional<cv::Mat>> Next() override;

 private:
  static int Interrupted(void* self) { return static_cast<LiveStream*>(self)->MustEnd() ? 1 : 0; }
  static int ReadPipe(void* self, std::uint8_t* buffer, int size) {
    return static_cast<LiveStream*>(self)->ReadPipe(buffer, size);
  }
  int ReadPipe(std::uint8_t* buffer, int size);
  Status OpenPipe();
  void Allow(double seconds) {
    allowed_ = seconds;
    deadline_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(Seconds(seconds));
  }
  bool MustEnd() const { return options_.stopped() || Clock::now() > deadline_; }
  Error Failed(int code, const char* doing) const;
  Status Wait(double until) const;

  std::string name_;
  StreamKind kind_;
  LiveSourceOptions options_;
  double allowed_ = 0;
  Clock::time_point deadline_;
  int pipe_ = -1;
  bool pipe_began_ = false;
  std::unique_ptr<AVIOContext, FreeAvio> io_;
  libav::Demuxer demuxer_;
  libav::Codec codec_;
  libav::Frame frame_;
  libav::Packet packet_;
  libav::GrayFrames gray_;
  int stream_ = 0;
  bool drained_ = false;
  std::optional<std::pair<double, Clock::time_point>> began_;  // a file's first time, and when it was shown
};

Error LiveStream::Failed(int code, const char* doing) const {
  if (options_.stopped()) return {ErrorKind::kStopped, name_ + ": stopped"};
  if (code == AVERROR_EXIT || Clock::now() > deadline_) {
    return {ErrorKind::kIo,
            fmt::format("{}: nothing arrived for {:g} s; expected a camera that sends", name_, allowed_)};
  }
  if (code == AVERROR_EOF) return {ErrorKind::kIo, name_ + ": the stream ended"};
  if (code == AVERROR_PROTOCOL_NOT_FOUND) {
    return {ErrorKind::kBadInput,
            name_ + ": a protocol that libavformat does not know; expected rtsp, udp, tcp, http, ..."};
  }
  if (code == AVERROR_INVALIDDATA || code == AVERROR_DEMUXER_NOT_FOUND || code == AVERROR_STREAM_NOT_FOUND ||
      code == AVERROR_DECODER_NOT_FOUND) {
    return {ErrorKind::kBadInput, fmt::format("{}: no video that libav can decode in it", name_)};
  }
  return {ErrorKind::kIo, fmt::format("{}: {} failed ({})", name_, doing, libav::TextOf(code))};
}

// open() on a pipe waits for its writer and can't be stopped; so without waiting, and poll() for data.
Status LiveStream::OpenPipe() {
  pipe_ = open(name_.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (pipe_ < 0) return Failed(AVERROR(errno), "opening");
  constexpr int kBuffer = 1 << 16;
  io_.reset(avio_alloc_context(static_cast<unsigned char*>(av_malloc(kBuffer)), kBuffer, 0, this, &ReadPipe,
                               nullptr, nullptr));
  return Ok{};
}

int LiveStream::ReadPipe(std::uint8_t* buffer, int size) {
  while (!MustEnd()) {
    pollfd waiting{.fd = pipe_, .events = POLLIN, .revents = 0};
    if (poll(&waiting, 1, 50) < 0 && errno != EINTR) return AVERROR(errno);
    const ssize_t got = read(pipe_, buffer, static_cast<std::size_t>(size));
    if (got > 0) {
      pipe_began_ = true;
      return static_cast<int>(got);
    }
    if (got == 0 && pipe_began_) return AVERROR_EOF;
    if (got < 0 && errno != EAGAIN && errno != EINTR) return AVERROR(errno);
    // No writer yet: poll() does not wait then.
    if (got == 0) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return AVERROR_EXIT;
}

Status LiveStream::Open() {
  libav::Silence();
  Allow(options_.open_wait);
  AVFormatContext* demuxer = avformat_alloc_context();
  demuxer->interrupt_callback = {&Interrupted, this};
  // Nothing is asked about the frame rate, which a slow stream tells only after seconds.
  demuxer->max_analyze_duration = AV_TIME_BASE;
  demuxer->fps_probe_size = 0;
  if (kind_ == StreamKind::kPipe) {
    if (Status s = OpenPipe(); !s.ok()) {
      avformat_free_context(demuxer);
      return s;
    }
    demuxer->pb = io_.get();
  }
  // "file:" so that a name with a colon is no protocol.
  const std::string url = kind_ == StreamKind::kFile ? "file:" + name_ : name_;
  if (kind_ == StreamKind::kNetwork) avformat_network_init();
  int code = avformat_open_input(&demuxer, url.c_str(), nullptr, nullptr);
  if (code < 0) return Failed(code, "opening");
  demuxer_.reset(demuxer);
  code = avformat_find_stream_info(demuxer, nullptr);
  if (code < 0) return Failed(code, "reading its streams");
  const AVCodec* decoder = nullptr;
  stream_ = av_find_best_stream(demuxer, AVMEDIA_TYPE_VIDEO, -1, -1, &decoder, 0);
  if (stream_ < 0 || decoder == nullptr || demuxer->streams[stream_]->codecpar->width < 1) {
    return Failed(MustEnd() ? AVERROR_EXIT : AVERROR_STREAM_NOT_FOUND, "reading its streams");
  }
  codec_.reset(avcodec_alloc_context3(decoder));
  avcodec_parameters_to_context(codec_.get(), demuxer->streams[stream_]->codecpar);
  codec_->thread_count = 1;  // several hold pictures back
  codec_->flags |= AV_CODEC_FLAG_LOW_DELAY;
  code = avcodec_open2(codec_.get(), decoder, nullptr);
  if (code < 0) return Failed(code, "starting its codec");
  frame_.reset(av_frame_alloc());
  packet_.reset(av_packet_alloc());
  return Ok{};
}

// Sleeps until a file's picture is due, s on the file's clock.
Status LiveStream::Wait(double time) const {
  if (!began_) return Ok{};
  const auto due =
      began_->second + std::chrono::duration_cast<Clock::duration>(Seconds(time - began_->first));
  while (Clock::now() < due) {
    if (options_.stopped()) return Error{ErrorKind::kStopped, name_ + ": stopped"};
    std::this_thread::sleep_for(std::min<Clock::duration>(due - Clock::now(), std::chrono::milliseconds(50)));
  }
  return Ok{};
}

Result<std::optional<cv::Mat>> LiveStream::Next() {
  Allow(options_.silence);
  while (true) {
    if (MustEnd()) return Failed(AVERROR_EXIT, "reading");
    const int got = avcodec_receive_frame(codec_.get(), frame_.get());
    if (got == 0) break;
    if (got == AVERROR_EOF) {
      if (kind_ == StreamKind::kFile) return std::optional<cv::Mat>();
      return Failed(AVERROR_EOF, "reading");
    }
    const int code = av_read_frame(demuxer_.get(), packet_.get());
    if (code < 0) {
      // A file that is cut off ends there: recordings are judged by their reader, not here.
      if (code != AVERROR_EOF && kind_ != StreamKind::kFile) return Failed(code, "reading");
      if (drained_) return Failed(AVERROR_EOF, "reading");
      drained_ = true;
      avcodec_send_packet(codec_.get(), nullptr);
      continue;
    }
    // A damaged picture of a live stream is passed over: the next one is on its way.
    if (packet_->stream_index == stream_) avcodec_send_packet(codec_.get(), packet_.get());
    av_packet_unref(packet_.get());
  }
  Result<cv::Mat> image = gray_.Of(*frame_);
  if (!image.ok()) return Error(image.error()).Within(name_);
  if (kind_ == StreamKind::kFile && frame_->best_effort_timestamp != AV_NOPTS_VALUE) {
    const AVRational base = demuxer_->streams[stream_]->time_base;
    const double time = static_cast<double>(frame_->best_effort_timestamp) * base.num / base.den;
    if (!began_) began_.emplace(time, Clock::now());
    if (const Status s = Wait(time); !s.ok()) return s.error();
  }
  return std::optional<cv::Mat>(std::move(image).value());
}

}  // namespace

Result<std::unique_ptr<LiveSource>> OpenLiveStream(const std::string& source, StreamKind kind,
                                                   const LiveSourceOptions& options) {
  auto stream = std::make_unique<LiveStream>(source, kind, options);
  if (Status s = stream->Open(); !s.ok()) return s.error();
  return std::unique_ptr<LiveSource>(std::move(stream));
}

}  // namespace tendril
