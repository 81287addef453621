#include "db/check.h"

#include <fmt/format.h>

#include "db/files/safe_file.h"
#include "db/migrations.h"
#include "db/statement.h"

namespace tendril {
namespace {

struct Recorded {
  std::string trial;
  std::string file;
  std::string sha256;
};

}  // namespace

Result<LabCheck> CheckLab(Lab& lab, const Progress& progress) {
  LabCheck check;
  std::vector<Recorded> recorded;
  const Status read = lab.db().Read([&](SQLite::Database& db) -> Status {
    check.schema_version = db.execAndGet("PRAGMA user_version").getInt();
    for (const Migration& step : Migrations()) {
      if (step.version <= check.schema_version) check.schema_steps.emplace_back(step.title);
    }
    SQLite::Statement integrity(db, "PRAGMA integrity_check");
    while (integrity.executeStep()) {
      const std::string line = integrity.getColumn(0).getString();
      if (line != "ok") check.problems.push_back("lab.db: " + line);
    }
    SQLite::Statement keys(db, "PRAGMA foreign_key_check");
    while (keys.executeStep()) {
      check.problems.push_back(fmt::format("lab.db: a row of {} points to a row of {} that is not there",
                                           keys.getColumn(0).getString(), keys.getColumn(2).getString()));
    }
    SQLite::Statement trials(db, "SELECT id, label FROM trial ORDER BY id");
    while (trials.executeStep()) {
      ++check.trials;
      if (!std::filesystem::is_directory(lab.TrialFolder(trials.getColumn(0).getString()))) {
        check.problems.push_back(fmt::format("trial {}: its folder trials/{} is missing",
                                             trials.getColumn(1).getString(),
                                             trials.getColumn(0).getString()));
      }
    }
    SQLite::Statement files(db, "SELECT trial_id, file, sha256 FROM recording ORDER BY trial_id, role");
    while (files.executeStep()) {
      recorded.push_back(
          {files.getColumn(0).getString(), files.getColumn(1).getString(), files.getColumn(2).getString()});
    }
    return Ok{};
  });
  if (!read.ok()) return read.error();

  // Outside the transaction: hashing videos takes its time.
  for (const Recorded& row : recorded) {
    if (progress && !progress(static_cast<double>(check.files) / static_cast<double>(recorded.size()))) {
      return Error{ErrorKind::kStopped, "stopped"};
    }
    ++check.files;
    const auto hash = Sha256OfFile(lab.TrialFolder(row.trial) / row.file);
    if (!hash.ok()) {
      check.problems.push_back(hash.error().message);
    } else if (hash.value() != row.sha256) {
      check.problems.push_back(
          fmt::format("trials/{}/{}: was changed after it was recorded (SHA-256 {}, expected {})", row.trial,
                      row.file, hash.value(), row.sha256));
    }
  }
  if (progress) progress(1);
  return check;
}

}  // namespace tendril
