// tendril init, db check: a lab is made, and looked after.
#include "cli/lab_commands.h"

#include <memory>

#include "cli/lab_option.h"
#include "db/check.h"

namespace tendril::cli {

Command MakeInitCommand() {
  auto folder = std::make_shared<std::string>(".");
  return {
      .path = "init",
      .help = "make a lab: a folder with a database, and places for designs, rigs and trials",
      .example = "tendril init mylab",
      .declare =
          [folder](CLI::App& app) {
            app.add_option("folder", *folder, "where (default: the current folder)");
          },
      .run = [folder](Output& out) -> Status {
        const auto lab = Lab::Create(*folder);
        if (!lab.ok()) return lab.error();
        out.fields()["lab"] = lab.value().folder().string();
        out.Print("made the lab {}", lab.value().folder().string());
        out.Print("designs/, rigs/: put your TOML files there; trials/: filled by `tendril record`");
        return Ok{};
      },
  };
}

Command MakeDbCheckCommand() {
  auto folder = std::make_shared<std::string>();
  return {
      .path = "db check",
      .help = "is the lab whole: database, schema, and the hash of every recorded file",
      .example = "tendril db check --lab mylab",
      .declare = [folder](CLI::App& app) { AddLabOption(app, *folder); },
      .run = [folder](Output& out) -> Status {
        auto lab = OpenLab(*folder);
        if (!lab.ok()) return lab.error();
        const auto checked = CheckLab(lab.value(), out.ShowProgress("checking files"));
        if (!checked.ok()) return checked.error();
        const LabCheck& check = checked.value();
        out.fields()["schema_version"] = check.schema_version;
        out.fields()["schema_steps"] = check.schema_steps;
        out.fields()["trials"] = check.trials;
        out.fields()["files"] = check.files;
        out.fields()["problems"] = check.problems;
        out.Print("schema {}:", check.schema_version);
        for (size_t i = 0; i < check.schema_steps.size(); ++i) {
          out.Print("  {:4} {}", i + 1, check.schema_steps[i]);
        }
        out.Print("{} trials, {} files", check.trials, check.files);
        for (const std::string& problem : check.problems) out.Print("problem: {}", problem);
        if (check.problems.empty()) {
          out.Print("all is well");
          return Ok{};
        }
        return Error{ErrorKind::kIo, fmt::format("{}: {} found, the first: {}", lab.value().folder().string(),
                                                 check.problems.size() == 1
                                                     ? "1 problem"
                                                     : fmt::format("{} problems", check.problems.size()),
                                                 check.problems.front())};
      },
  };
}

}  // namespace tendril::cli
