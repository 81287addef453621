#pragma once

#include "cli/command.h"

namespace tendril::cli {

Command MakeFoldCommand();

}  // namespace tendril::cli
