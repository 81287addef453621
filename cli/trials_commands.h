#pragma once

#include "cli/command.h"

namespace tendril::cli {

Command MakeTrialsListCommand();
Command MakeTrialsShowCommand();
Command MakeTrialsOutcomeCommand();
Command MakeTrialsNoteCommand();
Command MakeTrialsVoidCommand();

}  // namespace tendril::cli
