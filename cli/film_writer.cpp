#include "cli/film_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "capture/record/libav.h"

extern "C" {
#include <libswscale/swscale.h>
}

namespace tendril::cli {
namespace {

constexpr int kTicks = 90000;  // per second

struct FreeMuxer {
  void operator()(AVFormatContext* context) const {
    if (context->pb != nullptr) avio_closep(&context->pb);
    avformat_free_context(context);
  }
};

struct FreeScaler {
  void operator()(SwsContext* context) const { sws_freeContext(context); }
};

Error Failed(const std::filesystem::path& file, const char* deed, int code) {
  return {ErrorKind::kIo, fmt::format("{}: {}: {}", file.string(), deed, libav::TextOf(code))};
}

// The first encoder that is there and starts.
libav::Codec StartEncoder(int width_px, int height_px, bool global_header) {
  for (const char* name : {"libx264", "libopenh264", "mpeg4"}) {
    const AVCodec* encoder = avcodec_find_encoder_by_name(name);
    if (encoder == nullptr) continue;
    libav::Codec codec(avcodec_alloc_context3(encoder));
    codec->width = width_px;
    codec->height = height_px;
    codec->pix_fmt = AV_PIX_FMT_YUV420P;
    codec->color_range = AVCOL_RANGE_MPEG;
    codec->colorspace = AVCOL_SPC_BT709;
    codec->color_primaries = AVCOL_PRI_BT709;
    codec->color_trc = AVCOL_TRC_BT709;
    // MPEG-4's header has room for 16 bits.
    codec->time_base = encoder->id == AV_CODEC_ID_MPEG4 ? AVRational{1, 60000} : AVRational{1, kTicks};
    codec->framerate = {
        60, 1};  // at most; from the ticks alone x264 would ask for a decoder of the highest level
    codec->gop_size = 60;
    codec->max_b_frames = 0;  // frames in their order: the film begins at 0 without an edit list
    codec->thread_count = 1;  // x264's bytes depend on it
    codec->flags |= AV_CODEC_FLAG_BITEXACT;
    if (global_header) codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    AVDictionary* options = nullptr;
    if (encoder->id == AV_CODEC_ID_H264) {
      av_dict_set(&options, "preset", "fast", 0);
      av_dict_set(&options, "crf", "17", 0);
    }
    if (encoder->id != AV_CODEC_ID_H264 || std::string_view(name) != "libx264") {
      codec->bit_rate = static_cast<std::int64_t>(width_px) * height_px * 8;
    }
    const int code = avcodec_open2(codec.get(), encoder, &options);
    av_dict_free(&options);
    if (code >= 0) return codec;
  }
  return nullptr;
}

}  // namespace

struct FilmWriter::State {
  std::filesystem::path file;
  std::unique_ptr<AVFormatContext, FreeMuxer> muxer;
  libav::Codec codec;
  std::unique_ptr<SwsContext, FreeScaler> scaler;
  libav::Frame frame;
  libav::Packet packet;
  AVStream* stream = nullptr;  // the muxer's
  // In ticks of the codec: the last frame's time, and how long the one before it was shown.
  std::int64_t last = -1;
  std::int64_t shown = 0;

