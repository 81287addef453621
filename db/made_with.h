#pragma once
// The rows that a trial points to: its design, gripper, object, medium and rig, each found by its content's
// hash or added.

#include <SQLiteCpp/Database.h>

#include <cstdint>
#include <optional>

#include "db/files/trial_toml.h"

namespace tendril {

struct MadeWith {
  std::int64_t design_id = 0;
  std::int64_t gripper_id = 0;
  std::int64_t object_id = 0;
  std::int64_t medium_id = 0;
  std::optional<std::int64_t> rig_id;  // none: no cameras
};

// Inside a transaction; SQLite's exceptions pass through to Connection::Write.
MadeWith StoreMadeWith(SQLite::Database& db, const TrialSpec& trial);

}  // namespace tendril
