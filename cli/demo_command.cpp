// tendril demo: the main job from end to end on the virtual rig, in a lab of its own.
#include "cli/demo_command.h"

#include <array>
#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "analysis/statistics/intervals.h"
#include "calibrate/fold/fold_data.h"
#include "calibrate/fold/fold_fit.h"
#include "capture/track/overlay.h"
#include "cli/demo_study.h"
#include "cli/lab_plots.h"
#include "cli/program_version.h"
#include "db/files/curve_files.h"
#include "db/trial_query.h"
#include "db/trial_store.h"

namespace tendril::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct FitWithTruth {
  FoldFit fit;
  std::array<double, kFoldParameters> truth{};
};

// One fit to all trials of both designs: they share the material, so they share the parameters.
Result<FitWithTruth> FitAll(Lab& lab, const DemoPlan& plan, const std::vector<DemoTrialResult>& results,
                            const Progress& progress) {
  std::vector<FoldObservation> observations;
  Provenance made{.program_version = ProgramVersion()};
  FitRow row{.scope = "all trials of the demo"};
  for (const DemoTrialResult& trial : results) {
    Result<FoldData> data = LoadFoldData(lab.TrialFolder(trial.id));
    if (!data.ok()) return data.error();
    for (FoldObservation& o : data.value().observations) observations.push_back(std::move(o));
    for (auto& input : data.value().input_sha256) made.input_sha256.push_back(std::move(input));
    row.trial_ids.push_back(trial.id);
  }
  Result<FoldFit> fit = FitFold(observations, {}, progress);
  if (!fit.ok()) return fit.error();
  FitWithTruth all{
      .fit = std::move(fit).value(),
      .truth = {plan.truth.pull_scale, plan.truth.stiffness_ratio, plan.truth.stiffness_exponent}};
  row.residual_rms_m = all.fit.residual_rms;
  for (std::size_t i = 0; i < all.fit.parameters.size(); ++i) {
    const FittedParameter& p = all.fit.parameters[i];
    row.parameters.push_back({p.name, p.value, p.standard_error, p.identified, all.truth[i]});
  }
  if (Status s = StoreFit(lab, row, made); !s.ok()) return s.error();
  return all;
}

void ReportFit(const FitWithTruth& fit, Output& out) {
  out.Print("");
  out.Print("Fold model, fitted to {} curves of {} trials (residual {:.2f} mm):", fit.fit.frames_used,
            fit.fit.trials, 1e3 * fit.fit.residual_rms);
  out.Print("  {:<20} {:>9} {:>9} {:>9}   {:>8}", "parameter", "hidden", "fitted", "SE", "off by");
  for (std::size_t i = 0; i < fit.fit.parameters.size(); ++i) {
    const FittedParameter& p = fit.fit.parameters[i];
    out.fields()["fit"].push_back({{"name", p.name},
                                   {"true", fit.truth[i]},
                                   {"value", p.value},
                                   {"standard_error", NumberOrNull(p.standard_error)},
                                   {"identified", p.identified}});
    out.Print("  {:<20} {:>9.4f} {:>9.4f} {:>9.4f}   {:>+5.1f} SE", p.name, fit.truth[i], p.value,
              p.standard_error, (p.value - fit.truth[i]) / p.standard_error);
  }
  for (const std::string& warning : fit.fit.warnings) out.Warn(warning);
}

void ReportRates(const std::vector<RateGroup>& groups, Output& out) {
  out.Print("");
  out.Print(
      "Grasp success of these virtual trials (success: mean |object link| of the true final shapes >= {}):",
      kGraspedLink);
  out.Print("  {:<10} {:>12} {:>4} {:>4} {:>6}   {:<16} {}", "design", "distance mm", "k", "n", "rate",
            "95 % Wilson", "95 % Clopper-Pearson");
  for (const RateGroup& group : groups) {
    const Interval wilson = WilsonInterval(group.grasped, group.trials);
    const Interval exact = ClopperPearsonInterval(group.grasped, group.trials);
    const double distance = std::stod(group.keys[1].second);
    const double rate = static_cast<double>(group.grasped) / static_cast<double>(group.trials);
    out.fields()["groups"].push_back({{"design", group.keys[0].second},
                                      {"distance", distance},
                                      {"n", group.trials},
                                      {"k", group.grasped},
                                      {"rate", rate},
                                      {"wilson95", {wilson.low, wilson.high}},
                                      {"clopper_pearson95", {exact.low, exact.high}}});
    out.Print("  {:<10} {:>12.0f} {:>4} {:>4} {:>6.2f}   {:.3f} .. {:.3f}   {:.3f} .. {:.3f}",
              group.keys[0].second, 1e3 * distance, group.grasped, group.trials, rate, wilson.low,
              wilson.high, exact.low, exact.high);
  }
}

