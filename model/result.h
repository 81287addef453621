#pragma once
// A value or the reason there is none. C++20 on GCC 12 has no std::expected; this is the part we need.

#include <optional>
#include <string>
#include <utility>

namespace tendril {

// What the caller can do about it; also decides the program's exit code (cli/exit_code.h).
enum class ErrorKind {
  kBadInput,     // the call, file or option is wrong: exit 2
  kNotFound,     // exit 2
  kUnreachable,  // well-formed, but has no solution: exit 1
  kDiverged,     // a run that blew up: exit 1
  kIo,           // disk, camera, servo, database: exit 1
  kStopped,      // asked to stop: exit 1
};

struct Error {
  ErrorKind kind;
  std::string message;  // one sentence with the offending value, its unit and what would be accepted

  // Adds where it happened, outermost first: "trial 7: cam1.mkv: frame 812 is truncated".
  Error Within(const std::string& where) && {
    message = where + ": " + message;
    return std::move(*this);
  }
};

template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : value_(std::move(value)) {}
  Result(Error error) : error_(std::move(error)) {}

  bool ok() const { return value_.has_value(); }
  const T& value() const& { return value_.value(); }
  T& value() & { return value_.value(); }
  T&& value() && { return std::move(value_).value(); }
  const Error& error() const& { return error_.value(); }
  Error&& error() && { return std::move(error_).value(); }

 private:
  std::optional<T> value_;
  std::optional<Error> error_;
};

struct Ok {};
using Status = Result<Ok>;

}  // namespace tendril
