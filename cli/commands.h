#pragma once
// Every command of the program, in the order --help lists them.

#include <vector>

#include "cli/command.h"

namespace tendril::cli {

std::vector<Command> AllCommands();

}  // namespace tendril::cli
