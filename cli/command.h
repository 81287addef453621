#pragma once
// A command of the program: its place in the tree, its options, and what it prints.
//
// Answers go to stdout, as text for people or, under --json, as one JSON object; all else goes to stderr.

#include <fmt/core.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cmath>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "model/progress.h"
#include "model/result.h"

namespace tendril::cli {

class Output {
 public:
  explicit Output(bool json) : json_(json) {}

  bool json() const { return json_; }

  // What --json prints when the command is done: one object, fields in the order they were added; of a
  // command that failed with `error`, its message.
  nlohmann::ordered_json& fields() { return fields_; }

  // For a command that answers again and again: --json prints one object a line, and fields() is the last
  // line.
  void AnswerInLines() { json_lines_ = true; }
  bool json_lines() const { return json_lines_; }
  void PrintJsonLine(const nlohmann::ordered_json& object) const;

  // A line for people; nothing under --json. The format has no newline at its end.
  template <class... Args>
  void Print(fmt::format_string<Args...> format, Args&&... args) {
    if (!json_) PrintLine(fmt::format(format, std::forward<Args>(args)...));
  }

  // A warning on stderr, also listed in the JSON object's `warnings`.
  void Warn(const std::string& message);

  // A bar on stderr (a line per tenth where stderr is no terminal). Asks to stop after Ctrl-C.
  //   note  what to say beside the share that is done; empty: nothing
  Progress ShowProgress(const std::string& label, std::function<std::string(double done)> note = {});

 private:
  static void PrintLine(const std::string& line);

  bool json_;
  bool json_lines_ = false;
  nlohmann::ordered_json fields_ = nlohmann::ordered_json::object();
};

// JSON has no NaN: what is not known is null.
inline nlohmann::ordered_json NumberOrNull(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

// Whether Ctrl-C (SIGINT) or SIGTERM arrived; long commands end at the next safe point.
bool StopRequested();

struct Command {
  std::string path;     // "trials show": words of the tree, from the root
  std::string help;     // one line
  std::string example;  // a call that works, shown by --help
  std::function<void(CLI::App&)> declare;
  std::function<Status(Output&)> run;
};

// Parses the call, runs the command, prints its answer; returns the exit code.
int Main(int argc, const char* const* argv);

}  // namespace tendril::cli
