// tendril track: from a trial's videos to its centerlines.
#include "cli/track_command.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

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
  bool no_fold_law = false;
  int smooth_lag = 0;
  std::string level = "standard";
  std::string load = "auto";
  int threads = 2;
};

void PrintCameras(const TrackedTrial& tracked, const std::string& level, Output& out) {
  if (tracked.cameras.empty()) return;
  auto& fields = out.fields();
  fields["level"] = level;
  out.Print("{:<12} {:>8} {:>8} {:>10} {:>12}  {}", "camera", "tags", "decoded", "ms a frame", "corners px",
            "sightings rejected");
  for (size_t c = 0; c < tracked.cameras.size(); ++c) {
    const CameraTags& camera = tracked.cameras[c];
    const double ms = 1e3 * camera.seconds / std::max(1.0, static_cast<double>(camera.counts.frames));
    auto rejected = nlohmann::ordered_json::object();
    for (const auto& [cause, count] : RejectedByCause(camera.counts)) rejected[cause] = count;
    fields["cameras"].push_back({{"camera", c},
                                 {"frames", camera.counts.frames},
                                 {"frames_decoded", camera.counts.decodes},
                                 {"tags", camera.tags},
                                 {"tags_followed", camera.counts.fitted},
                                 {"tags_found_by_decoding", camera.counts.found},
                                 {"ms_per_frame", ms},
                                 {"median_sigma_px", NumberOrNull(camera.median_sigma_px)},
                                 {"rejected", rejected}});
    out.Print("{:<12} {:>8} {:>8} {:>10.1f} {:>12}  {}", fmt::format("cam{}", c), camera.tags,
              fmt::format("{}/{}", camera.counts.decodes, camera.counts.frames), ms,
              std::isfinite(camera.median_sigma_px) ? fmt::format("{:.3f}", camera.median_sigma_px) : "-",
              RejectedInWords(camera.counts));
  }
}

Status RunTrack(const TrackCall& call, Output& out) {
  Result<Lab> lab = OpenLab(call.lab);
  if (!lab.ok()) return lab.error();
  const Result<std::string> id = FindTrial(lab.value(), call.trial);
  if (!id.ok()) return id.error();
  TrackOptions options;
  options.from_detections = call.from_detections;
  options.threads = call.threads;
  options.fold_law = !call.no_fold_law;
  options.smooth_lag = call.smooth_lag;
  const Result<std::optional<TagTrackLevel>> level = TagLevelOf(call.level);
  if (!level.ok()) return Error(level.error()).Within("--level");
  options.tag_level = level.value();
  if (call.load != "auto") options.touching = call.load == "contact";
  const Result<TrackedTrial> tracked = TrackAndStore(lab.value(), id.value(), options, ProgramVersion(),
                                                     out.json() ? Progress() : out.ShowProgress("tracking"));
  if (!tracked.ok()) return tracked.error();
  for (const std::string& warning : tracked.value().warnings) out.Warn(warning);

  auto& fields = out.fields();
  fields["trial"] = id.value();
  fields["load"] = tracked.value().touching ? "contact" : "free";
  fields["fold_law"] = options.fold_law;
  fields["smooth_lag"] = options.smooth_lag;
  fields["frames"] = tracked.value().frames;
  fields["detections"] = tracked.value().detections.size();
  fields["unknown_tags"] = tracked.value().unknown_tags;
  fields["detect_s"] = tracked.value().detect_seconds;
  fields["solve_s"] = tracked.value().solve_seconds;
  out.Print("trial {}: {} frames, {} tags detected in {:.1f} s, solved in {:.1f} s", id.value(),
            tracked.value().frames, tracked.value().detections.size(), tracked.value().detect_seconds,
            tracked.value().solve_seconds);
  out.Print("tentacles {} (--load)", tracked.value().touching ? "may touch things" : "hang free");
  if (!options.fold_law)
    out.Print("without the fold law (--no-fold-law): the pull says nothing of the folds");
  if (options.smooth_lag > 0)
    out.Print("creases out of sight are recalled from {} frames before and after (--smooth-lag)",
              options.smooth_lag);
  PrintCameras(tracked.value(), call.level, out);
  out.Print("{:<12} {:>8} {:>14} {:>16} {:>16} {:>10} {:>10}", "curve", "seen %", "angles told %",
            "reprojection px", "median sigma mm", "tags used", "rejected");
  for (size_t i = 0; i < tracked.value().tentacles.size(); ++i) {
    const TrackedTentacle& t = tracked.value().tentacles[i];
    const std::string& name = tracked.value().curves[i].name;
    fields["tentacles"].push_back({{"name", name},
                                   {"seen_fraction", t.seen_fraction},
                                   {"angles_told_fraction", t.told_fraction},
                                   {"rms_reprojection_px", NumberOrNull(t.rms_reprojection_px)},
                                   {"median_sigma_mm", NumberOrNull(1e3 * t.median_sigma)},
                                   {"views_used", t.views_used},
                                   {"views_rejected", t.views_rejected}});
    out.Print("{:<12} {:>8.1f} {:>14.1f} {:>16.3f} {:>16.3f} {:>10} {:>10}", name, 100 * t.seen_fraction,
              100 * t.told_fraction, t.rms_reprojection_px, 1e3 * t.median_sigma, t.views_used,
              t.views_rejected);
  }
  out.Print("angles told: creases of whose fold the pictures tell as much as the model does, or more");
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
            app.add_flag(
                "--no-fold-law", call->no_fold_law,
                "expect no fold angle from the pull, so that curves which calibrate the fold law owe it "
                "nothing; what was not seen is less sure");
            app.add_option("--smooth-lag", call->smooth_lag,
                           "let creases out of sight be where they were seen in so many frames before or "
                           "after, count; 0: each frame by itself")
                ->check(CLI::Range(0, 1000))
                ->capture_default_str();
            app.add_flag("--overlay", call->overlay,
                         "also draw tags and centerlines over the pictures (overlay.mp4, overlay.png)");
            app.add_option("--level", call->level,
                           "how tags are found: decode (each picture by itself), or followed from picture to "
                           "picture: preview, standard, best (name)")
                ->check(CLI::IsMember(TagLevelNames()))
                ->capture_default_str();
            app.add_option(
                   "--load", call->load,
                   "whether tentacles touch things (contact) or hang free; auto: only those of virtual "
                   "trials hang free")
                ->check(CLI::IsMember({"auto", "free", "contact"}))
                ->capture_default_str();
            app.add_option("--threads", call->threads, "pictures worked on at once, count")
                ->check(CLI::Range(1, 64))
                ->capture_default_str();
            AddLabOption(app, call->lab);
          },
      .run = [call](Output& out) { return RunTrack(*call, out); },
  };
}

}  // namespace tendril::cli
