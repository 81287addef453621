#pragma once

#include "cli/command.h"

namespace tendril::cli {

Command MakeRecordCommand();

}  // namespace tendril::cli
