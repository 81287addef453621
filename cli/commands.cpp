#include "cli/commands.h"

namespace tendril::cli {

// Each is defined in a file named for its group: fold_command.cpp, design_commands.cpp, ...

std::vector<Command> AllCommands() {
  std::vector<Command> all;
  return all;
}

}  // namespace tendril::cli
