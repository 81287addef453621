// tendril calibrate fold: the fold model's parameters from tracked trials.
#include "cli/calibrate_commands.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "calibrate/fold/fold_data.h"
#include "calibrate/fold/fold_fit.h"
#include "capture/record/virtual_trial.h"
#include "cli/lab_option.h"
#include "cli/program_version.h"
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
                  truth->stiffness_exponent != fold.stiffness_exponent)) {
      return std::nullopt;
    }
    truth = fold;
  }
  return truth;
}

double TrueValue(const std::optional<TrueFold>& truth, std::size_t parameter) {
  if (!truth) return kNotKnown;
  return parameter == 0   ? truth->pull_scale
         : parameter == 1 ? truth->stiffness_ratio
                          : truth->stiffness_exponent;
}

void Show(Output& out, const std::string& design, const FoldFit& fit, const std::optional<TrueFold>& truth,
          double confidence) {
  out.Print("design {}: {} trials, {} curves ({} left out), residual {:.2f} mm", design, fit.trials,
            fit.frames_used, fit.left_out.size(), 1e3 * fit.residual_rms);
  out.Print("  {:20} {:>9} {:>9}   {:>4.0f} % interval{}", "parameter", "value", "SE", 100 * confidence,
            truth ? "          true" : "");
  nlohmann::ordered_json parameters = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < fit.parameters.size(); ++i) {
    const FittedParameter& p = fit.parameters[i];
    const double actual = TrueValue(truth, i);
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
    if (truth) one["true"] = actual;
    parameters.push_back(std::move(one));
  }
  for (const std::string& warning : fit.warnings) out.Warn(fmt::format("design {}: {}", design, warning));
  nlohmann::ordered_json covariance = nlohmann::ordered_json::array();
  for (int a = 0; a < kFoldParameters; ++a) {
    nlohmann::ordered_json row = nlohmann::ordered_json::array();
    for (int b = 0; b < kFoldParameters; ++b) row.push_back(NumberOrNull(fit.covariance(a, b)));
    covariance.push_back(std::move(row));
  }
  out.fields()["fits"].push_back({{"design", design},
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
                                  {"seconds", fit.seconds}});
}

Status FitDesign(Lab& lab, const CalibrateFoldCall& call, const std::string& design,
                 const std::vector<Chosen>& trials, Output& out) {
  std::vector<FoldObservation> observations;
  Provenance provenance{.program_version = ProgramVersion()};
  FitRow row;
  for (const Chosen& trial : trials) {
    Result<FoldData> data = LoadFoldData(lab.TrialFolder(trial.id));
    if (!data.ok()) return data.error();
    for (const std::string& warning : data.value().warnings) out.Warn(warning);
    for (FoldObservation& o : data.value().observations) observations.push_back(std::move(o));
    for (auto& input : data.value().input_sha256) provenance.input_sha256.push_back(std::move(input));
    row.trial_ids.push_back(trial.id);
  }
  FoldFitOptions options;
  options.longest_lag = call.lag;
  options.confidence = call.confidence;
  const Result<FoldFit> fit = FitFold(observations, options, out.ShowProgress("fit " + design));
  if (!fit.ok()) return Error(fit.error()).Within("design " + design);

  const std::optional<TrueFold> truth = TruthOf(lab, trials);
  Show(out, design, fit.value(), truth, call.confidence);
  if (call.dry_run) return Ok{};
  row.scope = fmt::format("design {}", design);
  row.residual_rms_m = fit.value().residual_rms;
  for (std::size_t i = 0; i < fit.value().parameters.size(); ++i) {
    const FittedParameter& p = fit.value().parameters[i];
    row.parameters.push_back({p.name, p.value, p.standard_error, p.identified, TrueValue(truth, i)});
  }
  provenance.parameters_json = nlohmann::json{
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
          "fit the fold model's pull scale, stiffness ratio and exponent to tracked trials, design by design",
      .example = "tendril calibrate fold --lab mylab --kind virtual --design paper",
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
            app.add_flag("--dry-run", call->dry_run, "print the fit, store nothing");
          },
      .run = [call](Output& out) { return RunCalibrateFold(*call, out); },
  };
}

}  // namespace tendril::cli
