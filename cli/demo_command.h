#pragma once

#include "cli/command.h"

namespace tendril::cli {

Command MakeDemoCommand();

}  // namespace tendril::cli
