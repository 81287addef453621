#pragma once
// The brightness of a picture as libav decoded it: gray as it is, anything else through libswscale to full
// range.

#include <memory>
#include <opencv2/core/mat.hpp>

#include "capture/record/libav.h"
#include "model/result.h"

struct SwsContext;

namespace tendril::libav {

// Keeps what libswscale prepares, as long as pictures stay the same in size and format.
class GrayFrames {
 public:
  //   returns  CV_8UC1, a copy
  //   errors   kBadInput: a format that libswscale does not know
  Result<cv::Mat> Of(const AVFrame& frame);

 private:
  struct FreeScaler {
    void operator()(SwsContext* context) const;
  };
  std::unique_ptr<SwsContext, FreeScaler> scaler_;
  int width_ = 0, height_ = 0, format_ = -1;
};

}  // namespace tendril::libav
