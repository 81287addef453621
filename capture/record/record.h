#pragma once
// Records a trial: one thread per source, a bounded queue each, losses counted; files in the trial's folder
// and a row in the lab that says from the first moment what became of it.
//
// In the folder: cam<i>.mkv and cam<i>.csv per camera, servo.csv, trial.toml. The row's state is `recording`,
// then `recorded`; `degraded` where frames were lost, `aborted` where somebody stopped it (what was recorded
// is kept), `failed` where something broke (likewise).

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "capture/record/frame_source.h"
#include "db/files/trial_toml.h"
#include "db/lab.h"
#include "model/progress.h"
#include "model/result.h"

namespace tendril {

struct RecordPlan {
  TrialSpec trial;  // started_ns 0: the earliest time that a source's log states, else now
  std::vector<std::unique_ptr<FrameSource>> cameras;  // cameras[i] becomes cam<i>
  std::unique_ptr<ServoSource> servo;                 // none: no servo.csv
  int queue_frames = 8;                               // per camera
  // Called with the trial's folder before the first frame, for what else belongs there.
  std::function<Status(const std::filesystem::path& folder)> write_also;
  // Called before each picture is written, from that camera's writing thread.
  std::function<void(int camera)> before_write;
};

struct CameraAccount {
  std::int64_t frames = 0;
  std::int64_t dropped = 0;  // lost by the source or by a full queue
};

struct RecordedTrial {
  TrialSpec trial;
  TrialState state = TrialState::kRecorded;  // recorded, degraded or aborted
  std::string reason;                        // why not `recorded`
  std::vector<CameraAccount> cameras;
  std::int64_t servo_rows = 0;
};

//   errors  kBadInput no camera and no servo, or what BeginTrial refuses: nothing is left behind;
//           a source's or the disk's error: the row is `failed` with that reason, the files stay
Result<RecordedTrial> Record(Lab& lab, RecordPlan plan, const Progress& progress = {});

}  // namespace tendril
