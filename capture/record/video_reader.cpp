#include <fmt/core.h>

extern "C" {
#include <libavutil/crc.h>
#include <libavutil/dict.h>
#include <libavutil/intreadwrite.h>
}

#include <array>
#include <fstream>
#include <system_error>
#include <utility>

#include "capture/record/gray_frame.h"
#include "capture/record/libav.h"
#include "capture/record/video_file.h"

namespace tendril {
namespace {

Error Bad(const std::filesystem::path& file, const std::string& what) {
  return {ErrorKind::kBadInput, fmt::format("{}: {}", file.string(), what)};
}

// One of EBML's numbers of variable length: its first byte's leading zeros say how many bytes follow.
std::optional<std::uint64_t> ReadEbmlNumber(std::istream& in, bool keep_marker) {
  const int first = in.get();
  if (first <= 0) return std::nullopt;
  int more = 0;
  while ((first & (0x80 >> more)) == 0) ++more;
  auto value = static_cast<std::uint64_t>(keep_marker ? first : first & (0x7F >> more));
  bool unknown = !keep_marker && value == static_cast<std::uint64_t>(0x7F >> more);
  for (int i = 0; i < more; ++i) {
    const int next = in.get();
    if (next < 0) return std::nullopt;
    unknown = unknown && next == 0xFF;
    value = value << 8 | static_cast<std::uint64_t>(next);
  }
  if (unknown) return std::nullopt;
  return value;
}

// How many bytes a Matroska file must have by its own account: header, then one segment that states its size.
// None for other files, and where the size was never filled in (the recorder crashed).
std::optional<std::uint64_t> MatroskaBytes(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (ReadEbmlNumber(in, true) != 0x1A45DFA3U) return std::nullopt;
  const auto header = ReadEbmlNumber(in, false);
  if (!header || *header > 1000000) return std::nullopt;
  in.seekg(static_cast<std::streamoff>(*header), std::ios::cur);
  if (ReadEbmlNumber(in, true) != 0x18538067U) return std::nullopt;
  const auto segment = ReadEbmlNumber(in, false);
  if (!segment) return std::nullopt;
  return static_cast<std::uint64_t>(in.tellg()) + *segment;
}

// Whether every slice of an FFV1 (version 3) picture agrees with its checksum. libav's decoder only logs a
// wrong one and shows the slice of the picture before. From the end: 3 bytes of size, 1 of status, 4 of CRC.
bool SlicesAreWhole(const std::uint8_t* data, int size) {
  constexpr int kTrailer = 8;
  while (size > 0) {
    if (size < kTrailer) return false;
    const int slice = static_cast<int>(AV_RB24(data + size - kTrailer)) + kTrailer;
    if (slice > size) return false;
    size -= slice;
    if (av_crc(av_crc_get_table(AV_CRC_32_IEEE), 0, data + size, static_cast<std::size_t>(slice)) != 0)
      return false;
  }
  return true;
}

}  // namespace

struct VideoReader::State {
  std::filesystem::path file;
  libav::Demuxer demuxer;
  libav::Codec codec;
  libav::Frame frame;
  libav::Packet packet;
  libav::GrayFrames gray;
  int stream = 0;
  bool drained = false;
  std::int64_t read = 0;    // frames so far
  double last_time = 0;     // s
  bool checksums = false;   // every slice carries one
  std::uint64_t bytes = 0;  // of the file

  Error Damaged(const std::string& how) const {
    return Bad(
        file, read == 0 ? fmt::format("its first frame is damaged ({})", how)
                        : fmt::format("frame {} is damaged ({}); the frames before it are whole", read, how));
  }

