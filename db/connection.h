#pragma once
// An open SQLite file (WAL, foreign keys on, waits for others), and the two ways to use it: read a consistent
// state, or write in one transaction. SQLiteCpp's exceptions end here.

#include <SQLiteCpp/SQLiteCpp.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "model/result.h"

namespace tendril {

class Connection {
 public:
  enum class Mode { kOpen, kCreate, kReadOnly };

  //   errors  kNotFound no such file; kBadInput not a SQLite database; kIo
  static Result<Connection> Open(const std::filesystem::path& file, Mode mode = Mode::kOpen);
  static Result<Connection> InMemory();

  // Readers then never wait for a writer. The file remembers it.
  Status UseWriteAheadLog();

  // Runs `work` between BEGIN IMMEDIATE and COMMIT; a Status that is not ok, or an SQLite error, rolls back.
  Status Write(const std::function<Status(SQLite::Database&)>& work);

  // Runs `work` on one consistent state of the file.
  Status Read(const std::function<Status(SQLite::Database&)>& work);

  SQLite::Database& handle() { return *db_; }

 private:
  explicit Connection(std::unique_ptr<SQLite::Database> db) : db_(std::move(db)) {}
  std::unique_ptr<SQLite::Database> db_;
};

}  // namespace tendril
