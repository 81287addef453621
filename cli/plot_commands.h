#pragma once

#include "cli/command.h"

namespace tendril::cli {

Command MakePlotCurvesCommand();
Command MakePlotCurvatureCommand();
Command MakePlotLinkCommand();
Command MakePlotRatesCommand();

}  // namespace tendril::cli
