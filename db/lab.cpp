#include "db/lab.h"

#include <fmt/format.h>
#include <unistd.h>

#include <vector>

#include "db/migrations.h"

namespace tendril {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDatabase = "lab.db";
constexpr const char* kFolders[] = {"designs", "rigs", "scenes", "sweeps", "trials"};

// Folders made so far; removed again (where still empty) unless kept.
class NewFolders {
 public:
  NewFolders() = default;
  NewFolders(const NewFolders&) = delete;
  NewFolders& operator=(const NewFolders&) = delete;
  ~NewFolders() {
    std::error_code ignored;
    if (kept_) return;
    for (auto folder = made_.rbegin(); folder != made_.rend(); ++folder) fs::remove(*folder, ignored);
  }

  Status Make(const fs::path& folder) {
    std::error_code error;
    if (fs::is_directory(folder, error)) return Ok{};
    if (folder.has_parent_path() && folder.parent_path() != folder) {
      if (Status parent = Make(folder.parent_path()); !parent.ok()) return parent;
    }
    if (!fs::create_directory(folder, error) && error) {
      return Error{ErrorKind::kIo,
                   fmt::format("{}: cannot make this folder: {}", folder.string(), error.message())};
    }
    made_.push_back(folder);
    return Ok{};
  }

  void Keep() { kept_ = true; }

 private:
  std::vector<fs::path> made_;
  bool kept_ = false;
};

Status MakeDatabase(const fs::path& file) {
  auto db = Connection::Open(file, Connection::Mode::kCreate);
  if (!db.ok()) return db.error();
  if (Status wal = db.value().UseWriteAheadLog(); !wal.ok()) return wal;
  return Migrate(db.value());
}

}  // namespace

Result<Lab> Lab::Create(const fs::path& folder) {
  std::error_code error;
  const fs::path home = fs::absolute(folder, error).lexically_normal();
  const fs::path database = home / kDatabase;
  const Error taken{ErrorKind::kBadInput, fmt::format("{}: there is a lab already", database.string())};
  if (fs::exists(database, error)) return taken;

  NewFolders folders;
  for (const char* name : kFolders) {
    if (Status made = folders.Make(home / name); !made.ok()) return made.error();
  }
  // Made under another name, then linked to its own, which fails if another program made a lab meanwhile.
  const fs::path beside = home / fmt::format(".{}.{}.tmp", kDatabase, ::getpid());
  Status made = MakeDatabase(beside);
  if (made.ok() && ::link(beside.c_str(), database.c_str()) != 0) {
    const int link_error = errno;
    if (link_error == EEXIST) {
      made = taken;
    } else {  // a file system without links
      fs::rename(beside, database, error);
      if (error)
        made = Error{ErrorKind::kIo, fmt::format("{}: cannot write: {}", database.string(), error.message())};
    }
  }
  for (const char* end : {"", "-wal", "-shm", "-journal"}) fs::remove(beside.string() + end, error);
  if (!made.ok()) return made.error();
  folders.Keep();
  return Open(home);
}

Result<Lab> Lab::Open(const fs::path& folder) {
  std::error_code error;
  fs::path home = fs::absolute(folder, error).lexically_normal();
  if (!home.has_filename()) home = home.parent_path();  // "mylab/"
  const fs::path database = home / kDatabase;
  if (!fs::exists(database, error)) {
    return Error{ErrorKind::kNotFound, fmt::format("{}: no lab here (no {}); make one with `tendril init {}`",
                                                   folder.string(), kDatabase, folder.string())};
  }
  auto db = Connection::Open(database);
  if (!db.ok()) return db.error();
  if (Status migrated = Migrate(db.value()); !migrated.ok()) {
    return std::move(migrated).error().Within(database.string());
  }
  if (Status wal = db.value().UseWriteAheadLog(); !wal.ok()) {
    return std::move(wal).error().Within(database.string());
  }
  return Lab(home, std::move(db).value());
}

Result<fs::path> Lab::Find(const fs::path& start) {
  std::error_code error;
  const fs::path first = fs::weakly_canonical(start, error);
  for (fs::path at = first;; at = at.parent_path()) {
    if (fs::is_regular_file(at / kDatabase, error)) return at;
    if (at == at.parent_path() || at.empty()) break;
  }
  return Error{ErrorKind::kNotFound,
               fmt::format("{} is in no lab: name one with --lab DIR, or make one with `tendril init DIR`",
                           first.string())};
}

}  // namespace tendril
