#include "cli/commands.h"

#include "cli/design_commands.h"
#include "cli/detect_command.h"
#include "cli/fold_command.h"
#include "cli/link_command.h"
#include "cli/record_command.h"

namespace tendril::cli {

// Each is defined in a file named for its group: fold_command.cpp, design_commands.cpp, ...

std::vector<Command> AllCommands() {
  std::vector<Command> all;
  all.push_back(MakeDesignShowCommand());
  all.push_back(MakeDesignCutCommand());
  all.push_back(MakeFoldCommand());
  all.push_back(MakeRecordCommand());
  all.push_back(MakeDetectCommand());
  all.push_back(MakeLinkCommand());
  return all;
}

}  // namespace tendril::cli
