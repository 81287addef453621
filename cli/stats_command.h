#pragma once

#include "cli/command.h"

namespace tendril::cli {

Command MakeStatsCommand();

}  // namespace tendril::cli
