// tendril calibrate fold: the fold model's parameters from tracked trials.
#include "cli/calibrate_commands.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calibrate/fold/fold_data.h"
#include "calibrate/fold/fold_fit.h"
#include "calibrate/fold/view_places.h"
#include "capture/record/virtual_trial.h"
#include "cli/fold_models_answer.h"
#include "cli/lab_option.h"
#include "cli/program_version.h"
#include "db/files/design_toml.h"
#include "db/files/safe_file.h"
#include "db/files/toml_write.h"
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

double TrueValue(const std::optional<TrueFold>& truth, const std::string& parameter) {
  if (!truth) return kNotKnown;
  const std::pair<const char*, double> known[] = {
      {"pull_scale", truth->pull_scale},
      {"stiffness_ratio", truth->stiffness_ratio},
      {"stiffness_exponent", truth->stiffness_exponent},
      {"rest_angle_deg", truth->rest_angle * 180 / std::numbers::pi},
      {"friction", truth->friction}};
  for (const auto& [name, value] : known) {
    if (name == parameter) return value;
  }
  return kNotKnown;
}

nlohmann::ordered_json JsonOf(const PullHint& hint, const ViewPlaces& places) {
  nlohmann::ordered_json json = {{"parameter", hint.parameter}, {"best_pull", hint.best_pull},
                                 {"pull", hint.pull},           {"error_ratio", hint.error_ratio},
                                 {"sentence", hint.sentence},   {"view", nullptr}};
  if (!hint.view) return json;
  const ViewHint& view = *hint.view;
  json["view"] = {{"picture_share", view.picture_share},
                  {"picture_share_from_repeats", view.from_repeats},
                  {"perfect_error_ratio", view.perfect_ratio},
                  {"best_place", nullptr},
                  {"place", nlohmann::ordered_json::array()},
                  {"error_ratio", view.error_ratio},
                  {"sentence", view.sentence}};
  if (view.best < 0) return json;
  json["view"]["best_place"] = places.names[static_cast<std::size_t>(view.best)];
  json["view"]["place"] = places.names;
  // How far what cameras would see can be trusted: facets times cameras of the rig.
  json["view"]["sight_check"] = {
      {"asked", places.facets}, {"seen", places.seen}, {"foretold", places.foretold}, {"both", places.both}};
  return json;
}

void Show(Output& out, const std::string& design, const FoldFit& fit, const std::optional<TrueFold>& truth,
          double confidence, const ViewPlaces& places) {
  out.Print("design {}, model {}: {} trials, {} curves ({} left out), residual {:.2f} mm", design,
            NameOf(fit.model), fit.trials, fit.frames_used, fit.left_out.size(), 1e3 * fit.residual_rms);
  out.Print("  {:20} {:>9} {:>9}   {:>4.0f} % interval{}", "parameter", "value", "SE", 100 * confidence,
            truth ? "          true" : "");
  nlohmann::ordered_json parameters = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < fit.parameters.size(); ++i) {
    const FittedParameter& p = fit.parameters[i];
    const double actual = TrueValue(truth, p.name);
    const std::string beside = truth ? fmt::format("   {:9.4f}", actual) : "";
    if (std::isfinite(p.standard_error)) {
      out.Print("  {:20} {:9.4f} {:9.4f}   {:7.4f} .. {:7.4f}{}{}", p.name, p.value, p.standard_error,
                p.interval.low, p.interval.high, beside, p.identified ? "" : "   (not identified)");
    } else {
      out.Print("  {:20} {:9.4f}   not identified{}", p.name, p.value, beside);
    }
    nlohmann::ordered_json one = {{"name", p.name},
                                  {"value", p.value},
                                  {"standard_error", NumberOrNull(p.standard_error)},
                                  {"interval", {NumberOrNull(p.interval.low), NumberOrNull(p.interval.high)}},
                                  {"identified", p.identified}};
    if (!p.identified) one["why"] = p.why;
    if (p.at_bound) one["at_bound"] = true;
    if (truth) one["true"] = actual;
    parameters.push_back(std::move(one));
  }
  for (const std::string& warning : fit.warnings) out.Warn(fmt::format("design {}: {}", design, warning));
  if (fit.hint) out.Print("  {}", fit.hint->sentence);
  if (fit.hint && fit.hint->view) out.Print("  {}", fit.hint->view->sentence);
  nlohmann::ordered_json covariance = nlohmann::ordered_json::array();
  for (Eigen::Index a = 0; a < fit.covariance.rows(); ++a) {
    nlohmann::ordered_json row = nlohmann::ordered_json::array();
    for (Eigen::Index b = 0; b < fit.covariance.cols(); ++b)
      row.push_back(NumberOrNull(fit.covariance(a, b)));
    covariance.push_back(std::move(row));
  }
  nlohmann::ordered_json hint = nullptr;
  if (fit.hint) hint = JsonOf(*fit.hint, places);
  out.fields()["fits"].push_back({{"design", design},
                                  {"model", NameOf(fit.model)},
                                  {"trials", fit.trials},
                                  {"curves", fit.frames_used},
                                  {"curves_left_out", fit.left_out.size()},
                                  {"parameters", std::move(parameters)},
                                  {"covariance", std::move(covariance)},
                                  {"clustered_by_trial", fit.clustered},
                                  {"degrees_of_freedom", fit.degrees_of_freedom},
                                  {"residual_rms_mm", 1e3 * fit.residual_rms},
                                  {"converged", fit.converged},
                                  {"iterations", fit.iterations},
                                  {"seconds", fit.seconds},
                                  {"hint", std::move(hint)}});
}

