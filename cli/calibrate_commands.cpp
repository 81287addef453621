// tendril calibrate fold: the fold model's parameters from tracked trials.
#include "cli/calibrate_commands.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "calibrate/fold/fold_data.h"
#include "calibrate/fold/fold_fit.h"
#include "calibrate/fold/view_places.h"
#include "capture/record/virtual_trial.h"
#include "cli/fold_fit_answer.h"
#include "cli/fold_models_answer.h"
#include "cli/lab_option.h"
#include "cli/program_version.h"
#include "db/files/safe_file.h"
#include "db/trial_query.h"
#include "db/trial_store.h"

namespace tendril::cli {
namespace {

struct CalibrateFoldCall {
  std::string lab;
  std::vector<std::string> trials;
  std::string design;
  std::string kind;
  double lag = 0.25;
  double confidence = 0.95;
  bool dry_run = false;
  std::string model = "paper";
  bool compare = false;
  std::string profile;
  std::string out;
};

struct Chosen {
  std::string id;
  std::string label;
  TrialKind kind = TrialKind::kReal;
};

// The trials asked for, by design. Named ones must be there; otherwise all that are recorded, tracked and not
// void, of one kind.
Result<std::map<std::string, std::vector<Chosen>>> ChooseTrials(Lab& lab, const CalibrateFoldCall& call) {
  std::map<std::string, std::vector<Chosen>> by_design;
  const Result<std::vector<TrialOverview>> all = ListTrials(lab);
  if (!all.ok()) return all.error();
  if (!call.trials.empty()) {
    std::vector<std::string> wanted;
    for (const std::string& name : call.trials) {
      const Result<std::string> id = FindTrial(lab, name);
      if (!id.ok()) return id.error();
      if (std::find(wanted.begin(), wanted.end(), id.value()) == wanted.end()) wanted.push_back(id.value());
    }
    for (const TrialOverview& trial : all.value()) {
      if (std::find(wanted.begin(), wanted.end(), trial.id) == wanted.end()) continue;
      by_design[trial.design].push_back({trial.id, trial.label, trial.kind});
    }
  } else {
    const std::optional<TrialKind> kind = call.kind.empty() ? TrialKind::kReal : TrialKindOf(call.kind);
    for (const TrialOverview& trial : all.value()) {
      const bool usable = trial.state == TrialState::kRecorded || trial.state == TrialState::kDegraded;
      if (!usable || trial.voided || trial.kind != kind) continue;
      if (!call.design.empty() && trial.design != call.design) continue;
      if (!std::filesystem::exists(lab.TrialFolder(trial.id) / "curves.h5")) continue;
      by_design[trial.design].push_back({trial.id, trial.label, trial.kind});
    }
  }
  for (const auto& [design, trials] : by_design) {
    for (const Chosen& trial : trials) {
      if (trial.kind == trials.front().kind) continue;
      return Error{
          ErrorKind::kBadInput,
          fmt::format("trials {} ({}) and {} ({}) are of different kinds; fit each kind alone",
                      trials.front().label, NameOf(trials.front().kind), trial.label, NameOf(trial.kind))};
    }
  }
  if (by_design.empty()) {
    return Error{
        ErrorKind::kNotFound,
        fmt::format("no tracked {} trial{} to fit; `tendril trials list` shows what there is (other kinds: "
                    "--kind virtual, ...)",
                    call.kind.empty() ? "real" : call.kind,
                    call.design.empty() ? std::string() : fmt::format(" of design `{}`", call.design))};
  }
  return by_design;
}

// What the virtual rig hid in each trial, if it is the same in all of them.
std::optional<TrueFold> TruthOf(Lab& lab, const std::vector<Chosen>& trials) {
  std::optional<TrueFold> truth;
  for (const Chosen& trial : trials) {
    if (trial.kind != TrialKind::kVirtual) return std::nullopt;
    const Result<TruthFile> file = ReadTruthFile(lab.TrialFolder(trial.id) / "truth.toml");
    if (!file.ok()) return std::nullopt;
    const TrueFold& fold = file.value().fold;
    if (truth && (truth->pull_scale != fold.pull_scale || truth->stiffness_ratio != fold.stiffness_ratio ||
                  truth->stiffness_exponent != fold.stiffness_exponent || truth->law != fold.law ||
                  truth->rest_angle != fold.rest_angle || truth->friction != fold.friction)) {
      return std::nullopt;
    }
    truth = fold;
  }
  return truth;
}

Status FitDesign(Lab& lab, const CalibrateFoldCall& call, const std::string& design,
                 const std::vector<Chosen>& trials, Output& out) {
  std::vector<FoldObservation> observations;
  Provenance provenance{.program_version = ProgramVersion()};
  FitRow row;
  ViewPlaces places;
  std::vector<std::string> no_places;  // trials of which nobody knows which camera saw what
  std::optional<TentacleDesign> own;   // as the trials state it: odd tentacles may have its mirror image
  for (const Chosen& trial : trials) {
    Result<FoldData> data = LoadFoldData(lab.TrialFolder(trial.id));
    if (!data.ok()) return data.error();
    for (const std::string& warning : data.value().warnings) out.Warn(warning);
    // The fit does not need them: what is wrong there costs the hint alone.
    const Result<ViewPlaces> views = AddViews(lab.TrialFolder(trial.id), data.value());
    if (views.ok()) {
      MergePlaces(views.value(), places);
      if (views.value().names.empty()) no_places.push_back(trial.label);
    } else {
      out.Warn(fmt::format("no hint of other views: {}", views.error().message));
      no_places.push_back(trial.label);
    }
    for (FoldObservation& o : data.value().observations) observations.push_back(std::move(o));
    for (auto& input : data.value().input_sha256) provenance.input_sha256.push_back(std::move(input));
    row.trial_ids.push_back(trial.id);
    if (!own) own = data.value().trial.design;
  }
  if (!no_places.empty() && !places.names.empty()) {
    out.Warn(fmt::format(
        "no hint of other views: trial{} {} without residuals.csv or fold angles; track {} again",
        no_places.size() > 1 ? "s" : "", fmt::join(no_places, ", "), no_places.size() > 1 ? "them" : "it"));
    places = {};
  }
  FoldFitOptions options;
  options.longest_lag = call.lag;
  options.confidence = call.confidence;
  options.model = *FoldModelOf(call.model);
  options.places = places.names;
  const std::optional<TrueFold> truth = TruthOf(lab, trials);
  std::optional<FoldFit> fit;
  if (call.compare) {
    Result<FoldFit> chosen = CompareModels(observations, options, design, truth, out);
    if (!chosen.ok()) return chosen.error();
    fit = std::move(chosen).value();
    options.model = fit->model;
  }
  if (!call.profile.empty()) {
    const Status s = ShowProfile(observations, options, call.profile, design, out);
    // Who asks for a profile and lets the data choose the model cannot know what that has.
    const bool not_in_choice = !s.ok() && call.compare && s.error().kind == ErrorKind::kBadInput;
    if (not_in_choice) {
      out.Warn(s.error().message);
    } else if (!s.ok()) {
      return s;
    }
  }
  if (!fit) {
    Result<FoldFit> asked = FitFold(observations, options, out.ShowProgress("fit " + design));
    if (!asked.ok()) return Error(asked.error()).Within("design " + design);
    fit = std::move(asked).value();
  }

  ShowFit(design, *fit, truth, call.confidence, places, out);
  const Result<int> with_law = TrackedWithFoldLaw(lab, row.trial_ids);
  if (!with_law.ok()) return with_law.error();
  out.fields()["fits"].back()["trials_tracked_with_fold_law"] = with_law.value();
  if (with_law.value() > 0) {
    out.Print(
        "  curves of {} of {} trials were tracked with the fold law as a weak prior (without: track "
        "--no-fold-law)",
        with_law.value(), fit->trials);
  }
  if (!call.out.empty()) {
    if (const Status s = WriteFittedDesign(call.out, *own, *fit, design, row.trial_ids, call.confidence);
        !s.ok()) {
      return s;
    }
    out.fields()["fits"].back()["out"] = call.out;
    out.Print("  fitted design          {}", call.out);
  }
  if (call.dry_run) return Ok{};
  row.scope = fmt::format("design {}", design);
  row.model = fit->model == FoldModel{} ? "fold" : "fold:" + NameOf(fit->model);
  row.residual_rms_m = fit->residual_rms;
  for (std::size_t i = 0; i < fit->parameters.size(); ++i) {
    const FittedParameter& p = fit->parameters[i];
    row.parameters.push_back({p.name, p.value, p.standard_error, p.identified, TrueValue(truth, p.name)});
  }
  provenance.parameters_json = nlohmann::json{
      {"model", NameOf(fit->model)},
      {"chosen_by_comparison", call.compare},
      {"lag_s", call.lag},
      {"confidence", call.confidence},
      {"residual", "distances"},
      {"creases", options.residual.creases},
      {"model_error_m", options.residual.model_error},
      {"huber", options.huber}}.dump();
  return StoreFit(lab, row, provenance);
}

Status RunCalibrateFold(const CalibrateFoldCall& call, Output& out) {
  Result<Lab> lab = OpenLab(call.lab);
  if (!lab.ok()) return lab.error();
  const auto by_design = ChooseTrials(lab.value(), call);
  if (!by_design.ok()) return by_design.error();
  if (!call.out.empty()) {
    const std::filesystem::path folder = std::filesystem::absolute(call.out).parent_path();
    if (!std::filesystem::is_directory(folder)) {
      return Error{ErrorKind::kNotFound,
                   fmt::format("--out {}: there is no folder {}; make it, or name another", call.out,
                               folder.string())};
    }
    if (std::filesystem::is_directory(call.out))
      return Error{ErrorKind::kBadInput,
                   fmt::format("--out {}: is a folder; expected a file (TOML)", call.out)};
    if (access(folder.c_str(), W_OK) != 0)
      return Error{ErrorKind::kBadInput,
                   fmt::format("--out {}: {} cannot be written to; name a file in another folder", call.out,
                               folder.string())};
  }
  if (!call.out.empty() && std::filesystem::exists(call.out)) {
    const Result<std::string> there = ReadText(call.out);
    if (!there.ok()) return there.error();
    if (!there.value().starts_with(kFittedDesign)) {
      return Error{ErrorKind::kBadInput,
                   call.out +
                       ": not a file that calibrate fold wrote; expected one of these to "
                       "replace, or none: name another with --out"};
    }
  }
  if (!call.out.empty() && by_design.value().size() > 1) {
    return Error{ErrorKind::kBadInput, fmt::format("--out {}: {} designs are fitted; name one with --design",
                                                   call.out, by_design.value().size())};
  }
  out.fields()["fits"] = nlohmann::ordered_json::array();
  for (const auto& [design, trials] : by_design.value()) {
    if (Status s = FitDesign(lab.value(), call, design, trials, out); !s.ok()) return s;
  }
  return Ok{};
}

}  // namespace

Command MakeCalibrateFoldCommand() {
  auto call = std::make_shared<CalibrateFoldCall>();
  return {
      .path = "calibrate fold",
      .help =
          "fit a fold model (pull scale, stiffnesses, rest angle, friction) to tracked trials, design by "
          "design",
      .example =
          "tendril calibrate fold --lab mylab --kind virtual --design paper --compare --out fitted.toml",
      .declare =
          [call](CLI::App& app) {
            AddLabOption(app, call->lab);
            CLI::Option* const trials =
                app.add_option("--trials", call->trials,
                               "ids or labels, separated by commas (default: all tracked)")
                    ->delimiter(',');
            app.add_option("--design", call->design, "only trials of this design (its name)")
                ->excludes(trials);
            app.add_option("--kind", call->kind, "kind of trial (default: real)")
                ->check(CLI::IsMember({"real", "virtual", "simulated", "published"}))
                ->excludes(trials);
            app.add_option(
                   "--lag", call->lag,
                   "a tentacle has followed its servo's command after this time, s; curves in which the "
                   "command moved more recently have their pull fitted")
                ->check(CLI::NonNegativeNumber)
                ->capture_default_str();
            app.add_option("--confidence", call->confidence, "of the intervals, as a fraction (0 to 1)")
                ->check(CLI::Range(0.5, 0.9999))
                ->capture_default_str();
            std::vector<std::string> models;
            for (const FoldModel& model : AllFoldModels()) models.push_back(NameOf(model));
            CLI::Option* const model =
                app.add_option("--model", call->model,
                               "law and the parameters that are fitted beside the three")
                    ->check(CLI::IsMember(models))
                    ->capture_default_str();
            app.add_flag(
                   "--compare", call->compare,
                   "fit the laws with and without rest angle and friction, say which the data ask for, and "
                   "fit and store that one")
                ->excludes(model);
            app.add_option(
                   "--profile", call->profile,
                   "a parameter: its interval from how the fit worsens when it is moved, drawn as text")
                ->check(CLI::IsMember(
                    std::vector<std::string>(FoldParameterNames().begin(), FoldParameterNames().end())));
            app.add_option("--out", call->out,
                           "write the design with the fitted values, which scenes fold by (TOML)");
            app.add_flag("--dry-run", call->dry_run, "print the fit, store nothing in the lab");
          },
      .run = [call](Output& out) { return RunCalibrateFold(*call, out); },
  };
}

}  // namespace tendril::cli
