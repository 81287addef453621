#pragma once

#include "cli/command.h"

namespace tendril::cli {

Command MakeDesignTagsCommand();

}  // namespace tendril::cli
