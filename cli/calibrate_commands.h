#pragma once

#include "cli/command.h"

namespace tendril::cli {

Command MakeCalibrateFoldCommand();

}  // namespace tendril::cli
