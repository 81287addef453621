#include "capture/record/gray_frame.h"

#include <fmt/core.h>

extern "C" {
#include <libavutil/pixdesc.h>
#include <libswscale/swscale.h>
}

namespace tendril::libav {

void GrayFrames::FreeScaler::operator()(SwsContext* context) const { sws_freeContext(context); }

Result<cv::Mat> GrayFrames::Of(const AVFrame& frame) {
  cv::Mat image(frame.height, frame.width, CV_8UC1);
  if (frame.format == AV_PIX_FMT_GRAY8) {
    cv::Mat(frame.height, frame.width, CV_8UC1, frame.data[0], static_cast<std::size_t>(frame.linesize[0]))
        .copyTo(image);
    return image;
  }
  if (!scaler_ || width_ != frame.width || height_ != frame.height || format_ != frame.format) {
    scaler_.reset(sws_getContext(frame.width, frame.height, static_cast<AVPixelFormat>(frame.format),
                                 frame.width, frame.height, AV_PIX_FMT_GRAY8, SWS_POINT, nullptr, nullptr,
                                 nullptr));
    width_ = frame.width;
    height_ = frame.height;
    format_ = frame.format;
  }
  if (!scaler_) {
    const char* name = av_get_pix_fmt_name(static_cast<AVPixelFormat>(frame.format));
    return Error{ErrorKind::kBadInput,
                 fmt::format("pictures of format {}; expected gray or a colour format that libswscale knows",
                             name == nullptr ? "?" : name)};
  }
  std::uint8_t* planes[] = {image.data, nullptr, nullptr, nullptr};
  const int strides[] = {static_cast<int>(image.step), 0, 0, 0};
  sws_scale(scaler_.get(), frame.data, frame.linesize, 0, frame.height, planes, strides);
  return image;
}

}  // namespace tendril::libav
