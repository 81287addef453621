#pragma once

#include "cli/command.h"

namespace tendril::cli {

Command MakeCalibrateCamerasCommand();

}  // namespace tendril::cli
