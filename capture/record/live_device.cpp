// V4L2 through OpenCV, which is linked anyway: libavdevice would add SDL, OpenGL and three sound systems.
#include <fmt/core.h>

#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <utility>

#include "capture/record/live_kinds.h"

namespace tendril {
namespace {

class LiveDevice : public LiveSource {
 public:
  LiveDevice(std::string name, cv::VideoCapture device, LiveSourceOptions options)
      : name_(std::move(name)), device_(std::move(device)), options_(std::move(options)) {}

  Result<std::optional<cv::Mat>> Next() override {
    if (options_.stopped()) return Error{ErrorKind::kStopped, name_ + ": stopped"};
    try {
      cv::Mat image, gray;
      if (!device_.read(image) || image.empty()) {
        return Error{ErrorKind::kIo, name_ + ": the camera gives no pictures any more"};
      }
      if (image.depth() != CV_8U) {
        return Error{ErrorKind::kBadInput, name_ + ": pictures of more than 8 bits; set the camera to 8"};
      }
      // The buffer belongs to OpenCV.
      if (image.channels() == 1) return std::optional<cv::Mat>(image.clone());
      cv::cvtColor(image, gray, image.channels() == 4 ? cv::COLOR_BGRA2GRAY : cv::COLOR_BGR2GRAY);
      return std::optional<cv::Mat>(std::move(gray));
    } catch (const cv::Exception& error) {
      return Error{ErrorKind::kIo, fmt::format("{}: {}", name_, error.err)};
    }
  }

 private:
  std::string name_;
  cv::VideoCapture device_;
  LiveSourceOptions options_;
};

}  // namespace

Result<std::unique_ptr<LiveSource>> OpenLiveDevice(const std::string& device,
                                                   const LiveSourceOptions& options) {
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  try {
    cv::VideoCapture capture(device, cv::CAP_V4L2);
    if (!capture.isOpened()) {
      return Error{ErrorKind::kIo, device +
                                       ": not a V4L2 camera that can be opened; another program may hold it "
                                       "(v4l2-ctl --list-devices lists cameras)"};
    }
    capture.set(cv::CAP_PROP_BUFFERSIZE, 2);  // the newest picture, not the oldest that waits
    return std::unique_ptr<LiveSource>(std::make_unique<LiveDevice>(device, std::move(capture), options));
  } catch (const cv::Exception& error) {
    return Error{ErrorKind::kIo, fmt::format("{}: {}", device, error.err)};
  }
}

}  // namespace tendril
