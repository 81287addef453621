#pragma once
// One line per statement inside a transaction. NaN and empty optionals are bound as NULL.

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Statement.h>

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>

namespace tendril {

inline void BindOne(SQLite::Statement& statement, int at, double value) {
  if (std::isnan(value)) {
    statement.bind(at);
  } else {
    statement.bind(at, value);
  }
}
inline void BindOne(SQLite::Statement& statement, int at, int value) { statement.bind(at, value); }
inline void BindOne(SQLite::Statement& statement, int at, std::int64_t value) { statement.bind(at, value); }
inline void BindOne(SQLite::Statement& statement, int at, const std::string& value) {
  statement.bind(at, value);
}
template <class Value>
void BindOne(SQLite::Statement& statement, int at, const std::optional<Value>& value) {
  if (value) {
    BindOne(statement, at, *value);
  } else {
    statement.bind(at);
  }
}

template <class... Values>
void Bind(SQLite::Statement& statement, const Values&... values) {
  int at = 0;
  (BindOne(statement, ++at, values), ...);
}

template <class... Values>
void Run(SQLite::Database& db, const std::string& sql, const Values&... values) {
  SQLite::Statement statement(db, sql);
  Bind(statement, values...);
  statement.exec();
}

// The same for a statement that is run again and again.
template <class... Values>
void RunAgain(SQLite::Statement& statement, const Values&... values) {
  statement.reset();
  Bind(statement, values...);
  statement.exec();
}

// The first column of the first row, a whole number.
template <class... Values>
std::int64_t Ask(SQLite::Database& db, const std::string& sql, const Values&... values) {
  SQLite::Statement query(db, sql);
  Bind(query, values...);
  query.executeStep();
  return query.getColumn(0).getInt64();
}

}  // namespace tendril