  Status Drain() {
    while (true) {
      const int got = avcodec_receive_packet(codec.get(), packet.get());
      if (got == AVERROR(EAGAIN) || got == AVERROR_EOF) return Ok{};
      if (got < 0) return Failed(file, "the picture could not be encoded", got);
      // Counts for the last frame only: a player leaves out one that is shown for no time.
      packet->duration = shown > 0 ? shown : codec->time_base.den / 30;
      av_packet_rescale_ts(packet.get(), codec->time_base, stream->time_base);
      packet->stream_index = stream->index;
      const int written = av_interleaved_write_frame(muxer.get(), packet.get());
      if (written < 0) return Failed(file, "the picture could not be written", written);
    }
  }
};

FilmWriter::FilmWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
FilmWriter::~FilmWriter() = default;
FilmWriter::FilmWriter(FilmWriter&&) noexcept = default;
FilmWriter& FilmWriter::operator=(FilmWriter&&) noexcept = default;

Result<FilmWriter> FilmWriter::Open(const std::filesystem::path& file, int width_px, int height_px) {
  libav::Silence();
  const auto fits = [](int size) { return size >= 16 && size <= 8192 && size % 2 == 0; };
  if (!fits(width_px) || !fits(height_px)) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("{}: pictures of {} x {} px; expected even, 16 .. 8192 each", file.string(),
                             width_px, height_px)};
  }
  auto state = std::make_unique<State>();
  state->file = file;
  AVFormatContext* muxer = nullptr;
  int code = avformat_alloc_output_context2(&muxer, nullptr, "mp4", file.c_str());
  if (code < 0) return Failed(file, "cannot write MP4", code);
  state->muxer.reset(muxer);
  muxer->flags |= AVFMT_FLAG_BITEXACT;
  state->codec = StartEncoder(width_px, height_px, (muxer->oformat->flags & AVFMT_GLOBALHEADER) != 0);
  if (!state->codec) {
    return Error{ErrorKind::kIo,
                 "no encoder for H.264 or MPEG-4 in this libavcodec; expected Debian's libavcodec59"};
  }
  state->stream = avformat_new_stream(muxer, nullptr);
  state->stream->time_base = state->codec->time_base;
  avcodec_parameters_from_context(state->stream->codecpar, state->codec.get());
  code = avio_open(&muxer->pb, file.c_str(), AVIO_FLAG_WRITE);
  if (code < 0) return Failed(file, "the file cannot be made", code);
  AVDictionary* options = nullptr;
  av_dict_set(&options, "movflags", "+faststart", 0);
  code = avformat_write_header(muxer, &options);
  av_dict_free(&options);
  if (code < 0) return Failed(file, "the header could not be written", code);

  state->scaler.reset(sws_getContext(width_px, height_px, AV_PIX_FMT_BGR24, width_px, height_px,
                                     AV_PIX_FMT_YUV420P, SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INP,
                                     nullptr, nullptr, nullptr));
  if (!state->scaler) return Error{ErrorKind::kIo, file.string() + ": no conversion to 4:2:0"};
  const int* const bt709 = sws_getCoefficients(SWS_CS_ITU709);
  sws_setColorspaceDetails(state->scaler.get(), bt709, 1, bt709, 0, 0, 1 << 16, 1 << 16);
  state->frame.reset(av_frame_alloc());
  state->frame->format = AV_PIX_FMT_YUV420P;
  state->frame->width = width_px;
  state->frame->height = height_px;
  code = av_frame_get_buffer(state->frame.get(), 0);
  if (code < 0) return Failed(file, "no memory for a picture", code);
  state->packet.reset(av_packet_alloc());
  return FilmWriter(std::move(state));
}

Status FilmWriter::Write(const cv::Mat& image, double time) {
  State& s = *state_;
  if (image.type() != CV_8UC3 || image.cols != s.codec->width || image.rows != s.codec->height ||
      !std::isfinite(time) || std::abs(time) > 1e9) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("{}: a picture of {} x {} px at {} s; expected {} x {} px of 8-bit colour",
                             s.file.string(), image.cols, image.rows, time, s.codec->width, s.codec->height)};
  }
  const int writable = av_frame_make_writable(s.frame.get());
  if (writable < 0) return Failed(s.file, "no memory for a picture", writable);
  const std::uint8_t* const from[1] = {image.data};
  const int from_stride[1] = {static_cast<int>(image.step[0])};
  sws_scale(s.scaler.get(), from, from_stride, 0, image.rows, s.frame->data, s.frame->linesize);
  const std::int64_t at = std::max<std::int64_t>(s.last + 1, std::llround(time * s.codec->time_base.den));
  if (s.last >= 0) s.shown = at - s.last;
  s.last = at;
  s.frame->pts = s.last;
  const int sent = avcodec_send_frame(s.codec.get(), s.frame.get());
  if (sent < 0) return Failed(s.file, "the picture could not be encoded", sent);
  return s.Drain();
}

Status FilmWriter::Close() {
  State& s = *state_;
  avcodec_send_frame(s.codec.get(), nullptr);
  if (Status status = s.Drain(); !status.ok()) return status;
  const int code = av_write_trailer(s.muxer.get());
  if (code < 0) return Failed(s.file, "the file could not be ended", code);
  const int flushed = avio_closep(&s.muxer->pb);
  if (flushed < 0) return Failed(s.file, "the file could not be ended", flushed);
  return Ok{};
}

}  // namespace tendril::cli
