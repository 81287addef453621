#pragma once

#include "cli/command.h"

namespace tendril::cli {

Command MakeDetectCommand();

}  // namespace tendril::cli
