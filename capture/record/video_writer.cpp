#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "capture/record/libav.h"
#include "capture/record/video_file.h"

namespace tendril {
namespace {

struct FreeMuxer {
  void operator()(AVFormatContext* context) const {
    if (context->pb != nullptr) avio_closep(&context->pb);
    avformat_free_context(context);
  }
};

Error Failed(const std::filesystem::path& file, const char* deed, int code) {
  return {ErrorKind::kIo, fmt::format("{}: {}: {}", file.string(), deed, libav::TextOf(code))};
}

}  // namespace

struct VideoWriter::State {
  std::filesystem::path file;
  std::unique_ptr<AVFormatContext, FreeMuxer> muxer;
  libav::Codec codec;
  libav::Frame frame;
  libav::Packet packet;
  AVStream* stream = nullptr;  // the muxer's
  std::int64_t last_ms = -1;
  bool closed = false;

  // Hands on what the codec has ready.
  Status Drain() {
    while (true) {
      const int got = avcodec_receive_packet(codec.get(), packet.get());
      if (got == AVERROR(EAGAIN) || got == AVERROR_EOF) return Ok{};
      if (got < 0) return Failed(file, "the picture could not be encoded", got);
      av_packet_rescale_ts(packet.get(), codec->time_base, stream->time_base);
      packet->stream_index = stream->index;
      const int written = av_write_frame(muxer.get(), packet.get());
      av_packet_unref(packet.get());
      if (written < 0) return Failed(file, "the picture could not be written", written);
      // Ends the cluster, which is held in memory until then: a crash loses no frame.
      const int flushed = av_write_frame(muxer.get(), nullptr);
      if (flushed < 0) return Failed(file, "the picture could not be written", flushed);
      if (muxer->pb->error < 0) return Failed(file, "the picture could not be written", muxer->pb->error);
    }
  }
};

VideoWriter::VideoWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
VideoWriter::~VideoWriter() = default;
VideoWriter::VideoWriter(VideoWriter&&) noexcept = default;
VideoWriter& VideoWriter::operator=(VideoWriter&&) noexcept = default;

Result<VideoWriter> VideoWriter::Open(const std::filesystem::path& file, int width_px, int height_px) {
  libav::Silence();
  if (width_px < 16 || height_px < 16 || width_px > 32768 || height_px > 32768) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("{}: pictures of {} x {} px; expected 16 .. 32768 each (FFV1 fails below)",
                             file.string(), width_px, height_px)};
  }
  auto state = std::make_unique<State>();
  state->file = file;
  AVFormatContext* muxer = nullptr;
  int code = avformat_alloc_output_context2(&muxer, nullptr, "matroska", file.c_str());
  if (code < 0) return Failed(file, "cannot write Matroska", code);
  state->muxer.reset(muxer);
  muxer->flags |= AVFMT_FLAG_BITEXACT | AVFMT_FLAG_FLUSH_PACKETS;

  const AVCodec* ffv1 = avcodec_find_encoder(AV_CODEC_ID_FFV1);
  if (ffv1 == nullptr) {
    return Error{ErrorKind::kIo, "this libavcodec has no FFV1 encoder; expected Debian's libavcodec59"};
  }
  state->codec.reset(avcodec_alloc_context3(ffv1));
  AVCodecContext* codec = state->codec.get();
  codec->width = width_px;
  codec->height = height_px;
  codec->pix_fmt = AV_PIX_FMT_GRAY8;
  codec->color_range = AVCOL_RANGE_JPEG;  // 0 .. 255
  codec->time_base = {1, 1000};
  codec->gop_size = 1;
  codec->level = 3;
  codec->slices = 4;
  codec->thread_count = 1;
  codec->flags |= AV_CODEC_FLAG_BITEXACT;
  if ((muxer->oformat->flags & AVFMT_GLOBALHEADER) != 0) codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  AVDictionary* options = nullptr;
  av_dict_set(&options, "slicecrc", "1", 0);
  av_dict_set(&options, "coder", "rice", 0);  // a third faster than the range coder, files a few % larger
  code = avcodec_open2(codec, ffv1, &options);
  av_dict_free(&options);
  if (code < 0) return Failed(file, "the encoder does not start", code);

  state->stream = avformat_new_stream(muxer, nullptr);
  state->stream->time_base = codec->time_base;
  avcodec_parameters_from_context(state->stream->codecpar, codec);
  code = avio_open(&muxer->pb, file.c_str(), AVIO_FLAG_WRITE);
  if (code < 0) return Failed(file, "the file cannot be made", code);
  av_dict_set(&muxer->metadata, libav::kOurTag, "1", 0);
  code = avformat_write_header(muxer, nullptr);
  if (code < 0) return Failed(file, "the header could not be written", code);

  state->frame.reset(av_frame_alloc());
  state->frame->format = AV_PIX_FMT_GRAY8;
  state->frame->width = width_px;
  state->frame->height = height_px;
  code = av_frame_get_buffer(state->frame.get(), 0);
  if (code < 0) return Failed(file, "no memory for a picture", code);
  state->packet.reset(av_packet_alloc());
  return VideoWriter(std::move(state));
}

Status VideoWriter::Write(const cv::Mat& image, double time) {
  State& s = *state_;
  if (image.type() != CV_8UC1 || image.cols != s.codec->width || image.rows != s.codec->height) {
    return Error{
        ErrorKind::kBadInput,
        fmt::format("{}: a picture of {} x {} px, {} bytes per px; expected {} x {} px of 8-bit gray",
                    s.file.string(), image.cols, image.rows, image.empty() ? 0 : image.elemSize(),
                    s.codec->width, s.codec->height)};
  }
  if (!std::isfinite(time) || std::abs(time) > 1e12) {
    return Error{ErrorKind::kBadInput, fmt::format("{}: a frame at {} s", s.file.string(), time)};
  }
  const int writable = av_frame_make_writable(s.frame.get());
  if (writable < 0) return Failed(s.file, "no memory for a picture", writable);
  for (int row = 0; row < image.rows; ++row) {
    std::memcpy(s.frame->data[0] + static_cast<std::ptrdiff_t>(row) * s.frame->linesize[0], image.ptr(row),
                static_cast<std::size_t>(image.cols));
  }
  s.last_ms = std::max<std::int64_t>(s.last_ms + 1, std::llround(1000 * time));
  s.frame->pts = s.last_ms;
  const int sent = avcodec_send_frame(s.codec.get(), s.frame.get());
  if (sent < 0) return Failed(s.file, "the picture could not be encoded", sent);
  return s.Drain();
}

Status VideoWriter::Close() {
  State& s = *state_;
  if (s.closed) return Ok{};
  s.closed = true;
  avcodec_send_frame(s.codec.get(), nullptr);
  if (Status status = s.Drain(); !status.ok()) return status;
  const int code = av_write_trailer(s.muxer.get());
  if (code < 0) return Failed(s.file, "the file could not be ended", code);
  const int flushed = avio_closep(&s.muxer->pb);
  if (flushed < 0) return Failed(s.file, "the file could not be ended", flushed);
  return Ok{};
}

}  // namespace tendril