// The trial shown in pictures: the first of the last design.
Status DrawPictures(Lab& lab, const DemoPlan& plan, const std::vector<DemoTrialResult>& results,
                    const std::vector<RateGroup>& groups, Output& out) {
  std::size_t shown = 0;
  while (plan.trials[shown].design != static_cast<int>(plan.designs.size()) - 1) ++shown;
  const fs::path trial = lab.TrialFolder(results[shown].id);
  const std::string label = plan.trials[shown].spec.label;
  const fs::path folder = lab.folder() / "plots";
  std::error_code failed;
  fs::create_directories(folder, failed);
  const auto made = [&](const std::string& name, const fs::path& file) {
    out.fields()["outputs"][name] = file.string();
  };
  out.fields()["outputs"]["lab"] = lab.folder().string();
  out.fields()["outputs"]["database"] = (lab.folder() / "lab.db").string();

  if (Status s = PlotRates(groups, "carrier to object (mm)", 1e3, folder / "rates.svg"); !s.ok()) return s;
  made("rates", folder / "rates.svg");
  const Result<std::vector<CurveSeries>> curves = ReadCurves(trial / "curves.h5");
  if (!curves.ok()) return curves.error();
  const Result<std::vector<CurveSeries>> truth = ReadCurves(trial / "truth.h5");
  if (!truth.ok()) return truth.error();
  if (Status s = PlotCenterlines(curves.value(), &truth.value(), -1, label, folder / "centerlines.svg");
      !s.ok()) {
    return s;
  }
  made("centerlines", folder / "centerlines.svg");
  if (Status s = PlotLinks(trial, label, folder / "links.svg"); !s.ok()) return s;
  made("links", folder / "links.svg");
  const Result<OverlayFiles> overlay = WriteOverlay(trial);
  if (!overlay.ok()) return overlay.error();
  made("overlay_video", overlay.value().video);
  made("overlay_last_frame", overlay.value().last_frame);
  return Ok{};
}

Status RunDemo(const DemoOptions& options, Output& out) {
  const auto start = std::chrono::steady_clock::now();
  if (Status s = PrepareDemoFolder(options.folder); !s.ok()) return s;
  const Result<DemoPlan> plan = PlanDemo(options);
  if (!plan.ok()) return plan.error();
  out.Print("{} virtual trials ({} designs x 3 distances x {} repeats), {} frames of two cameras each, in {}",
            plan.value().trials.size(), plan.value().designs.size(), options.repeats, options.frames,
            options.folder.string());

  const Result<std::vector<DemoTrialResult>> results =
      RunDemoTrials(options.folder, plan.value(), options, out.ShowProgress("record, track, score"));
  if (!results.ok()) return results.error();
  Result<Lab> lab = Lab::Open(options.folder);
  if (!lab.ok()) return lab.error();
  const Result<FitWithTruth> fit =
      FitAll(lab.value(), plan.value(), results.value(), out.ShowProgress("fit the fold model"));
  if (!fit.ok()) return fit.error();
  const Result<std::vector<RateGroup>> groups =
      CountGrasps(lab.value(), {.by = {"design", "distance"}, .where = {}, .kind = TrialKind::kVirtual});
  if (!groups.ok()) return groups.error();

  CenterlineError error;
  for (const DemoTrialResult& result : results.value()) error.Add(result.error);
  const double length = plan.value().designs.front().design.length;
  out.fields()["seconds"] = 0.0;  // first in the object; filled in at the end
  out.fields()["trials"] = results.value().size();
  out.fields()["kind"] = "virtual";
  out.fields()["centerline_rms_mm"] = 1e3 * error.Rms();
  out.fields()["centerline_rms_percent_of_length"] = 100 * error.Rms() / length;
  out.fields()["centerline_rms_all_nodes_mm"] = 1e3 * error.AllRms();
  out.fields()["seen_fraction"] = static_cast<double>(error.nodes) / static_cast<double>(error.all_nodes);
  out.Print("");
  out.Print("Centerlines against the rig's hidden truth:");
  out.Print("  nodes whose facet was seen ({:.0f} %)   {:.2f} mm RMS, {:.3f} % of the length",
            100 * static_cast<double>(error.nodes) / static_cast<double>(error.all_nodes), 1e3 * error.Rms(),
            100 * error.Rms() / length);
  out.Print("  all nodes, bridged ones included      {:.2f} mm RMS", 1e3 * error.AllRms());
  ReportFit(fit.value(), out);
  ReportRates(groups.value(), out);
  if (Status s = DrawPictures(lab.value(), plan.value(), results.value(), groups.value(), out); !s.ok())
    return s;

  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  out.fields()["seconds"] = seconds;
  out.Print("");
  out.Print("All trials here are virtual (rendered, without contact); the database says so in every row.");
  out.Print("Done in {:.0f} s. Made:", seconds);
  for (const auto& [name, path] : out.fields()["outputs"].items()) {
    out.Print("  {:<20} {}", name, path.get<std::string>());
  }
  out.Print("Ask further:  tendril stats --lab {} --by design,distance --kind virtual",
            options.folder.string());
  return Ok{};
}

}  // namespace

Command MakeDemoCommand() {
  auto options = std::make_shared<DemoOptions>();
  auto folder = std::make_shared<std::string>(options->folder.string());
  return {
      .path = "demo",
      .help = "the main job from end to end on the virtual rig, in a lab of its own",
      .example = "tendril demo --lab demo-lab",
      .declare =
          [options, folder](CLI::App& app) {
            app.add_option("--lab", *folder, "folder to make; one that an earlier demo made is replaced")
                ->capture_default_str();
            app.add_option("--repeats", options->repeats, "trials per design and distance, count")
                ->check(CLI::Range(1, 1000))
                ->capture_default_str();
            app.add_option("--frames", options->frames, "pictures per trial and camera, count")
                ->check(CLI::Range(2, 1000))
                ->capture_default_str();
            app.add_option("--seed", options->seed, "of everything that is drawn, whole number")
                ->check(CLI::NonNegativeNumber)
                ->capture_default_str();
            app.add_option("--threads", options->threads, "trials worked on at once, count")
                ->check(CLI::Range(1, 64))
                ->capture_default_str();
          },
      .run =
          [options, folder](Output& out) {
            options->folder = *folder;
            return RunDemo(*options, out);
          },
  };
}

}  // namespace tendril::cli
