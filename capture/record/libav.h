#pragma once
// libav's C structs with owners, and its error codes as text.

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/error.h>
#include <libavutil/log.h>
}

#include <array>
#include <memory>
#include <string>

namespace tendril::libav {

struct FreeFrame {
  void operator()(AVFrame* f) const { av_frame_free(&f); }
};
struct FreePacket {
  void operator()(AVPacket* p) const { av_packet_free(&p); }
};
struct FreeCodec {
  void operator()(AVCodecContext* c) const { avcodec_free_context(&c); }
};
struct CloseDemuxer {
  void operator()(AVFormatContext* context) const { avformat_close_input(&context); }
};
using Frame = std::unique_ptr<AVFrame, FreeFrame>;
using Packet = std::unique_ptr<AVPacket, FreePacket>;
using Codec = std::unique_ptr<AVCodecContext, FreeCodec>;
using Demuxer = std::unique_ptr<AVFormatContext, CloseDemuxer>;

// In the header of files that we wrote: their FFV1 slices carry checksums.
inline constexpr const char* kOurTag = "TENDRIL_RECORDING";

inline std::string TextOf(int code) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
  av_strerror(code, text.data(), text.size());
  return text.data();
}

// libav writes to stderr by itself; libraries here print nothing.
inline void Silence() { av_log_set_level(AV_LOG_QUIET); }

}  // namespace tendril::libav
