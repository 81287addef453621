#include "cli/command.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <exception>
#include <map>
#include <optional>

#include "cli/commands.h"
#include "cli/exit_code.h"
#include "db/files/nearest_name.h"

namespace tendril::cli {
namespace {

volatile std::sig_atomic_t stop_requested = 0;

void RequestStop(int) { stop_requested = 1; }

// The subcommand of that name; null where there is none.
CLI::App* Child(CLI::App& parent, const std::string& name) {
  const auto found = parent.get_subcommands([&](CLI::App* app) { return app->get_name() == name; });
  return found.empty() ? nullptr : found.front();
}

// The App of a path, made on the way down where it does not exist yet.
CLI::App* AppAt(CLI::App& root, const std::string& path) {
  CLI::App* at = &root;
  size_t begin = 0;
  while (begin < path.size()) {
    const size_t end = std::min(path.find(' ', begin), path.size());
    const std::string word = path.substr(begin, end - begin);
    CLI::App* next = Child(*at, word);
    if (next == nullptr) {
      next = at->add_subcommand(word);
      at->require_subcommand(1);
    }
    at = next;
    begin = end + 1;
  }
  return at;
}

// Of a call that cannot be parsed.
bool AsksForJson(int argc, const char* const* argv) {
  return std::any_of(argv, argv + argc, [](const char* word) { return std::string(word) == "--json"; });
}

void PrintError(const std::string& message) {
  fmt::print("{}\n", nlohmann::ordered_json{{"error", message}}.dump(2));
}

const std::map<std::string, std::string> kGroupHelp = {
    {"design", "a design's geometry, cut pattern and tag sheet"},
    {"trials", "list, read and annotate trials"},
    {"calibrate", "estimate cameras, servos or the fold model from recordings"},
    {"plot", "draw curves, curvature, links and success rates (SVG or PNG)"},
    {"db", "look after the lab's database"},
};

}  // namespace

bool StopRequested() { return stop_requested != 0; }

void Output::PrintLine(const std::string& line) { fmt::print("{}\n", line); }

void Output::PrintJsonLine(const nlohmann::ordered_json& object) const {
  if (!json_) return;
  fmt::print("{}\n", object.dump());
  std::fflush(stdout);
}

void Output::Warn(const std::string& message) {
  spdlog::warn("{}", message);
  fields_["warnings"].push_back(message);
}

Progress Output::ShowProgress(const std::string& label, std::function<std::string(double done)> note) {
  const bool terminal = isatty(STDERR_FILENO) != 0;
  return [label, terminal, note = std::move(note), last = -1](double done) mutable {
    const int percent = static_cast<int>(std::floor(100 * std::min(1.0, std::max(0.0, done))));
    const int shown = terminal ? percent : percent / 10 * 10;
    if (shown != last) {
      last = shown;
      const std::string beside = note ? "  " + note(done) : "";
      if (terminal) {
        const int filled = percent * 30 / 100;
        std::fprintf(stderr, "\r%-24s [%s%s] %3d %%%s%s", label.c_str(), std::string(filled, '#').c_str(),
                     std::string(30 - filled, '.').c_str(), percent, beside.c_str(),
                     percent == 100 ? "\n" : "");
      } else {
        std::fprintf(stderr, "%s: %d %%%s\n", label.c_str(), shown, beside.c_str());
      }
      std::fflush(stderr);
    }
    return !StopRequested();
  };
}

int Main(int argc, const char* const* argv) {
  std::signal(SIGINT, RequestStop);
  std::signal(SIGTERM, RequestStop);
  spdlog::set_default_logger(spdlog::stderr_color_mt("tendril"));
  spdlog::set_pattern("%n: %^%l%$: %v");

  CLI::App root{"Experiments with grippers of tendon-driven origami tentacles, from video to success rates."};
  root.set_version_flag("--version", TENDRIL_VERSION);
  root.require_subcommand(1);
  root.failure_message([](const CLI::App*, const CLI::Error& error) {
    std::string what = error.what();
    // CLI11 states "positive" as a range up to the largest double, in 309 digits.
    const size_t huge = what.find(" not in range 0.000000 to 1797");
    if (huge != std::string::npos) what.replace(huge, std::string::npos, ": expected a number above 0");
    return fmt::format("tendril: error: {} (--help shows how to call it)\n", what);
  });

  std::vector<Command> commands = AllCommands();
  std::vector<std::pair<CLI::App*, Command*>> declared;
  bool json = false;
  for (Command& command : commands) {
    CLI::App* app = AppAt(root, command.path);
    app->description(command.help);
    app->footer("Example:\n  " + command.example);
    app->add_flag("--json", json, "print one JSON object instead of text");
    command.declare(*app);
    declared.emplace_back(app, &command);
  }
  for (const auto& [group, help] : kGroupHelp) {
    if (CLI::App* app = Child(root, group)) app->description(help);
  }

  // CLI11 would only say that a subcommand is required.
  const CLI::App* at = &root;
  for (int i = 1; i < argc && argv[i][0] != '-'; ++i) {
    std::vector<std::string> names;
    for (const CLI::App* app : at->get_subcommands({})) names.push_back(app->get_name());
    if (names.empty()) break;
    const auto known = std::find(names.begin(), names.end(), argv[i]);
    if (known == names.end()) {
      const std::optional<std::string> near = NearestName(argv[i], names);
      const std::string message = fmt::format("there is no command '{}'{} (--help lists them)", argv[i],
                                              near ? "; did you mean '" + *near + "'?" : "");
      spdlog::error("{}", message);
      if (AsksForJson(argc, argv)) PrintError(message);
      return 2;
    }
    at = at->get_subcommand(*known);
  }

  try {
    root.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = root.exit(error);
    if (code != 0 && AsksForJson(argc, argv)) PrintError(error.what());
    return code == 0 ? 0 : 2;
  }

  for (const auto& [app, command] : declared) {
    if (!app->parsed() || !app->get_subcommands().empty()) continue;
    Output out(json);
    Status done = Ok{};
    try {
      done = command->run(out);
    } catch (const std::exception& error) {
      // Libraries turn their exceptions into a Result; what arrives here is a fault of ours, but still one
      // line.
      done = Error{ErrorKind::kIo, std::string("unexpected: ") + error.what()};
    }
    if (!done.ok()) out.fields()["error"] = done.error().message;
    if (json) fmt::print("{}\n", out.fields().dump(out.json_lines() ? -1 : 2));
    if (done.ok()) return 0;
    spdlog::error("{}", done.error().message);
    return ExitCode(done.error().kind);
  }
  return 2;
}

}  // namespace tendril::cli
