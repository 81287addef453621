// tendril track: from a trial's videos to its centerlines.
#include "cli/track_command.h"

#include <cmath>
#include <memory>
#include <string>

#include "capture/track/overlay.h"
#include "capture/track/track.h"
#include "cli/lab_option.h"
#include "cli/program_version.h"
#include "db/trial_query.h"

namespace tendril::cli {
namespace {

struct TrackCall {
  std::string lab;
  std::string trial;
  bool from_detections = false;
  bool overlay = false;
  int threads = 2;
};

nlohmann::ordered_json Number(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

Status RunTrack(const TrackCall& call, Output& out) {
  Result<Lab> lab = OpenLab(call.lab);
  if (!lab.ok()) return lab.error();
  const Result<std::string> id = FindTrial(lab.value(), call.trial);
  if (!id.ok()) return id.error();
  TrackOptions options;
  options.from_detections = call.from_detections;
  options.threads = call.threads;
  const Result<TrackedTrial> tracked = TrackAndStore(lab.value(), id.value(), options, ProgramVersion(),
                                                     out.json() ? Progress() : out.ShowProgress("tracking"));
  if (!tracked.ok()) return tracked.error();
  for (const std::string& warning : tracked.value().warnings) out.Warn(warning);

  auto& fields = out.fields();
  fields["trial"] = id.value();
  fields["frames"] = tracked.value().frames;
  fields["detections"] = tracked.value().detections.size();
  fields["unknown_tags"] = tracked.value().unknown_tags;
  fields["detect_s"] = tracked.value().detect_seconds;
  fields["solve_s"] = tracked.value().solve_seconds;
  out.Print("trial {}: {} frames, {} tags detected in {:.1f} s, solved in {:.1f} s", id.value(),
            tracked.value().frames, tracked.value().detections.size(), tracked.value().detect_seconds,
            tracked.value().solve_seconds);
  out.Print("{:<12} {:>8} {:>16} {:>16} {:>10} {:>10}", "curve", "seen %", "reprojection px",
            "median sigma mm", "tags used", "rejected");
  for (size_t i = 0; i < tracked.value().tentacles.size(); ++i) {
    const TrackedTentacle& t = tracked.value().tentacles[i];
    const std::string& name = tracked.value().curves[i].name;
    fields["tentacles"].push_back({{"name", name},
                                   {"seen_fraction", t.seen_fraction},
                                   {"rms_reprojection_px", Number(t.rms_reprojection_px)},
                                   {"median_sigma_mm", Number(1e3 * t.median_sigma)},
                                   {"views_used", t.views_used},
                                   {"views_rejected", t.views_rejected}});
    out.Print("{:<12} {:>8.1f} {:>16.3f} {:>16.3f} {:>10} {:>10}", name, 100 * t.seen_fraction,
              t.rms_reprojection_px, 1e3 * t.median_sigma, t.views_used, t.views_rejected);
  }
  const std::string curves = (lab.value().TrialFolder(id.value()) / "curves.h5").string();
  fields["curves"] = curves;
  out.Print("curves: {}", curves);
  if (!call.overlay) return Ok{};
  const Result<OverlayFiles> files = WriteOverlay(lab.value().TrialFolder(id.value()), {},
                                                  out.json() ? Progress() : out.ShowProgress("drawing"));
  if (!files.ok()) return files.error();
  fields["overlay_video"] = files.value().video.string();
  fields["overlay_last_frame"] = files.value().last_frame.string();
  out.Print("overlay: {}, {}", files.value().video.string(), files.value().last_frame.string());
  return Ok{};
}

}  // namespace

Command MakeTrackCommand() {
  auto call = std::make_shared<TrackCall>();
  return {
      .path = "track",
      .help = "turn a trial's videos into centerlines (detections.csv, curves.h5)",
      .example = "tendril track bending-50mm-1 --lab mylab --overlay",
      .declare =
          [call](CLI::App& app) {
            app.add_option("trial", call->trial, "trial: its label, id, or a unique beginning of its id")
                ->required();
            app.add_flag("--from-detections", call->from_detections,
                         "start from the trial's detections.csv; the videos are not read");
            app.add_flag("--overlay", call->overlay,
                         "also draw tags and centerlines over the pictures (overlay.mp4, overlay.png)");
            app.add_option("--threads", call->threads, "pictures worked on at once, count")
                ->check(CLI::Range(1, 64))
                ->capture_default_str();
            AddLabOption(app, call->lab);
          },
      .run = [call](Output& out) { return RunTrack(*call, out); },
  };
}

}  // namespace tendril::cli
