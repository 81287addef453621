#pragma once

#include "cli/command.h"

namespace tendril::cli {

Command MakeSimulateCommand();

}  // namespace tendril::cli
