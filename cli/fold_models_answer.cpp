#include "cli/fold_models_answer.h"

#include <algorithm>
#include <cmath>

#include "calibrate/fold/fold_compare.h"
#include "calibrate/fold/fold_profile.h"

namespace tendril::cli {
namespace {

std::string ParametersOf(const FoldFit& fit) {
  std::string text;
  for (const FittedParameter& p : fit.parameters) {
    if (!text.empty()) text += "  ";
    text += fmt::format("{} {:.4g}", p.name, p.value);
    text += p.identified ? fmt::format(" ({:.2g})", p.standard_error) : " (not identified)";
  }
  return text;
}

nlohmann::ordered_json JsonOf(const ComparedModel& one) {
  nlohmann::ordered_json json = {{"model", NameOf(one.model)},
                                 {"held_out_mm", NumberOrNull(1e3 * one.held_out)},
                                 {"behind_best", NumberOrNull(one.behind)},
                                 {"behind_best_standard_error", NumberOrNull(one.behind_error)},
                                 {"aic_difference", NumberOrNull(one.aic_difference)}};
  if (!one.fit) {
    json["why_not"] = one.why_not;
    return json;
  }
  json["residual_rms_mm"] = 1e3 * one.fit->residual_rms;
  json["converged"] = one.fit->converged;
  json["parameters"] = nlohmann::ordered_json::array();
  for (const FittedParameter& p : one.fit->parameters) {
    json["parameters"].push_back({{"name", p.name},
                                  {"value", p.value},
                                  {"standard_error", NumberOrNull(p.standard_error)},
                                  {"identified", p.identified},
                                  {"at_bound", p.at_bound}});
  }
  return json;
}

}  // namespace

Result<FoldFit> CompareModels(std::span<const FoldObservation> observations, const FoldFitOptions& options,
                              const std::string& design, const std::optional<TrueFold>& truth, Output& out) {
  FoldComparisonOptions with;
  with.fit = options;
  const Result<FoldComparison> compared =
      CompareFoldModels(observations, with, out.ShowProgress("compare models of " + design));
  if (!compared.ok()) return Error(compared.error()).Within("design " + design);
  const FoldComparison& c = compared.value();

  out.Print("design {}: {} models on {} trials, {:.0f} s", design, c.models.size(), c.trials, c.seconds);
  out.Print("  {:28} {:>12} {:>12} {:>18} {:>9}   {}", "model", "residual mm", "held-out mm",
            "behind the best", "dAIC", "parameters (SE)");
  nlohmann::ordered_json models = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < c.models.size(); ++i) {
    const ComparedModel& one = c.models[i];
    models.push_back(JsonOf(one));
    const std::string mark = static_cast<int>(i) == c.chosen ? "*" : " ";
    if (!one.fit) {
      out.Print(" {}{:28} {}", mark, NameOf(one.model), one.why_not);
      continue;
    }
    const std::string behind = std::isfinite(one.behind) ? fmt::format("{:.2f} +- {:.2f} %", 100 * one.behind,
                                                                       100 * one.behind_error)
                                                         : "-";
    const std::string held_out =
        std::isfinite(one.held_out) ? fmt::format("{:.4f}", 1e3 * one.held_out) : "-";
    out.Print(" {}{:28} {:12.3f} {:>12} {:>18} {:9.1f}   {}{}", mark, NameOf(one.model),
              1e3 * one.fit->residual_rms, held_out, behind, one.aic_difference, ParametersOf(*one.fit),
              one.fit->converged ? "" : "   (did not converge)");
  }
  out.Print(
      "  residual: of the holes, RMS, after the fitted shape is laid on each curve as a whole; it holds sag "
      "and bent facets, too");
  out.Print(
      "  held-out: of distances between near holes, RMS under a robust loss, of trials that the parameters "
      "were not fitted to (one left out at a time); it decides");
  out.Print(
      "  dAIC takes a loss of {:.1f} in the {} rows for one, as much as those of one trial err together",
      c.inflation, c.rows);
  for (const std::string& line : c.verdict) out.Print("  {}", line);
  nlohmann::ordered_json json = {{"design", design},
                                 {"trials", c.trials},
                                 {"rows", c.rows},
                                 {"rows_per_independent_row", c.inflation},
                                 {"models", std::move(models)},
                                 {"best", NameOf(c.models[static_cast<std::size_t>(c.best)].model)},
                                 {"chosen", NameOf(c.models[static_cast<std::size_t>(c.chosen)].model)},
                                 {"verdict", c.verdict},
                                 {"seconds", c.seconds}};
  if (truth) {
    json["true"] = NameOf(FoldModel{truth->law, truth->rest_angle > 0, truth->friction > 0});
    out.Print("  true: {}", json["true"].get<std::string>());
  }
  out.fields()["comparisons"].push_back(std::move(json));
  return *c.models[static_cast<std::size_t>(c.chosen)].fit;
}

Status ShowProfile(std::span<const FoldObservation> observations, const FoldFitOptions& options,
                   const std::string& parameter, const std::string& design, Output& out) {
  const Result<FoldProfile> profiled =
      ProfileFold(observations, options, parameter, out.ShowProgress("profile of " + parameter));
  if (!profiled.ok()) return Error(profiled.error()).Within("design " + design);
  const FoldProfile& p = profiled.value();
  const auto end = [](double value) {
    return std::isfinite(value) ? fmt::format("{:.5g}", value) : "beyond";
  };
  out.Print("design {}: profile of {}, {:.3g} % interval {} .. {}{}", design, parameter,
            100 * options.confidence, end(p.interval.low), end(p.interval.high),
            p.from_bound ? " (from its least value)" : "");
  // The bar is the root of the deviance: straight where the interval of the table can be trusted.
  constexpr int kWidth = 40;
  const int mark = kWidth / 2;
  for (std::size_t i = 0; i < p.value.size(); ++i) {
    const double root = std::sqrt(p.deviance[i] / p.threshold);
    std::string bar(static_cast<std::size_t>(std::clamp(std::lround(root * mark), 0L, long{kWidth})), '#');
    bar.resize(kWidth, ' ');
    if (bar[mark] == ' ') bar[mark] = '|';
    out.Print("  {:>10.5g} {} {:7.2f} SE", p.value[i], bar, std::sqrt(p.deviance[i]));
  }
  nlohmann::ordered_json json = {{"design", design},
                                 {"model", NameOf(options.model)},
                                 {"parameter", parameter},
                                 {"value", p.value},
                                 {"deviance", p.deviance},
                                 {"threshold", p.threshold},
                                 {"interval", {NumberOrNull(p.interval.low), NumberOrNull(p.interval.high)}},
                                 {"from_bound", p.from_bound}};
  out.fields()["profiles"].push_back(std::move(json));
  return Ok{};
}

}  // namespace tendril::cli
