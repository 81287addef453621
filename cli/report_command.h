#pragma once

#include "cli/command.h"

namespace tendril::cli {

Command MakeReportCommand();

}  // namespace tendril::cli
