#pragma once

#include "cli/command.h"

namespace tendril::cli {

Command MakeTrackCommand();

}  // namespace tendril::cli
