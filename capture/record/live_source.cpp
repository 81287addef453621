#include "capture/record/live_source.h"

#include <filesystem>
#include <system_error>

#include "capture/record/live_kinds.h"

namespace tendril {

Result<std::unique_ptr<LiveSource>> OpenLiveSource(const std::string& source,
                                                   const LiveSourceOptions& options) {
  if (source.find("://") != std::string::npos) return OpenLiveStream(source, StreamKind::kNetwork, options);
  std::error_code failed;
  switch (std::filesystem::status(source, failed).type()) {
    case std::filesystem::file_type::character:
      return OpenLiveDevice(source, options);
    case std::filesystem::file_type::fifo:
      return OpenLiveStream(source, StreamKind::kPipe, options);
    case std::filesystem::file_type::regular:
      return OpenLiveStream(source, StreamKind::kFile, options);
    case std::filesystem::file_type::not_found:
      return Error{ErrorKind::kNotFound,
                   source +
                       ": no such device or file; expected /dev/videoN, rtsp://..., udp://..., tcp://..., "
                       "http://..., a named pipe or a video file"};
    default:
      return Error{ErrorKind::kBadInput, source + ": neither a device, a named pipe nor a video file" +
                                             (failed ? " (" + failed.message() + ")" : std::string())};
  }
}

}  // namespace tendril
