#pragma once

#include "cli/command.h"

namespace tendril::cli {

Command MakeInitCommand();
Command MakeDbCheckCommand();

}  // namespace tendril::cli
