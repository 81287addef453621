#pragma once

#include "cli/command.h"

namespace tendril::cli {

Command MakePlotShapesCommand();

}  // namespace tendril::cli
