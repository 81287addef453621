#include "capture/record/virtual_trial.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "capture/rig/portable_random.h"
#include "capture/rig/rig.h"
#include "capture/rig/tag_layout.h"
#include "db/files/curve_files.h"
#include "db/files/safe_file.h"
#include "db/files/toml_read.h"
#include "db/files/toml_write.h"

namespace tendril {
namespace {

// Generators that do not depend on each other, so that cameras may draw in any order.
enum Stream : std::uint32_t {
  kTruthStream = 0,
  kServoStream = 1,
  kFirstCameraStream = 2,
  kGlueStream = 1000000
};

std::mt19937_64 StreamOf(std::uint64_t seed, std::uint32_t stream) {
  std::seed_seq mixed{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32), stream};
  return std::mt19937_64(mixed);
}

class VirtualFrameSource : public FrameSource {
 public:
  VirtualFrameSource(std::shared_ptr<const VirtualTruth> truth, VirtualCamera camera,
                     std::vector<double> times, std::mt19937_64 random)
      : truth_(std::move(truth)), camera_(std::move(camera)), times_(std::move(times)), random_(random) {}

  bool paced() const override { return true; }
  std::optional<std::int64_t> frames() const override { return static_cast<std::int64_t>(times_.size()); }

  Result<std::optional<SourceFrame>> Next() override {
    if (taken_ == times_.size()) return std::optional<SourceFrame>();
    const Result<TrueShape> shape = TrueShapeAt(*truth_, times_[taken_]);
    if (!shape.ok()) return shape.error();
    SourceFrame frame;
    frame.image = camera_.Render(shape.value(), random_);
    frame.time = times_[taken_];
    frame.frame_id = static_cast<std::int64_t>(taken_);
    frame.device_ns = std::llround(1e9 * frame.time);
    ++taken_;
    return std::optional<SourceFrame>(std::move(frame));
  }

 private:
  std::shared_ptr<const VirtualTruth> truth_;
  VirtualCamera camera_;
  std::vector<double> times_;
  std::mt19937_64 random_;
  std::size_t taken_ = 0;
};

class VirtualServoSource : public ServoSource {
 public:
  VirtualServoSource(std::shared_ptr<const VirtualTruth> truth, const VirtualTrialOptions& options,
                     double end)
      : truth_(std::move(truth)),
        radius_(options.spool_radius),
        interval_(1 / options.servo_rate),
        rows_(static_cast<std::int64_t>(std::floor(end * options.servo_rate)) + 1),
        random_(StreamOf(options.seed, kServoStream)) {}

  Result<std::optional<ServoSample>> Next() override {
    if (row_ == rows_) return std::optional<ServoSample>();
    ServoSample sample;
    sample.time = interval_ * static_cast<double>(row_);
    const double command = CommandAt(*truth_, servo_, sample.time);
    const double length = FlatTendonLength(truth_->tentacles[static_cast<std::size_t>(servo_)].layout);
    const double turned_deg = command * length / radius_ * 180 / std::numbers::pi;
    constexpr double kCounts = 360.0 / 4096;  // the encoder's step, degrees
    sample.row.device_ms = std::llround(1e3 * sample.time);
    sample.row.servo = servo_;
    sample.row.command = command;
    sample.row.position_deg = kCounts * std::round((turned_deg + DrawNormal(random_, 0.05)) / kCounts);
    sample.row.current_mA = std::round(60 + 900 * command + DrawNormal(random_, 4));
    sample.row.voltage_V = 0.1 * std::round(10 * (11.9 + DrawNormal(random_, 0.05)));
    sample.row.temperature_degC = 31;
    if (++servo_ == static_cast<int>(truth_->tentacles.size())) {
      servo_ = 0;
      ++row_;
    }
    return std::optional<ServoSample>(sample);
  }

