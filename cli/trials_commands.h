#pragma once

#include "cli/command.h"
#include "db/trial_query.h"

namespace tendril::cli {

// "success", "failure", "-" (not judged) or "void"; "(not trusted)" behind it where that is so.
std::string OutcomeText(const TrialOverview& trial);

Command MakeTrialsListCommand();
Command MakeTrialsShowCommand();
Command MakeTrialsOutcomeCommand();
Command MakeTrialsNoteCommand();
Command MakeTrialsVoidCommand();

}  // namespace tendril::cli