constexpr std::string_view kFittedDesign = "# Design ";  // how its file begins

// The design with what was fitted in place of what was drawn, for scenes and sweeps.
Status WriteFittedDesign(const std::string& file, TentacleDesign design, const FoldFit& fit,
                         const std::string& name, const std::vector<std::string>& trials, double confidence) {
  std::string text = fmt::format(
      "{}{} with the fold model {} as fitted by {} to {} trials (residual {:.3f} mm).\n", kFittedDesign, name,
      NameOf(fit.model), ProgramVersion(), fit.trials, 1e3 * fit.residual_rms);
  design.law = fit.model.law;
  if (fit.model.law == FoldLaw::kPaper) design.rest_angle = design.tendon_friction = 0;
  for (const FittedParameter& p : fit.parameters) {
    text += fmt::format("#   {} = {:.6g}, ", p.name, p.value);
    text += p.identified ? fmt::format("{:.3g} % interval {:.6g} .. {:.6g}\n", 100 * confidence,
                                       p.interval.low, p.interval.high)
                         : fmt::format("not identified: {}\n", p.why);
    if (p.name == "pull_scale") design.pull_scale = p.value;
    if (p.name == "stiffness_ratio") design.stiffness_ratio = p.value;
    if (p.name == "stiffness_exponent") design.stiffness_exponent = p.value;
    if (p.name == "rest_angle_deg") design.rest_angle = RadiansOfDegrees(p.value);
    if (p.name == "friction") design.tendon_friction = p.value;
  }
  text += "# Trials:";
  for (const std::string& trial : trials) text += " " + trial;
  return WriteText(file, text + "\n\n" + DesignToml(design));
}

Status FitDesign(Lab& lab, const CalibrateFoldCall& call, const std::string& design,
                 const std::vector<Chosen>& trials, Output& out) {
  std::vector<FoldObservation> observations;
  Provenance provenance{.program_version = ProgramVersion()};
  FitRow row;
  ViewPlaces places;
  std::optional<TentacleDesign> own;  // as the trials state it: odd tentacles may have its mirror image
  for (const Chosen& trial : trials) {
    Result<FoldData> data = LoadFoldData(lab.TrialFolder(trial.id));
    if (!data.ok()) return data.error();
    for (const std::string& warning : data.value().warnings) out.Warn(warning);
    // The fit does not need them: what is wrong there costs the hint alone.
    const Result<ViewPlaces> views = AddViews(lab.TrialFolder(trial.id), data.value());
    if (views.ok()) {
      MergePlaces(views.value(), places);
    } else {
      out.Warn(fmt::format("no hint of other views: {}", views.error().message));
    }
    for (FoldObservation& o : data.value().observations) observations.push_back(std::move(o));
    for (auto& input : data.value().input_sha256) provenance.input_sha256.push_back(std::move(input));
    row.trial_ids.push_back(trial.id);
    if (!own) own = data.value().trial.design;
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

  Show(out, design, *fit, truth, call.confidence, places);
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
