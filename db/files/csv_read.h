#pragma once
// Reading our CSV files: a fixed header, then rows whose fields are asked for by column. No quotes: our
// fields are numbers and plain names. Lines may end in LF or CRLF; blanks around a field and empty lines do
// not count.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/result.h"

namespace tendril {

class CsvReader {
 public:
  // Of the headers that a file may have, `columns()` is the one it has.
  //   lines_end  the last line needs its newline, or the file is truncated
  //   errors     kNotFound no such file; kBadInput empty, or another header (shows it and what was expected)
  static Result<CsvReader> Open(const std::filesystem::path& file, const std::vector<std::string>& headers,
                                bool lines_end);

  const std::vector<std::string>& columns() const { return columns_; }
  const std::string& header() const { return header_; }

  // Moves to the next row. False at the end, or when something is wrong: status() tells which.
  bool Next();
  const Status& status() const { return status_; }

  // Of the row at hand. A value that cannot be ends the reading: Next() is false from then on.
  std::string_view Text(size_t column) const { return fields_[column]; }
  double Number(size_t column, double low = -kAny, double high = kAny);
  std::int64_t Integer(size_t column, std::int64_t low = INT64_MIN, std::int64_t high = INT64_MAX);
  std::optional<double> NumberOrEmpty(size_t column);
  std::optional<std::int64_t> IntegerOrEmpty(size_t column);

  // The caller's own finding about a column of the row at hand: file:line: field = value: expected ...
  void Reject(size_t column, const std::string& expected);
  // About the file as a whole.
  void RejectFile(const std::string& what);

  bool ok() const { return status_.ok(); }

 private:
  static constexpr double kAny = 1.7976931348623157e308;  // any finite number

  std::string_view NextLine();
  void Fail(const std::string& text);

  std::string name_;
  std::string text_;
  size_t at_ = 0;
  std::int64_t line_ = 0;
  bool lines_end_ = false;
  std::string header_;
  std::vector<std::string> columns_;
  std::vector<std::string_view> fields_;
  Status status_ = Ok{};
};

}  // namespace tendril
