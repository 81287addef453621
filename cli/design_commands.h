#pragma once

#include "cli/command.h"

namespace tendril::cli {

Command MakeDesignShowCommand();
Command MakeDesignCutCommand();

}  // namespace tendril::cli
