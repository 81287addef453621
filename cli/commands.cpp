#include "cli/commands.h"

#include "cli/calibrate_cameras_command.h"
#include "cli/calibrate_commands.h"
#include "cli/demo_command.h"
#include "cli/design_commands.h"
#include "cli/design_tags_command.h"
#include "cli/detect_command.h"
#include "cli/fold_command.h"
#include "cli/import_command.h"
#include "cli/lab_commands.h"
#include "cli/link_command.h"
#include "cli/plot_commands.h"
#include "cli/plot_shapes_command.h"
#include "cli/record_command.h"
#include "cli/report_command.h"
#include "cli/simulate_command.h"
#include "cli/stats_command.h"
#include "cli/track_command.h"
#include "cli/trials_commands.h"

namespace tendril::cli {

// Each is defined in a file named for its group: fold_command.cpp, design_commands.cpp, ...

std::vector<Command> AllCommands() {
  std::vector<Command> all;
  all.push_back(MakeInitCommand());
  all.push_back(MakeDesignShowCommand());
  all.push_back(MakeDesignCutCommand());
  all.push_back(MakeDesignTagsCommand());
  all.push_back(MakeFoldCommand());
  all.push_back(MakeRecordCommand());
  all.push_back(MakeDetectCommand());
  all.push_back(MakeTrackCommand());
  all.push_back(MakeCalibrateCamerasCommand());
  all.push_back(MakeCalibrateFoldCommand());
  all.push_back(MakeLinkCommand());
  all.push_back(MakeReportCommand());
  all.push_back(MakeTrialsListCommand());
  all.push_back(MakeTrialsShowCommand());
  all.push_back(MakeTrialsImportCommand());
  all.push_back(MakeTrialsOutcomeCommand());
  all.push_back(MakeTrialsNoteCommand());
  all.push_back(MakeTrialsVoidCommand());
  all.push_back(MakeStatsCommand());
  all.push_back(MakeSimulateCommand());
  all.push_back(MakePlotCurvesCommand());
  all.push_back(MakePlotCurvatureCommand());
  all.push_back(MakePlotLinkCommand());
  all.push_back(MakePlotRatesCommand());
  all.push_back(MakePlotShapesCommand());
  all.push_back(MakeDbCheckCommand());
  all.push_back(MakeDemoCommand());
  return all;
}

}  // namespace tendril::cli
