#pragma once
// The lab file's schema, as the ordered list of changes that leads to it: db/migrations/<number>_<title>.sql,
// embedded when the program is built.

#include <span>
#include <string_view>

#include "db/connection.h"
#include "model/result.h"

namespace tendril {

struct Migration {
  int version = 0;         // 1, 2, 3, ...; PRAGMA user_version once it is in
  std::string_view title;  // what a person reads in `tendril db check`
  std::string_view sql;
};

std::span<const Migration> Migrations();

// PRAGMA user_version: how many steps the file has.
Result<int> SchemaVersion(Connection& connection);

// Brings an open lab file to the newest schema, each step in its own transaction, so that a crash leaves
// either the old version or the new one. Two programs may call it at once; the second waits.
//   errors  kBadInput  the file is newer than this program, or not a lab's; it is left untouched
//           kIo        SQLite's message, with the step's title; that step is rolled back
Status Migrate(Connection& connection, std::span<const Migration> migrations = Migrations());

}  // namespace tendril
