#pragma once

#include "cli/command.h"

namespace tendril::cli {

Command MakeTrialsImportCommand();

}  // namespace tendril::cli