 private:
  std::shared_ptr<const VirtualTruth> truth_;
  double radius_;
  double interval_;
  std::int64_t rows_;
  std::mt19937_64 random_;
  std::int64_t row_ = 0;
  int servo_ = 0;
};

Status CheckOptions(const TrialSpec& trial, const VirtualTrialOptions& o) {
  const auto bad = [](const std::string& what) {
    return Error{ErrorKind::kBadInput, "virtual trial: " + what};
  };
  if (o.frames < 1 || o.frames > 100000) return bad(fmt::format("{} frames; expected 1 .. 100000", o.frames));
  if (!(o.hold >= 0 && o.hold <= 3600)) return bad(fmt::format("hold of {} s; expected 0 .. 3600", o.hold));
  if (!(o.servo_rate > 0 && o.servo_rate <= 1000)) {
    return bad(fmt::format("servo rate of {} 1/s; expected above 0 and up to 1000", o.servo_rate));
  }
  if (!(o.spool_radius > 0))
    return bad(fmt::format("spool radius of {} m; expected above 0", o.spool_radius));
  if (!(o.fold.pull_scale > 0 && o.fold.stiffness_ratio > 0 && std::isfinite(o.fold.stiffness_exponent))) {
    return bad("pull_scale and stiffness_ratio must be above 0 and stiffness_exponent finite");
  }
  if (!(o.fold.rest_angle >= 0 && o.fold.rest_angle < trial.design.closed_angle && o.fold.friction >= 0)) {
    return bad(fmt::format(
        "rest angle of {:g} degrees and friction of {}; expected 0 to below the closed angle, {:g} "
        "degrees, and 0 or more",
        o.fold.rest_angle * 180 / std::numbers::pi, o.fold.friction,
        trial.design.closed_angle * 180 / std::numbers::pi));
  }
  if (!(trial.pull >= 0 && trial.pull < 1))
    return bad(fmt::format("pull of {}; expected 0 .. 1", trial.pull));
  if (!(trial.pull_rate > o.ranges.rate_perturbation)) {
    return bad(fmt::format("pull rate of {} 1/s; expected above its perturbation, {} 1/s", trial.pull_rate,
                           o.ranges.rate_perturbation));
  }
  if (trial.object.kind != "cylinder") {
    return bad(fmt::format("object '{}'; expected a cylinder", trial.object.kind));
  }
  return Ok{};
}

std::string TruthToml(const VirtualTruth& truth, std::uint64_t seed) {
  const auto vector = [](const Eigen::Vector3d& v) {
    return fmt::format("[{}, {}, {}]", TomlNumber(v.x()), TomlNumber(v.y()), TomlNumber(v.z()));
  };
  std::string text =
      "# The hidden truth of a virtual trial. For judging results only: nothing that tracks or fits reads "
      "it.\n";
  text += fmt::format(
      "seed = \"{}\"\n\n[fold]\npull_scale = {}\nstiffness_ratio = {}\nstiffness_exponent = {}\n"
      "law = \"{}\"\nrest_angle_deg = {}\nfriction = {}\n",
      seed, TomlNumber(truth.fold.pull_scale), TomlNumber(truth.fold.stiffness_ratio),
      TomlNumber(truth.fold.stiffness_exponent), NameOf(truth.fold.law), TomlDegrees(truth.fold.rest_angle),
      TomlNumber(truth.fold.friction));
  text += fmt::format("\n[object]\nposition = {}\naxis = {}\nradius = {}\nlength = {}\n",
                      vector(truth.object.center), vector(truth.object.axis), TomlNumber(truth.object.radius),
                      TomlNumber(truth.object.length));
  for (const TentacleTruth& t : truth.tentacles) {
    text += fmt::format(
        "\n[[tentacle]]\ndelay = {}  # s\nrate_offset = {}  # 1/s\nsag_compliance = {}  # rad / (N m)\n",
        TomlNumber(t.delay), TomlNumber(t.rate_offset), TomlNumber(t.sag_compliance));
  }
  return text;
}

Status WriteTruth(const std::filesystem::path& folder, const VirtualTruth& truth,
                  const std::vector<double>& times, std::uint64_t seed) {
  std::vector<CurveSeries> curves(truth.tentacles.size());
  for (std::size_t i = 0; i < curves.size(); ++i) {
    curves[i].name = fmt::format("tentacle{}", i);
    curves[i].time = Eigen::Map<const Eigen::VectorXd>(times.data(), static_cast<Eigen::Index>(times.size()));
  }
  for (const double time : times) {
    Result<TrueShape> shape = TrueShapeAt(truth, time);
    if (!shape.ok()) return shape.error();
    for (std::size_t i = 0; i < curves.size(); ++i) {
      curves[i].curves.push_back(std::move(shape.value().tentacles[i].centerline));
    }
  }
  if (Status s = WriteCurves(folder / "truth.h5", curves, "the virtual rig's true shapes"); !s.ok()) return s;
  return WriteText(folder / "truth.toml", TruthToml(truth, seed));
}

}  // namespace

