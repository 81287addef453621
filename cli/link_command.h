#pragma once

#include "cli/command.h"

namespace tendril::cli {

Command MakeLinkCommand();

}  // namespace tendril::cli
