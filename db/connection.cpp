#include "db/connection.h"

#include <fmt/format.h>
#include <sqlite3.h>

namespace tendril {
namespace {

constexpr int kBusyTimeout_ms = 20'000;

Error ErrorOf(const SQLite::Exception& error) {
  switch (error.getErrorCode()) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return {ErrorKind::kIo,
              fmt::format("another program kept the lab's database locked for {} s", kBusyTimeout_ms / 1000)};
    case SQLITE_NOTADB:
      return {ErrorKind::kBadInput, "is not a SQLite database"};
    case SQLITE_CORRUPT:
      return {ErrorKind::kBadInput, fmt::format("the database is damaged: {}", error.what())};
    case SQLITE_CONSTRAINT:
    case SQLITE_MISMATCH:
      return {ErrorKind::kBadInput, error.what()};
    case SQLITE_FULL:
      return {ErrorKind::kIo, "the disk is full"};
    case SQLITE_READONLY:
      return {ErrorKind::kIo, "the database cannot be written: read-only file or folder"};
    default:
      return {ErrorKind::kIo, fmt::format("SQLite: {}", error.what())};
  }
}

Status InTransaction(SQLite::Database& db, const char* begin,
                     const std::function<Status(SQLite::Database&)>& work) {
  try {
    db.exec(begin);
  } catch (const SQLite::Exception& error) {
    return ErrorOf(error);
  }
  Status done = Ok{};
  try {
    done = work(db);
    if (done.ok()) db.exec("COMMIT");
  } catch (const SQLite::Exception& error) {
    done = ErrorOf(error);
  } catch (...) {
    (void)db.tryExec("ROLLBACK");
    throw;
  }
  // Some errors (a full disk) have rolled back already, which makes this one fail harmlessly.
  if (!done.ok()) (void)db.tryExec("ROLLBACK");
  return done;
}

Result<std::unique_ptr<SQLite::Database>> OpenDatabase(const std::string& name, int flags) {
  try {
    auto db = std::make_unique<SQLite::Database>(name, flags, kBusyTimeout_ms);
    db->exec("PRAGMA foreign_keys = ON");
    db->exec("PRAGMA recursive_triggers = ON");
    db->exec("PRAGMA synchronous = NORMAL");
    db->execAndGet("SELECT count(*) FROM sqlite_master");  // opens the file in earnest
    return db;
  } catch (const SQLite::Exception& error) {
    return ErrorOf(error);
  }
}

}  // namespace

Result<Connection> Connection::Open(const std::filesystem::path& file, Mode mode) {
  std::error_code ignored;
  if (mode != Mode::kCreate && !std::filesystem::exists(file, ignored)) {
    return Error{ErrorKind::kNotFound, file.string() + ": no such file"};
  }
  int flags = SQLite::OPEN_READWRITE;
  if (mode == Mode::kCreate) flags |= SQLite::OPEN_CREATE;
  if (mode == Mode::kReadOnly) flags = SQLite::OPEN_READONLY;
  auto db = OpenDatabase(file.string(), flags);
  if (!db.ok()) return std::move(db).error().Within(file.string());
  return Connection(std::move(db).value());
}

Result<Connection> Connection::InMemory() {
  auto db = OpenDatabase(":memory:", SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
  if (!db.ok()) return db.error();
  return Connection(std::move(db).value());
}

Status Connection::UseWriteAheadLog() {
  try {
    db_->execAndGet("PRAGMA journal_mode = WAL");
    return Ok{};
  } catch (const SQLite::Exception& error) {
    return ErrorOf(error);
  }
}

Status Connection::Write(const std::function<Status(SQLite::Database&)>& work) {
  return InTransaction(*db_, "BEGIN IMMEDIATE", work);
}

Status Connection::Read(const std::function<Status(SQLite::Database&)>& work) {
  return InTransaction(*db_, "BEGIN", work);
}

}  // namespace tendril