Result<RecordPlan> PlanVirtualTrial(TrialSpec trial, const VirtualTrialOptions& options) {
  if (Status s = CheckOptions(trial, options); !s.ok()) return s.error();
  const Result<Rig> rig = ParseRig(trial.rig_toml, trial.rig_name.empty() ? "rig" : trial.rig_name);
  if (!rig.ok()) return rig.error();
  if (rig.value().cameras.empty()) {
    return Error{ErrorKind::kBadInput, "virtual trial: the rig has no camera; expected one or more"};
  }
  const Result<TagLayout> tags = LayOutTags(trial.design, trial.gripper, LayoutOptionsOf(trial.tags));
  if (!tags.ok()) return tags.error();

  VirtualCylinder object{trial.object.position, trial.object.axis, trial.object.radius, trial.object.length};
  std::mt19937_64 random = StreamOf(options.seed, kTruthStream);
  Result<VirtualTruth> drawn = DrawTruth(trial.design, trial.gripper, options.fold,
                                         {trial.pull, trial.pull_rate}, object, options.ranges, random);
  if (!drawn.ok()) return drawn.error();
  const auto truth = std::make_shared<const VirtualTruth>(std::move(drawn).value());
  std::mt19937_64 hands = StreamOf(options.seed, kGlueStream);
  const TagLayout glued = GlueTags(tags.value(), options.ranges, hands);

  const double end = trial.pull / (trial.pull_rate - options.ranges.rate_perturbation) +
                     options.ranges.largest_delay + options.hold;
  std::vector<double> times;
  for (int i = 0; i < options.frames; ++i) {
    const double share = options.frames == 1 ? 1 : static_cast<double>(i) / (options.frames - 1);
    times.push_back(1e-3 * std::round(1e3 * share * end));  // whole milliseconds, as the video keeps them
  }
  if (const Result<TrueShape> last = TrueShapeAt(*truth, end); !last.ok()) return last.error();

  RecordPlan plan;
  for (std::size_t i = 0; i < rig.value().cameras.size(); ++i) {
    Result<VirtualCamera> camera =
        VirtualCamera::Make(rig.value().cameras[i], glued, trial.design.hole_diameter, options.optics);
    if (!camera.ok()) return camera.error();
    plan.cameras.push_back(std::make_unique<VirtualFrameSource>(
        truth, std::move(camera).value(), times,
        StreamOf(options.seed, kFirstCameraStream + static_cast<std::uint32_t>(i))));
  }
  plan.servo = std::make_unique<VirtualServoSource>(truth, options, end);
  plan.write_also = [truth, times, seed = options.seed](const std::filesystem::path& folder) {
    return WriteTruth(folder, *truth, times, seed);
  };
  plan.trial = std::move(trial);
  plan.trial.kind = TrialKind::kVirtual;
  return plan;
}

Result<TruthFile> ReadTruthFile(const std::filesystem::path& file) {
  Result<TomlDocument> toml = TomlDocument::Read(file);
  if (!toml.ok()) return toml.error();
  TruthFile truth;
  std::string seed;
  toml.value().Root().Required().Text("seed", seed);
  TomlTable fold = toml.value().Table("fold");
  fold.Required().Number("pull_scale", truth.fold.pull_scale, Above(0));
  fold.Required().Number("stiffness_ratio", truth.fold.stiffness_ratio, Above(0));
  fold.Required().Number("stiffness_exponent", truth.fold.stiffness_exponent);
  std::string law = "paper";  // recordings of before have no law: it was the paper's
  fold.Choice("law", law, {"paper", "exact"});
  truth.fold.law = FoldLawOf(law).value_or(FoldLaw::kPaper);
  fold.Degrees("rest_angle_deg", truth.fold.rest_angle, Between(0, 90, "deg"));
  fold.Number("friction", truth.fold.friction, AtLeast(0));
  TomlTable object = toml.value().Table("object");
  object.Required().Vector("position", truth.object.center, Finite("m"));
  object.Required().Vector("axis", truth.object.axis);
  object.Required().Number("radius", truth.object.radius, AtLeast(0, "m"));
  object.Required().Number("length", truth.object.length, AtLeast(0, "m"));
  for (TomlTable& tentacle : toml.value().Tables("tentacle")) {
    double unused = 0;
    tentacle.Number("delay", unused, AtLeast(0, "s"));
    tentacle.Number("rate_offset", unused, Finite("1/s"));
    tentacle.Number("sag_compliance", unused, AtLeast(0, "rad / (N m)"));
  }
  if (Status s = toml.value().Finish(); !s.ok()) return s.error();
  char* end = nullptr;
  truth.seed = std::strtoull(seed.c_str(), &end, 10);
  if (seed.empty() || *end != '\0') {
    return Error{ErrorKind::kBadInput,
                 fmt::format("{}: seed = \"{}\"; expected a whole number from 0", file.string(), seed)};
  }
  return truth;
}

}  // namespace tendril
