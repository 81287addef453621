#include "db/trial_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "db/files/safe_file.h"
#include "db/made_with.h"
#include "db/statement.h"

namespace tendril {
namespace {

namespace fs = std::filesystem;

Error BadField(const std::string& field, const std::string& value, const std::string& expected) {
  return Error{ErrorKind::kBadInput, fmt::format("{} = {}: expected {}", field, value, expected)};
}

// Labels are typed on command lines and shown in tables.
bool IsLabel(const std::string& text) {
  constexpr size_t kLongest = 80;
  return !text.empty() && text.size() <= kLongest && text.front() != ' ' && text.back() != ' ' &&
         std::all_of(text.begin(), text.end(),
                     [](char c) { return static_cast<unsigned char>(c) >= 0x20 && c != '\x7f'; });
}

Status CheckSpec(const TrialSpec& trial) {
  if (!trial.id.empty() && !IsTrialId(trial.id)) return BadField("id", trial.id, "a UUID");
  if (!trial.label.empty() && !IsLabel(trial.label)) {
    return BadField("label", "'" + trial.label + "'", "1 to 80 printable characters");
  }
  if (trial.started_ns < 0) return BadField("started_ns", std::to_string(trial.started_ns), "ns since 1970");
  if (!(trial.pull >= 0 && trial.pull <= 1)) {
    return BadField("pull", fmt::format("{}", trial.pull), "0 to 1, of the flat tendon length");
  }
  if (!(trial.pull_rate >= 0) || !std::isfinite(trial.pull_rate)) {
    return BadField("pull_rate", fmt::format("{}", trial.pull_rate), ">= 0 1/s");
  }
  if (!std::isfinite(trial.object_distance)) {
    return BadField("object_distance", fmt::format("{}", trial.object_distance), "a number of metres");
  }
  if (trial.medium.empty()) return BadField("medium", "''", "a name such as air");
  if (trial.gripper.tentacles < 1) {
    return BadField("gripper.tentacles", std::to_string(trial.gripper.tentacles), "1 or more");
  }
  const ObjectSpec& object = trial.object;
  if (!(object.radius >= 0) || !(object.length >= 0) || !(object.mass >= 0) || !object.position.allFinite() ||
      !object.axis.allFinite() || object.axis.isZero()) {
    return Error{ErrorKind::kBadInput,
                 "object: expected radius, length and mass >= 0, finite position, and an axis that is not 0"};
  }
  if (Status design = CheckDesign(trial.design); !design.ok()) {
    return std::move(design).error().Within("design " + trial.design_name);
  }
  return Ok{};
}

std::string FreeTrialLabel(SQLite::Database& db) {
  std::int64_t number = Ask(db, "SELECT count(*) FROM trial") + 1;
  while (Ask(db, "SELECT count(*) FROM trial WHERE label = ?", fmt::format("trial-{}", number)) > 0) ++number;
  return fmt::format("trial-{}", number);
}

void InsertRecording(SQLite::Database& db, const std::string& id, const std::string& role,
                     const std::string& file, const std::string& sha256, std::optional<std::int64_t> frames,
                     std::optional<std::int64_t> dropped) {
  Run(db,
      "INSERT INTO recording (trial_id, role, file, sha256, frames, dropped, added_ns) VALUES "
      "(?,?,?,?,?,?,?) "
      "ON CONFLICT (trial_id, role) DO UPDATE SET file = excluded.file, sha256 = excluded.sha256, "
      "frames = excluded.frames, dropped = excluded.dropped, added_ns = excluded.added_ns",
      id, role, file, sha256, frames, dropped, NowNs());
}

void InsertTrial(SQLite::Database& db, const TrialSpec& trial) {
  const MadeWith made = StoreMadeWith(db, trial);
  Run(db,
      "INSERT INTO trial (id, label, kind, state, started_ns, design_id, gripper_id, object_id, medium_id, "
      "rig_id, object_distance_m, object_x_m, object_y_m, object_z_m, pull, pull_rate_per_s, tag_family, "
      "tag_footprint_m, tag_first_id, notes) VALUES (?,?,?,'recording',?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)",
      trial.id, trial.label, NameOf(trial.kind), trial.started_ns, made.design_id, made.gripper_id,
      made.object_id, made.medium_id, made.rig_id, trial.object_distance, trial.object.position.x(),
      trial.object.position.y(), trial.object.position.z(), trial.pull, trial.pull_rate, trial.tags.family,
      trial.tags.footprint, trial.tags.first_id, trial.notes);
}

bool MayFollow(TrialState from, TrialState to) {
  return from == to || from == TrialState::kRecording ||
         (from == TrialState::kRecorded && to == TrialState::kDegraded);
}

Status RequireTrial(SQLite::Database& db, const std::string& id) {
  if (Ask(db, "SELECT count(*) FROM trial WHERE id = ?", id) == 0) {
    return Error{ErrorKind::kNotFound, fmt::format("no trial with id {}", id)};
  }
  return Ok{};
}

// Events of one trial get ascending times, also where the clock was set back between them.
template <class... Values>
Status AddEvent(Lab& lab, const std::string& id, const std::string& table, const std::string& columns,
                const Values&... values) {
  return lab.db().Write([&](SQLite::Database& db) -> Status {
    if (Status there = RequireTrial(db, id); !there.ok()) return there;
    const std::int64_t last =
        Ask(db, fmt::format("SELECT coalesce(max(at_ns), 0) FROM {} WHERE trial_id = ?", table), id);
    std::string marks;
    for (size_t i = 0; i < sizeof...(values); ++i) marks += ",?";
    Run(db, fmt::format("INSERT INTO {} (trial_id, at_ns, {}) VALUES (?,?{})", table, columns, marks), id,
        std::max(NowNs(), last + 1), values...);
    return Ok{};
  });
}

}  // namespace

Result<TrialSpec> BeginTrial(Lab& lab, TrialSpec spec) {
  if (Status good = CheckSpec(spec); !good.ok()) return std::move(good).error().Within("trial");
  if (spec.started_ns == 0) spec.started_ns = NowNs();
  if (spec.id.empty()) spec.id = NewTrialId(spec.started_ns);
  const fs::path folder = lab.TrialFolder(spec.id);
  bool made_folder = false;
  const Status done = lab.db().Write([&](SQLite::Database& db) -> Status {
    if (spec.label.empty()) spec.label = FreeTrialLabel(db);
    if (Ask(db, "SELECT count(*) FROM trial WHERE label = ?", spec.label) > 0) {
      return Error{ErrorKind::kBadInput, fmt::format("label = {}: taken by another trial", spec.label)};
    }
    if (Ask(db, "SELECT count(*) FROM trial WHERE id = ?", spec.id) > 0) {
      return Error{ErrorKind::kBadInput, fmt::format("id = {}: this trial is in the lab already", spec.id)};
    }
    InsertTrial(db, spec);
    std::error_code error;
    fs::create_directory(folder.parent_path(), error);
    made_folder = fs::create_directory(folder, error);
    if (!made_folder) {
      return Error{ErrorKind::kIo, fmt::format("{}: cannot make this folder: {}", folder.string(),
                                               error ? error.message() : "it is there already")};
    }
    const std::string toml = TrialToml(spec);
    if (Status written = WriteText(folder / "trial.toml", toml); !written.ok()) return written;
    InsertRecording(db, spec.id, "trial", "trial.toml", Sha256(toml), std::nullopt, std::nullopt);
    return Ok{};
  });
  if (done.ok()) return spec;
  std::error_code ignored;
  if (made_folder) fs::remove_all(folder, ignored);
  return done.error();
}

Status SetTrialState(Lab& lab, const std::string& id, TrialState state, const std::string& reason) {
  return lab.db().Write([&](SQLite::Database& db) -> Status {
    if (Status there = RequireTrial(db, id); !there.ok()) return there;
    SQLite::Statement query(db, "SELECT state FROM trial WHERE id = ?");
    Bind(query, id);
    query.executeStep();
    const std::string before = query.getColumn(0).getString();
    query.reset();
    if (!MayFollow(*TrialStateOf(before), state)) {
      return Error{ErrorKind::kBadInput,
                   fmt::format("trial {} is {} and cannot become {}", id, before, NameOf(state))};
    }
    Run(db, "UPDATE trial SET state = ?, state_reason = ? WHERE id = ?", NameOf(state), reason, id);
    return Ok{};
  });
}

Status AddRecordingFile(Lab& lab, const std::string& id, const std::string& role, const std::string& file,
                        const std::string& sha256, std::optional<std::int64_t> frames,
                        std::optional<std::int64_t> dropped) {
  const fs::path path(file);
  if (file.empty() || path.is_absolute() || std::find(path.begin(), path.end(), "..") != path.end()) {
    return BadField("file", "'" + file + "'", "a path within the trial's folder");
  }
  return lab.db().Write([&](SQLite::Database& db) -> Status {
    if (Status there = RequireTrial(db, id); !there.ok()) return there;
    InsertRecording(db, id, role, file, sha256, frames, dropped);
    return Ok{};
  });
}

Status AddOutcome(Lab& lab, const std::string& id, const Outcome& outcome) {
  if (outcome.judged_by.empty()) return BadField("judged_by", "''", "the name of who judged");
  if (std::isinf(outcome.load_N)) return BadField("load_N", fmt::format("{}", outcome.load_N), "a force, N");
  return AddEvent(lab, id, "outcome", "grasped, judged_by, by_person, method, notes, load_N",
                  outcome.grasped ? 1 : 0, outcome.judged_by, outcome.by_person ? 1 : 0, outcome.method,
                  outcome.notes, outcome.load_N);
}

Status AddNote(Lab& lab, const std::string& id, const std::string& text, const std::string& author) {
  if (text.empty() || author.empty()) return BadField("note", "''", "a text and who wrote it");
  return AddEvent(lab, id, "note", "text, author", text, author);
}

Status AddLabel(Lab& lab, const std::string& id, const std::string& label, const std::string& author) {
  if (!IsLabel(label) || author.empty()) {
    return BadField("label", "'" + label + "'", "1 to 80 printable characters, and who gave it");
  }
  return AddEvent(lab, id, "label", "word, author", label, author);
}

Status VoidTrial(Lab& lab, const std::string& id, const std::string& reason, const std::string& author) {
  if (reason.empty() || author.empty()) return BadField("void", "''", "a reason and who decided");
  return AddEvent(lab, id, "void", "reason, author", reason, author);
}

}  // namespace tendril
