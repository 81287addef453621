#pragma once
// The two kinds of live sources: what libavformat reads, and V4L2 devices.

#include <memory>
#include <string>

#include "capture/record/live_source.h"

namespace tendril {

enum class StreamKind { kNetwork, kPipe, kFile };
Result<std::unique_ptr<LiveSource>> OpenLiveStream(const std::string& source, StreamKind kind,
                                                   const LiveSourceOptions& options);

Result<std::unique_ptr<LiveSource>> OpenLiveDevice(const std::string& device,
                                                   const LiveSourceOptions& options);

}  // namespace tendril
