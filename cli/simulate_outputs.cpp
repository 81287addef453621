#include "cli/simulate_outputs.h"

#include "cli/lab_option.h"
#include "cli/program_version.h"
#include "cli/scene_film.h"
#include "cli/scene_video.h"
#include "cli/simulate_lab.h"
#include "cli/simulate_report.h"
#include "db/files/curve_files.h"

namespace tendril::cli {
namespace {

Status KeepTrial(const SimulateCall& call, const FinishedRun& finished, const LinkSeries& links,
                 Output& out) {
  Result<Lab> lab = OpenLab(call.lab);
  if (!lab.ok()) return lab.error();
  const Result<std::optional<std::string>> there = TrialOfRun(lab.value(), finished.run_key);
  if (!there.ok()) return there.error();
  out.fields()["already_there"] = there.value().has_value();
  if (there.value()) {
    out.fields()["trial"] = *there.value();
    out.Print("trial {} of kind simulated, in the lab already: this run is not stored again", *there.value());
    return Ok{};
  }
  const Result<std::string> label = StoreSimulatedTrial(
      lab.value(), {.call = &call, .finished = &finished, .links = &links, .run_key = finished.run_key});
  if (!label.ok()) return label.error();
  out.fields()["trial"] = label.value();
  out.Print("trial {} of kind simulated, in the lab{}", label.value(),
            finished.run->doubts.empty() ? "" : "; rates leave it out unless asked (--include-untrusted)");
  return Ok{};
}

}  // namespace

Status WriteOutputs(const SimulateCall& call, const FinishedRun& finished, Output& out) {
  const Scene& scene = *finished.scene;
  const Simulated& done = *finished.run;
  auto& fields = out.fields();
  if (!call.out.empty()) {
    if (Status s = WriteCurves(call.out, done.curves, ProgramVersion() + " simulate", done.objects);
        !s.ok()) {
      return s;
    }
    fields["out"] = call.out;
    out.Print("{}: {} frames of {} rods", call.out, done.curves[0].time.size(), done.curves.size());
  }
  const std::optional<double> until =
      finished.holding ? std::optional(finished.holding->begins) : std::nullopt;
  Result<LinkSeries> links = TellLink(scene, done, until, out);
  if (!links.ok()) return links.error();
  if (call.store) {
    if (Status s = KeepTrial(call, finished, links.value(), out); !s.ok()) return s;
  }
  if (call.video.empty() && call.picture.empty()) return Ok{};
  const SceneFilm film = FilmOf(scene, done, links.value());
  if (!call.picture.empty()) {
    if (Status s = WriteScenePicture(film, call.picture); !s.ok()) return s;
    fields["picture"] = call.picture;
    out.Print("{}: the last frame", call.picture);
  }
  if (!call.video.empty()) {
    if (Status s = WriteSceneVideo(film, call.video, out.ShowProgress(call.video)); !s.ok()) return s;
    fields["video"] = call.video;
    out.Print("{}: {} frames", call.video, done.curves[0].time.size());
  }
  return Ok{};
}

}  // namespace tendril::cli
