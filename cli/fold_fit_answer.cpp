#include "cli/fold_fit_answer.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "cli/program_version.h"
#include "db/files/design_toml.h"
#include "db/files/safe_file.h"
#include "db/files/toml_write.h"
#include "db/trial_store.h"

namespace tendril::cli {
namespace {

nlohmann::ordered_json JsonOf(const PullHint& hint, const ViewPlaces& places) {
  nlohmann::ordered_json json = {{"parameter", hint.parameter}, {"best_pull", hint.best_pull},
                                 {"pull", hint.pull},           {"error_ratio", hint.error_ratio},
                                 {"sentence", hint.sentence},   {"view", nullptr}};
  if (!hint.view) return json;
  const ViewHint& view = *hint.view;
  json["view"] = {{"picture_share", view.picture_share},
                  {"picture_share_from", view.known_from == PictureErrors::kRepeats      ? "repeats"
                                         : view.known_from == PictureErrors::kCovariance ? "covariance"
                                                                                         : "sigma"},
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

}  // namespace

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

void ShowFit(const std::string& design, const FoldFit& fit, const std::optional<TrueFold>& truth,
             double confidence, const ViewPlaces& places, Output& out) {
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

}  // namespace tendril::cli
