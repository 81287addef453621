#include "db/migrations.h"

#include <fmt/format.h>

#include <string>

#include "model/check.h"

namespace tendril {
namespace {

int VersionOf(SQLite::Database& db) { return db.execAndGet("PRAGMA user_version").getInt(); }

constexpr int kLabApplication = 0x746e6472;  // set by step 1

Status CheckIsLab(Connection& connection, int newest) {
  return connection.Read([&](SQLite::Database& db) -> Status {
    const int version = VersionOf(db);
    const int application = db.execAndGet("PRAGMA application_id").getInt();
    const bool empty = db.execAndGet("SELECT count(*) FROM sqlite_master").getInt() == 0;
    if (!empty && application != kLabApplication && application != 0) {
      return Error{ErrorKind::kBadInput, "is a SQLite file of another program, expected a lab"};
    }
    if (!empty && version == 0) {
      return Error{ErrorKind::kBadInput, "is a SQLite file, but not a lab's"};
    }
    if (version > newest) {
      return Error{
          ErrorKind::kBadInput,
          fmt::format("schema version is {}, but this program knows versions up to {}: update tendril "
                      "(the file was not touched)",
                      version, newest)};
    }
    return Ok{};
  });
}

}  // namespace

Result<int> SchemaVersion(Connection& connection) {
  int version = 0;
  const Status read = connection.Read([&](SQLite::Database& db) -> Status {
    version = VersionOf(db);
    return Ok{};
  });
  if (!read.ok()) return read.error();
  return version;
}

Status Migrate(Connection& connection, std::span<const Migration> migrations) {
  TENDRIL_CHECK(!migrations.empty());
  for (size_t i = 0; i < migrations.size(); ++i) {
    TENDRIL_CHECK(migrations[i].version == static_cast<int>(i) + 1);
  }
  if (Status lab = CheckIsLab(connection, migrations.back().version); !lab.ok()) return lab;
  const auto now = SchemaVersion(connection);
  if (!now.ok()) return now.error();
  for (const Migration& step : migrations) {
    if (step.version <= now.value()) continue;
    Status done = connection.Write([&](SQLite::Database& db) -> Status {
      if (VersionOf(db) >= step.version) return Ok{};  // another program was faster
      db.exec(std::string(step.sql));
      db.exec(fmt::format("PRAGMA user_version = {}", step.version));
      return Ok{};
    });
    if (!done.ok()) {
      return std::move(done).error().Within(fmt::format("schema step {} '{}'", step.version, step.title));
    }
  }
  return Ok{};
}

}  // namespace tendril