  // Reads one packet and hands it to the codec; false at the end of the file.
  Result<bool> Feed();
};

Result<bool> VideoReader::State::Feed() {
  while (true) {
    const int code = av_read_frame(demuxer.get(), packet.get());
    if (code == AVERROR_EOF) {
      if (demuxer->pb != nullptr && demuxer->pb->error < 0 && demuxer->pb->error != AVERROR_EOF) {
        return Damaged(libav::TextOf(demuxer->pb->error));
      }
      avcodec_send_packet(codec.get(), nullptr);
      return false;
    }
    if (code < 0) return Damaged(libav::TextOf(code));
    if (packet->stream_index != stream) {
      av_packet_unref(packet.get());
      continue;
    }
    const bool corrupt = (packet->flags & AV_PKT_FLAG_CORRUPT) != 0;
    const bool whole = !checksums || SlicesAreWhole(packet->data, packet->size);
    const int sent = avcodec_send_packet(codec.get(), packet.get());
    av_packet_unref(packet.get());
    if (corrupt) return Damaged("its data is cut off");
    if (!whole) return Damaged("a checksum is wrong");
    if (sent < 0) return Damaged(libav::TextOf(sent));
    return true;
  }
}

VideoReader::VideoReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
VideoReader::~VideoReader() = default;
VideoReader::VideoReader(VideoReader&&) noexcept = default;
VideoReader& VideoReader::operator=(VideoReader&&) noexcept = default;

int VideoReader::width_px() const { return state_->codec->width; }
int VideoReader::height_px() const { return state_->codec->height; }

Result<VideoReader> VideoReader::Open(const std::filesystem::path& file) {
  libav::Silence();
  std::error_code failed;
  const auto size = std::filesystem::file_size(file, failed);
  if (failed) {
    return Error{ErrorKind::kNotFound,
                 fmt::format("{}: {}; expected a video file", file.string(), failed.message())};
  }
  if (size == 0) return Bad(file, "an empty file; expected a video");
  auto state = std::make_unique<State>();
  state->file = file;
  AVFormatContext* demuxer = nullptr;
  // "file:" so that a name with a colon is no protocol.
  int code = avformat_open_input(&demuxer, ("file:" + file.string()).c_str(), nullptr, nullptr);
  if (code < 0)
    return Bad(file,
               fmt::format("not a video ({}); expected Matroska or another video file", libav::TextOf(code)));
  state->demuxer.reset(demuxer);
  code = avformat_find_stream_info(demuxer, nullptr);
  if (code < 0) return Bad(file, fmt::format("its streams cannot be read ({})", libav::TextOf(code)));
  const AVCodec* decoder = nullptr;
  state->stream = av_find_best_stream(demuxer, AVMEDIA_TYPE_VIDEO, -1, -1, &decoder, 0);
  if (state->stream < 0 || decoder == nullptr) return Bad(file, "no video that libav can decode in it");
  const AVStream& stream = *demuxer->streams[state->stream];
  // Text and single pictures pass as "videos" for libav.
  if (stream.codecpar->width < 1 || stream.codecpar->height < 1)
    return Bad(file, "not a video: its pictures have no size");

  state->codec.reset(avcodec_alloc_context3(decoder));
  avcodec_parameters_to_context(state->codec.get(), stream.codecpar);
  state->codec->thread_count = 1;
  state->codec->err_recognition = AV_EF_CRCCHECK | AV_EF_EXPLODE;
  code = avcodec_open2(state->codec.get(), decoder, nullptr);
  if (code < 0) return Bad(file, fmt::format("its codec does not start ({})", libav::TextOf(code)));
  state->bytes = size;
  state->checksums = decoder->id == AV_CODEC_ID_FFV1 &&
                     av_dict_get(demuxer->metadata, libav::kOurTag, nullptr, 0) != nullptr;
  state->frame.reset(av_frame_alloc());
  state->packet.reset(av_packet_alloc());
  return VideoReader(std::move(state));
}

Result<std::optional<VideoFrame>> VideoReader::Next() {
  State& s = *state_;
  while (true) {
    const int got = avcodec_receive_frame(s.codec.get(), s.frame.get());
    if (got == 0) break;
    if (got != AVERROR(EAGAIN) && got != AVERROR_EOF) return s.Damaged(libav::TextOf(got));
    if (got == AVERROR(EAGAIN) && !s.drained) {
      const Result<bool> more = s.Feed();
      if (!more.ok()) return more.error();
      s.drained = !more.value();
      continue;
    }
    const std::optional<std::uint64_t> promised = MatroskaBytes(s.file);
    if (promised && *promised > s.bytes) {
      return Bad(s.file, fmt::format("the file is cut off after {} whole frames: it has {} of {} bytes",
                                     s.read, s.bytes, *promised));
    }
    return std::optional<VideoFrame>();
  }
  if ((s.frame->flags & AV_FRAME_FLAG_CORRUPT) != 0 || s.frame->decode_error_flags != 0) {
    return s.Damaged("its checksum is wrong");
  }
  const AVRational base = s.demuxer->streams[s.stream]->time_base;
  VideoFrame frame;
  frame.index = s.read;
  const std::int64_t stamp = s.frame->best_effort_timestamp;
  frame.time = stamp == AV_NOPTS_VALUE ? s.last_time : static_cast<double>(stamp) * base.num / base.den;
  Result<cv::Mat> image = s.gray.Of(*s.frame);
  if (!image.ok()) return Error(image.error()).Within(s.file.string());
  frame.image = std::move(image).value();
  s.last_time = frame.time;
  ++s.read;
  return std::optional<VideoFrame>(std::move(frame));
}

}  // namespace tendril
