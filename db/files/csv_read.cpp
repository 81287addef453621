#include "db/files/csv_read.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "db/files/safe_file.h"

namespace tendril {
namespace {

constexpr size_t kLongestShown = 80;

std::string_view Trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

template <class Text>
void Split(std::string_view line, std::vector<Text>& fields) {
  fields.clear();
  size_t begin = 0;
  while (true) {
    const size_t comma = line.find(',', begin);
    fields.emplace_back(Trimmed(line.substr(begin, comma == std::string_view::npos ? comma : comma - begin)));
    if (comma == std::string_view::npos) return;
    begin = comma + 1;
  }
}

// What can be shown of a line that may be anything.
std::string Shown(std::string_view text) {
  std::string shown(text.substr(0, kLongestShown));
  for (char& c : shown) {
    if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) >= 0x7f) c = '?';
  }
  return text.size() > kLongestShown ? shown + "..." : shown;
}

template <class Value>
bool Parse(std::string_view text, Value& value) {
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

}  // namespace

Result<CsvReader> CsvReader::Open(const std::filesystem::path& file, const std::vector<std::string>& headers,
                                  bool lines_end) {
  auto text = ReadText(file);
  if (!text.ok()) return text.error();
  CsvReader reader;
  reader.name_ = file.string();
  reader.text_ = std::move(text).value();
  reader.lines_end_ = lines_end;
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (reader.text_.starts_with(kByteOrderMark)) reader.at_ = kByteOrderMark.size();
  const std::string expected = fmt::format("the header {}", fmt::join(headers, " or "));
  if (Trimmed(reader.text_).empty()) {
    return Error{ErrorKind::kBadInput, fmt::format("{}: empty, expected {}", reader.name_, expected)};
  }
  const std::string_view line = reader.NextLine();
  Split(line, reader.columns_);
  reader.header_ = fmt::format("{}", fmt::join(reader.columns_, ","));
  if (std::find(headers.begin(), headers.end(), reader.header_) == headers.end()) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("{}:1: header is '{}', expected {}", reader.name_, Shown(line), expected)};
  }
  return reader;
}

std::string_view CsvReader::NextLine() {
  const size_t end = text_.find('\n', at_);
  if (end == std::string::npos && lines_end_) {
    ++line_;
    Fail("the last line has no newline, so the file is truncated");
    --line_;
  }
  const std::string_view line =
      std::string_view(text_).substr(at_, end == std::string::npos ? end : end - at_);
  at_ = end == std::string::npos ? text_.size() : end + 1;
  ++line_;
  return line;
}

bool CsvReader::Next() {
  while (ok() && at_ < text_.size()) {
    const std::string_view line = NextLine();
    if (!ok()) return false;
    if (Trimmed(line).empty()) continue;
    Split(line, fields_);
    if (fields_.size() != columns_.size()) {
      Fail(fmt::format("'{}' has {} fields, expected {}: {}", Shown(line), fields_.size(), columns_.size(),
                       header_));
      return false;
    }
    return true;
  }
  return false;
}

double CsvReader::Number(size_t column, double low, double high) {
  double value = NAN;
  const bool good = Parse(fields_[column], value) && std::isfinite(value) && value >= low && value <= high;
  if (!good) {
    std::string expected = "a number";
    if (low > -kAny) expected += fmt::format(" >= {}", low);
    if (high < kAny) expected += fmt::format("{} <= {}", low > -kAny ? " and" : "", high);
    Reject(column, expected);
  }
  return value;
}

std::int64_t CsvReader::Integer(size_t column, std::int64_t low, std::int64_t high) {
  std::int64_t value = 0;
  if (!Parse(fields_[column], value) || value < low || value > high) {
    std::string expected = "a whole number";
    if (low > INT64_MIN) expected += fmt::format(" >= {}", low);
    if (high < INT64_MAX) expected += fmt::format("{} <= {}", low > INT64_MIN ? " and" : "", high);
    Reject(column, expected);
  }
  return value;
}

std::optional<double> CsvReader::NumberOrEmpty(size_t column) {
  if (fields_[column].empty()) return std::nullopt;
  return Number(column);
}

std::optional<std::int64_t> CsvReader::IntegerOrEmpty(size_t column) {
  if (fields_[column].empty()) return std::nullopt;
  return Integer(column);
}

void CsvReader::Reject(size_t column, const std::string& expected) {
  Fail(fmt::format("{} = '{}': expected {}", columns_[column], Shown(fields_[column]), expected));
}

void CsvReader::RejectFile(const std::string& what) {
  if (ok()) status_ = Error{ErrorKind::kBadInput, name_ + ": " + what};
}

void CsvReader::Fail(const std::string& text) {
  if (ok())
    status_ =
        Error{ErrorKind::kBadInput, fmt::format("{}:{}: {}", name_, std::max<std::int64_t>(line_, 1), text)};
}

}  // namespace tendril
