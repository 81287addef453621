// tendril trials import: a real trial that was recorded elsewhere, without video, taken into a lab; and where
// its tags form a chain seen side-on, the planar centerline over time.
#include "cli/import_command.h"

#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>

#include "capture/rig/rig.h"
#include "capture/track/planar_chain.h"
#include "cli/lab_option.h"
#include "cli/program_version.h"
#include "db/files/curve_files.h"
#include "db/files/design_toml.h"
#include "db/files/recording_logs.h"
#include "db/files/safe_file.h"
#include "db/trial_id.h"
#include "db/trial_store.h"

namespace tendril::cli {
namespace {

namespace fs = std::filesystem;

constexpr double kDegree = M_PI / 180;

struct ImportCall {
  std::string lab;
  std::string label;
  std::string detections;
  std::string frames;
  std::string servo;
  std::string source;
  std::string rig;
  std::string design;
  std::string notes;
  std::vector<int> chain;
  double scale_mm_per_px = 0;
  double spacing_mm = 0;
  std::vector<double> origin_px;
  double sigma_px = 0.5;
};

struct Recording {
  std::vector<DetectionRow> detections;
  std::vector<FrameRow> frames;
  std::vector<ServoRow> servo;
  std::optional<Rig> rig;
  std::string rig_text;
};

Error Bad(std::string message) { return {ErrorKind::kBadInput, std::move(message)}; }

Result<Recording> ReadRecording(const ImportCall& call) {
  Recording all;
  auto detections = ReadDetections(call.detections);
  if (!detections.ok()) return detections.error();
  all.detections = std::move(detections).value();
  auto frames = ReadFrameLog(call.frames);
  if (!frames.ok()) return frames.error();
  all.frames = std::move(frames).value();
  if (all.frames.empty())
    return Bad(call.frames + ": no frames; expected one row per picture that was taken");
  if (!call.servo.empty()) {
    auto servo = ReadServoLog(call.servo);
    if (!servo.ok()) return servo.error();
    all.servo = std::move(servo).value();
  }
  if (!call.rig.empty()) {
    const auto text = ReadText(call.rig);
    if (!text.ok()) return text.error();
    auto rig = ParseRig(text.value(), call.rig);
    if (!rig.ok()) return rig.error();
    all.rig = std::move(rig).value();
    all.rig_text = text.value();
  }
  std::set<int> cameras;
  for (const DetectionRow& row : all.detections) cameras.insert(row.camera);
  if (!call.chain.empty() && cameras.size() > 1) {
    return Bad(fmt::format("{}: detections of {} cameras; a planar chain takes those of one", call.detections,
                           cameras.size()));
  }
  return all;
}

// Pixel to the plane y = 0 of the lab, through the rig's camera or by a stated scale. Fills in the scale
// used.
Result<PlanarChainOptions> PlaneOf(const ImportCall& call, const Recording& recording,
                                   double* scale_m_per_px) {
  PlanarChainOptions options{.chain = call.chain, .sigma_px = call.sigma_px, .plane_of_pixel = {}};
  *scale_m_per_px = NAN;
  const std::pair<const char*, double> not_negative[] = {{"--scale-mm-per-px", call.scale_mm_per_px},
                                                         {"--spacing-mm", call.spacing_mm},
                                                         {"--sigma-px", call.sigma_px}};
  for (const auto& [name, value] : not_negative) {
    if (!(value >= 0) || !std::isfinite(value)) {
      return Bad(fmt::format("{} is {}; expected more than 0", name, value));
    }
  }
  const int ways =
      (recording.rig ? 1 : 0) + (call.scale_mm_per_px > 0 ? 1 : 0) + (call.spacing_mm > 0 ? 1 : 0);
  if (ways != 1) {
    return Bad(
        "a chain needs exactly one of --rig, --scale-mm-per-px and --spacing-mm to turn pixels into metres");
  }
  if (recording.rig) {
    const Camera camera = recording.rig->cameras[0];
    options.plane_of_pixel = [camera](const Eigen::Vector2d& pixel) -> std::optional<Eigen::Vector2d> {
      const auto ray = RayOfPixel(camera, pixel);
      if (!ray) return std::nullopt;
      const Eigen::Isometry3d lab_from_camera = camera.camera_from_lab.inverse();
      const Eigen::Vector3d from = lab_from_camera.translation();
      const Eigen::Vector3d along = lab_from_camera.linear() * *ray;
      const double distance = -from.y() / along.y();
      if (!(distance > 0) || !std::isfinite(distance)) return std::nullopt;
      const Eigen::Vector3d at = from + distance * along;
      return Eigen::Vector2d(at.x(), at.z());
    };
    return options;
  }
  double scale = 1e-3 * call.scale_mm_per_px;
  if (call.spacing_mm > 0) {
    const double spacing_px = MedianSpacingPx(recording.detections, call.chain);
    if (!(spacing_px > 0)) {
      return Bad(call.detections +
                 ": no frame shows two neighbours of the chain; expected other ids in --chain");
    }
    scale = 1e-3 * call.spacing_mm / spacing_px;
  }
  Eigen::Vector2d origin;
  if (call.origin_px.size() == 2) {
    origin = {call.origin_px[0], call.origin_px[1]};
  } else {
    bool found = false;
    for (const DetectionRow& row : recording.detections) {
      if (found || row.tag != call.chain.front()) continue;
      origin = TagCenter(row.corners_px);
      found = true;
    }
    if (!found)
      return Bad(
          fmt::format("{}: tag {}, the chain's first, was never seen", call.detections, call.chain.front()));
  }
  *scale_m_per_px = scale;
  options.plane_of_pixel = [scale, origin](const Eigen::Vector2d& pixel) -> std::optional<Eigen::Vector2d> {
    return Eigen::Vector2d(scale * (pixel.x() - origin.x()), -scale * (pixel.y() - origin.y()));
  };
  return options;
}

std::string MetricsCsv(const PlanarChain& chain) {
  std::string csv = "frame,time_s,tip_angle_deg,mean_curvature_per_m,nodes_seen\n";
  const auto cell = [](double v) { return std::isnan(v) ? std::string() : fmt::format("{:.9g}", v); };
  for (Eigen::Index f = 0; f < chain.curve.time.size(); ++f) {
    const auto seen = (!chain.curve.sigma[static_cast<size_t>(f)].array().isNaN()).count();
    csv += fmt::format("{},{:.9g},{},{},{}\n", f, chain.curve.time[f], cell(chain.tip_angle[f] / kDegree),
                       cell(chain.mean_curvature[f]), seen);
  }
  return csv;
}

std::pair<double, double> Range(const Eigen::VectorXd& values) {
  double low = NAN;
  double high = NAN;
  for (const double v : values) {
    if (std::isnan(v)) continue;
    low = std::isnan(low) ? v : std::min(low, v);
    high = std::isnan(high) ? v : std::max(high, v);
  }
  return {low, high};
}

Status AddFile(Lab& lab, const std::string& id, const std::string& role, const std::string& name,
               std::optional<std::int64_t> frames, Provenance* inputs) {
  const auto hash = Sha256OfFile(lab.TrialFolder(id) / name);
  if (!hash.ok()) return hash.error();
  if (inputs != nullptr) inputs->input_sha256.emplace_back(role, hash.value());
  return AddRecordingFile(lab, id, role, name, hash.value(), frames);
}

// Everything that is written once the trial's row exists.
Status Fill(Lab& lab, const std::string& id, const ImportCall& call, const Recording& recording,
            const std::optional<PlanarChain>& chain, Provenance provenance) {
  const fs::path folder = lab.TrialFolder(id);
  const auto copy = [&](const std::string& from, const std::string& to) -> Status {
    const auto text = ReadText(from);
    if (!text.ok()) return text.error();
    return WriteText(folder / to, text.value());
  };
  const auto frames = static_cast<std::int64_t>(recording.frames.size());
  if (Status s = copy(call.detections, "detections.csv"); !s.ok()) return s;
  if (Status s = AddFile(lab, id, "detections", "detections.csv", frames, &provenance); !s.ok()) return s;
  if (Status s = copy(call.frames, "cam0.csv"); !s.ok()) return s;
  if (Status s = AddFile(lab, id, "frames", "cam0.csv", frames, &provenance); !s.ok()) return s;
  if (!call.servo.empty()) {
    if (Status s = copy(call.servo, "servo.csv"); !s.ok()) return s;
    if (Status s = AddFile(lab, id, "servo", "servo.csv", std::nullopt, nullptr); !s.ok()) return s;
  }
  if (!call.source.empty()) {
    const std::string name = "source" + fs::path(call.source).extension().string();
    if (Status s = copy(call.source, name); !s.ok()) return s;
    if (Status s = AddFile(lab, id, "source", name, std::nullopt, nullptr); !s.ok()) return s;
  }
  if (!chain) return Ok{};
  if (Status s =
          WriteCurves(folder / "curves.h5", std::span(&chain->curve, 1), ProgramVersion() + " trials import");
      !s.ok()) {
    return s;
  }
  if (Status s = AddFile(lab, id, "curves", "curves.h5", frames, nullptr); !s.ok()) return s;
  if (Status s = WriteText(folder / "metrics.csv", MetricsCsv(*chain)); !s.ok()) return s;
  if (Status s = AddFile(lab, id, "metrics", "metrics.csv", frames, nullptr); !s.ok()) return s;
  return StoreTrack(lab, id,
                    {.frames = static_cast<int>(frames),
                     .tentacles = 1,
                     .seen_fraction = chain->seen_fraction,
                     .rms_sigma_m = chain->rms_sigma},
                    provenance);
}

Status RunImport(const ImportCall& call, Output& out) {
  const auto recording = ReadRecording(call);
  if (!recording.ok()) return recording.error();
  const std::vector<FrameRow>& frames = recording.value().frames;

  TrialSpec spec;
  spec.label = call.label;
  spec.kind = TrialKind::kReal;
  spec.design_name = "not described";
  spec.notes = call.notes;
  if (!call.design.empty()) {
    const auto design = ReadDesign(call.design);
    if (!design.ok()) return design.error();
    spec.design = design.value();
    spec.design_name = fs::path(call.design).stem().string();
  }
  if (recording.value().rig) {
    spec.rig_name = recording.value().rig->name;
    spec.rig_toml = recording.value().rig_text;
  }
  spec.gripper.tentacles = 1;
  spec.pull = 0;
  for (const ServoRow& row : recording.value().servo) {
    if (row.command) spec.pull = std::min(1.0, std::max(spec.pull, std::abs(*row.command)));
  }
  // Times within the trial count from here; a log that only knows the time of day still starts there.
  spec.started_ns = frames.front().host_ns;
  constexpr std::int64_t kSomeDateAtAll = 1'000'000'000'000'000'000;  // 2001
  if (spec.started_ns < kSomeDateAtAll) {
    out.Warn(call.frames + ": host_ns is before 2001: the log has no date, and the trial's is of no meaning");
    spec.id = NewTrialId(std::chrono::duration_cast<std::chrono::nanoseconds>(
                             std::chrono::system_clock::now().time_since_epoch())
                             .count());
  }

  std::optional<PlanarChain> chain;
  Provenance provenance{.program_version = ProgramVersion(), .parameters_json = "{}", .input_sha256 = {}};
  double scale = NAN;
  if (!call.chain.empty()) {
    const auto options = PlaneOf(call, recording.value(), &scale);
    if (!options.ok()) return options.error();
    Eigen::VectorXd time(static_cast<Eigen::Index>(frames.size()));
    for (size_t i = 0; i < frames.size(); ++i) {
      time[static_cast<Eigen::Index>(i)] =
          1e-9 * static_cast<double>(frames[i].host_ns - frames.front().host_ns);
    }
    auto followed = FollowPlanarChain(recording.value().detections, time, options.value());
    if (!followed.ok()) return Error(followed.error()).Within(call.detections);
    chain = std::move(followed).value();
    nlohmann::ordered_json parameters = {
        {"method", "planar chain"}, {"chain", call.chain}, {"sigma_px", call.sigma_px}};
    if (!std::isnan(scale)) parameters["scale_mm_per_px"] = 1e3 * scale;
    if (call.spacing_mm > 0) parameters["spacing_mm"] = call.spacing_mm;
    if (!call.origin_px.empty()) parameters["origin_px"] = call.origin_px;
    if (!call.rig.empty()) parameters["rig"] = spec.rig_name;
    provenance.parameters_json = parameters.dump();
  }

  auto lab = OpenLab(call.lab);
  if (!lab.ok()) return lab.error();
  const auto trial = BeginTrial(lab.value(), spec);
  if (!trial.ok()) return trial.error();
  const std::string id = trial.value().id;
  if (Status filled = Fill(lab.value(), id, call, recording.value(), chain, provenance); !filled.ok()) {
    (void)SetTrialState(lab.value(), id, TrialState::kFailed, filled.error().message);
    return std::move(filled).error().Within("trial " + trial.value().label);
  }
  if (Status s = SetTrialState(lab.value(), id, TrialState::kRecorded); !s.ok()) return s;

  auto& fields = out.fields();
  fields["id"] = id;
  fields["label"] = trial.value().label;
  fields["folder"] = lab.value().TrialFolder(id).string();
  fields["frames"] = frames.size();
  fields["detections"] = recording.value().detections.size();
  fields["servo_rows"] = recording.value().servo.size();
  out.Print("trial {} ({}): {} frames, {} detections, {} servo rows", trial.value().label, id, frames.size(),
            recording.value().detections.size(), recording.value().servo.size());
  if (chain) {
    const auto [angle_low, angle_high] = Range(chain->tip_angle);
    const auto [bend_low, bend_high] = Range(chain->mean_curvature);
    fields["complete_frames"] = chain->complete_frames;
    fields["seen_fraction"] = chain->seen_fraction;
    fields["rms_sigma_mm"] = 1e3 * chain->rms_sigma;
    if (!std::isnan(scale)) fields["scale_mm_per_px"] = 1e3 * scale;
    fields["tip_angle_deg"] = {angle_low / kDegree, angle_high / kDegree};
    fields["mean_curvature_per_m"] = {bend_low, bend_high};
    out.Print("centerline of {} nodes in {} of {} frames ({:.1f} % of nodes seen), sigma {:.3f} mm",
              call.chain.size(), chain->complete_frames, frames.size(), 100 * chain->seen_fraction,
              1e3 * chain->rms_sigma);
    out.Print("tip angle {:.1f} to {:.1f} degrees, mean curvature {:.2f} to {:.2f} 1/m", angle_low / kDegree,
              angle_high / kDegree, bend_low, bend_high);
  }
  out.Print("folder: {}", lab.value().TrialFolder(id).string());
  return Ok{};
}

}  // namespace

Command MakeTrialsImportCommand() {
  auto call = std::make_shared<ImportCall>();
  return {
      .path = "trials import",
      .help = "take a real trial recorded elsewhere, without video, into a lab",
      .example =
          "tendril trials import --lab mylab --label limb-1 --detections detections.csv --frames frames.csv "
          "--servo servo.csv --chain 101,102,103 --spacing-mm 12",
      .declare =
          [call](CLI::App& app) {
            AddLabOption(app, call->lab);
            app.add_option("--label", call->label, "short name, unique in the lab (text)");
            app.add_option("--detections", call->detections, "tag detections (CSV file, docs/formats.md)")
                ->required();
            app.add_option("--frames", call->frames, "frame times (CSV file, docs/formats.md)")->required();
            app.add_option("--servo", call->servo, "servo log (CSV file, docs/formats.md)");
            app.add_option("--source", call->source, "the log as it was recorded, kept beside (file)");
            app.add_option("--chain", call->chain,
                           "tag ids from base to tip of one limb seen side-on (numbers)")
                ->delimiter(',');
            app.add_option("--rig", call->rig, "rig file; its first camera sees the plane y = 0 (TOML)");
            app.add_option("--scale-mm-per-px", call->scale_mm_per_px,
                           "scale in the limb's plane, mm per px");
            app.add_option("--spacing-mm", call->spacing_mm,
                           "distance of neighbouring tags, mm: the scale is this over its median in px");
            app.add_option("--origin-px", call->origin_px,
                           "pixel that is the lab's origin, x,y in px; else where the first tag first was")
                ->delimiter(',')
                ->expected(2);
            app.add_option("--sigma-px", call->sigma_px, "standard deviation of a tag's centre, px")
                ->capture_default_str();
            app.add_option("--design", call->design, "design file of the limb, if it is a tentacle (TOML)");
            app.add_option("--notes", call->notes, "what to know about the trial (text)");
          },
      .run = [call](Output& out) { return RunImport(*call, out); },
  };
}

}  // namespace tendril::cli
