#pragma once
// tendril detect --live: which tags each camera sees now.

#include <string>
#include <vector>

#include "capture/track/tag_detect.h"
#include "cli/command.h"

namespace tendril::cli {

struct LiveCall {
  std::vector<std::string> sources;
  TagDetectOptions detect;
  std::string level = "preview";
  double seconds = 0;   // 0: until Ctrl-C, or all files have ended
  std::string expect;   // ids; empty: nothing is expected
  std::string overlay;  // file; empty: none
};

// A table that is refreshed in place where stdout is a terminal, else a line a second; --json: an object a
// line, then the summary.
Status DetectLive(const LiveCall& call, Output& out);

}  // namespace tendril::cli
