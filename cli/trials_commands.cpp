// tendril trials list, show, outcome, note, void: what a lab knows about its trials, and what people say of
// them.
#include "cli/trials_commands.h"

#include <cmath>
#include <memory>

#include "cli/lab_option.h"
#include "cli/stored_simulation.h"
#include "db/trial_details.h"
#include "db/trial_query.h"
#include "db/trial_store.h"

namespace tendril::cli {
namespace {

using Json = nlohmann::ordered_json;

const std::vector<std::string> kKinds = {"real", "virtual", "simulated", "published"};
const std::vector<std::string> kStates = {"recording", "recorded", "degraded", "aborted", "failed"};

template <class Value>
Json JsonOf(const std::optional<Value>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json JsonOf(const TrialOverview& trial) {
  return {{"id", trial.id},
          {"label", trial.label},
          {"kind", NameOf(trial.kind)},
          {"state", NameOf(trial.state)},
          {"started_ns", trial.started_ns},
          {"design", trial.design},
          {"object", trial.object},
          {"medium", trial.medium},
          {"distance_m", trial.distance},
          {"pull", trial.pull},
          {"void", trial.voided},
          {"grasped", JsonOf(trial.grasped)},
          {"trusted", trial.trusted}};
}

// A command about one trial: the lab, the trial as it was named, and the id it has.
struct TrialCall {
  std::string lab;
  std::string trial;
  std::string by;
  std::string text;
};

void DeclareTrial(CLI::App& app, TrialCall& call) {
  app.add_option("trial", call.trial, "the trial's id, a unique beginning of it, or its label")->required();
  AddLabOption(app, call.lab);
}

// Opens the lab, finds the trial, and hands both on.
template <class Work>
Status WithTrial(const TrialCall& call, Output& out, Work work) {
  auto lab = OpenLab(call.lab);
  if (!lab.ok()) return lab.error();
  const auto id = FindTrial(lab.value(), call.trial);
  if (!id.ok()) return id.error();
  out.fields()["id"] = id.value();
  return work(lab.value(), id.value());
}

struct ListCall {
  std::string lab;
  std::string kind;
  std::string state;
  std::string design;
};

Status RunList(const ListCall& call, Output& out) {
  auto lab = OpenLab(call.lab);
  if (!lab.ok()) return lab.error();
  TrialFilter filter;
  if (!call.kind.empty()) filter.kind = TrialKindOf(call.kind);
  if (!call.state.empty()) filter.state = TrialStateOf(call.state);
  if (!call.design.empty()) filter.design = call.design;
  const auto trials = ListTrials(lab.value(), filter);
  if (!trials.ok()) return trials.error();
  auto& list = out.fields()["trials"] = Json::array();
  size_t label = 5;
  size_t design = 6;
  for (const TrialOverview& trial : trials.value()) {
    list.push_back(JsonOf(trial));
    label = std::max(label, trial.label.size());
    design = std::max(design, trial.design.size());
  }
  if (trials.value().empty()) {
    out.Print("no trials");
    return Ok{};
  }
  out.Print("{:<36}  {:<{}}  {:<9}  {:<9}  {:<19}  {:<{}}  {:>10}  {:<7}  {}", "id", "label", label, "kind",
            "state", "started (UTC)", "design", design, "distance_m", "medium", "outcome");
  for (const TrialOverview& trial : trials.value()) {
    out.Print("{:<36}  {:<{}}  {:<9}  {:<9}  {:<19}  {:<{}}  {:>10.6g}  {:<7}  {}", trial.id, trial.label,
              label, NameOf(trial.kind), NameOf(trial.state), UtcText(trial.started_ns), trial.design, design,
              trial.distance, trial.medium, OutcomeText(trial));
  }
  return Ok{};
}

void AddDetails(const TrialDetails& details, Output& out) {
  auto& fields = out.fields();
  fields.update(JsonOf(details.overview));
  fields["state_reason"] = details.state_reason;
  fields["notes"] = details.notes;
  fields["files"] = Json::array();
  for (const RecordedFile& file : details.files) {
    fields["files"].push_back({{"role", file.role},
                               {"file", file.file},
                               {"sha256", file.sha256},
                               {"frames", JsonOf(file.frames)},
                               {"dropped", JsonOf(file.dropped)}});
  }
  fields["results"] = Json::array();
  for (const DerivedResult& result : details.results) {
    Json values = Json::object();
    for (const auto& [name, value] : result.values) values[name] = JsonOf(value);
    fields["results"].push_back({{"what", result.what},
                                 {"values", values},
                                 {"made_ns", result.made_ns},
                                 {"program_version", result.program_version}});
  }
  fields["events"] = Json::array();
  for (const TrialEvent& event : details.events) {
    fields["events"].push_back({{"at_ns", event.at_ns},
                                {"what", event.what},
                                {"by", event.by},
                                {"by_person", event.by_person},
                                {"counts", event.counts},
                                {"text", event.text},
                                {"load_N", JsonOf(event.load_N)}});
  }
  if (details.simulation) fields["simulation"] = SimulationAsJson(*details.simulation);
}

void PrintDetails(const TrialDetails& details, Output& out) {
  const TrialOverview& trial = details.overview;
  out.Print("trial {} ({})", trial.label, trial.id);
  out.Print("  {}, {}{}{}", NameOf(trial.kind), NameOf(trial.state), details.state_reason.empty() ? "" : ": ",
            details.state_reason);
  out.Print("  started {} UTC", UtcText(trial.started_ns));
  out.Print("  design {}, object {} at {:.6g} m, in {}, pull {:.6g}", trial.design, trial.object,
            trial.distance, trial.medium, trial.pull);
  out.Print("  outcome: {}", OutcomeText(trial));
  if (!details.notes.empty()) out.Print("  {}", details.notes);
  if (details.simulation) PrintSimulation(*details.simulation, out);
  if (!details.files.empty()) out.Print("files:");
  for (const RecordedFile& file : details.files) {
    std::string counts;
    if (file.frames) counts += fmt::format(", {} frames", *file.frames);
    if (file.dropped) counts += fmt::format(", {} dropped", *file.dropped);
    out.Print("  {:<12} {}{}", file.role, file.file, counts);
  }
  for (const DerivedResult& result : details.results) {
    out.Print("{}, made {} UTC by {}:", result.what, UtcText(result.made_ns), result.program_version);
    for (const auto& [name, value] : result.values) {
      out.Print("  {:<22} {}", name, value ? fmt::format("{:.6g}", *value) : "not known");
    }
  }
  if (!details.events.empty()) out.Print("events:");
  for (const TrialEvent& event : details.events) {
    out.Print("  {}  {} by {}{}{}{}{}", UtcText(event.at_ns), event.what, event.by,
              event.by_person ? "" : " (automatic)", event.counts ? " (counts)" : "",
              event.text.empty() ? "" : ": " + event.text,
              event.load_N ? fmt::format(" [load {:.4g} N]", *event.load_N) : "");
  }
}

struct OutcomeCall {
  TrialCall trial;
  bool success = false;
  bool failure = false;
  std::string method;
  std::string notes;
  double load_N = kNotKnown;
};

Status RunOutcome(const OutcomeCall& call, Output& out) {
  if (call.success == call.failure) {
    return Error{ErrorKind::kBadInput, "expected --success or --failure, one of them"};
  }
  if (call.load_N < 0 || std::isinf(call.load_N)) {
    return Error{ErrorKind::kBadInput, fmt::format("--load-N {}: expected a force >= 0 N", call.load_N)};
  }
  return WithTrial(call.trial, out, [&](Lab& lab, const std::string& id) -> Status {
    const Outcome outcome{.grasped = call.success,
                          .judged_by = call.trial.by,
                          .by_person = true,
                          .method = call.method,
                          .notes = call.notes,
                          .load_N = call.load_N};
    if (Status added = AddOutcome(lab, id, outcome); !added.ok()) return added;
    out.fields()["grasped"] = call.success;
    out.Print("trial {}: {}, judged by {}", call.trial.trial, call.success ? "success" : "failure",
              call.trial.by);
    return Ok{};
  });
}

}  // namespace

std::string OutcomeText(const TrialOverview& trial) {
  if (trial.voided) return "void";
  const std::string judged = !trial.grasped ? "-" : *trial.grasped ? "success" : "failure";
  return trial.trusted ? judged : judged + " (not trusted)";
}

Command MakeTrialsListCommand() {
  auto call = std::make_shared<ListCall>();
  return {
      .path = "trials list",
      .help = "the lab's trials, oldest first",
      .example = "tendril trials list --kind real --state recorded",
      .declare =
          [call](CLI::App& app) {
            AddLabOption(app, call->lab);
            app.add_option("--kind", call->kind, "only this kind")->check(CLI::IsMember(kKinds));
            app.add_option("--state", call->state, "only this state")->check(CLI::IsMember(kStates));
            app.add_option("--design", call->design, "only this design");
          },
      .run = [call](Output& out) { return RunList(*call, out); },
  };
}

Command MakeTrialsShowCommand() {
  auto call = std::make_shared<TrialCall>();
  return {
      .path = "trials show",
      .help = "all that is known about a trial",
      .example = "tendril trials show trial-12",
      .declare = [call](CLI::App& app) { DeclareTrial(app, *call); },
      .run = [call](Output& out) -> Status {
        return WithTrial(*call, out, [&](Lab& lab, const std::string& id) -> Status {
          const auto details = TrialDetailsOf(lab, id);
          if (!details.ok()) return details.error();
          AddDetails(details.value(), out);
          PrintDetails(details.value(), out);
          return Ok{};
        });
      },
  };
}

Command MakeTrialsOutcomeCommand() {
  auto call = std::make_shared<OutcomeCall>();
  return {
      .path = "trials outcome",
      .help = "say whether a trial grasped its object; the newest judgement by a person counts",
      .example = "tendril trials outcome trial-12 --success --by Ada --method 'pull test' --load-N 4.2",
      .declare =
          [call](CLI::App& app) {
            DeclareTrial(app, call->trial);
            app.add_flag("--success", call->success, "the object was grasped");
            app.add_flag("--failure", call->failure, "it was not");
            app.add_option("--by", call->trial.by, "who judged")->required();
            app.add_option("--method", call->method, "how it was judged");
            app.add_option("--load-N", call->load_N, "pull-out force, N");
            app.add_option("--notes", call->notes, "anything else");
          },
      .run = [call](Output& out) { return RunOutcome(*call, out); },
  };
}

Command MakeTrialsNoteCommand() {
  auto call = std::make_shared<TrialCall>();
  return {
      .path = "trials note",
      .help = "add a note to a trial",
      .example = "tendril trials note trial-12 'the string slipped off tentacle 3' --by Ada",
      .declare =
          [call](CLI::App& app) {
            DeclareTrial(app, *call);
            app.add_option("text", call->text, "the note")->required();
            app.add_option("--by", call->by, "who writes")->required();
          },
      .run = [call](Output& out) -> Status {
        return WithTrial(*call, out, [&](Lab& lab, const std::string& id) -> Status {
          if (Status added = AddNote(lab, id, call->text, call->by); !added.ok()) return added;
          out.Print("noted");
          return Ok{};
        });
      },
  };
}

Command MakeTrialsVoidCommand() {
  auto call = std::make_shared<TrialCall>();
  return {
      .path = "trials void",
      .help = "take a trial out of every rate, for good",
      .example = "tendril trials void trial-12 --reason 'the string tore' --by Ada",
      .declare =
          [call](CLI::App& app) {
            DeclareTrial(app, *call);
            app.add_option("--reason", call->text, "why")->required();
            app.add_option("--by", call->by, "who decides")->required();
          },
      .run = [call](Output& out) -> Status {
        return WithTrial(*call, out, [&](Lab& lab, const std::string& id) -> Status {
          if (Status added = VoidTrial(lab, id, call->text, call->by); !added.ok()) return added;
          out.Print("trial {} no longer counts", call->trial);
          return Ok{};
        });
      },
  };
}

}  // namespace tendril::cli
