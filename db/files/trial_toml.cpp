#include "db/files/trial_toml.h"

#include <fmt/format.h>

#include <array>
#include <vector>

#include "db/files/design_tables.h"
#include "model/check.h"

namespace tendril {
namespace {

template <class Enum>
struct Named {
  Enum value;
  const char* name;
};

// (clang 14 does not deduce an aggregate's arguments, so the types are spelt out.)
constexpr std::array<Named<TrialKind>, 4> kKinds = {{{TrialKind::kReal, "real"},
                                                     {TrialKind::kVirtual, "virtual"},
                                                     {TrialKind::kSimulated, "simulated"},
                                                     {TrialKind::kPublished, "published"}}};
constexpr std::array<Named<TrialState>, 5> kStates = {{{TrialState::kRecording, "recording"},
                                                       {TrialState::kRecorded, "recorded"},
                                                       {TrialState::kDegraded, "degraded"},
                                                       {TrialState::kAborted, "aborted"},
                                                       {TrialState::kFailed, "failed"}}};
constexpr std::array<Named<Handedness>, 3> kHands = {
    {{Handedness::kMirror, "mirror"}, {Handedness::kNormals, "normals"}, {Handedness::kSame, "same"}}};

template <class Table, class Enum>
std::string NameIn(const Table& table, Enum value) {
  for (const auto& entry : table) {
    if (entry.value == value) return entry.name;
  }
  TENDRIL_CHECK(false && "an enumerator without a name");
  return {};
}

template <class Enum, size_t n>
std::optional<Enum> ValueIn(const std::array<Named<Enum>, n>& table, std::string_view name) {
  for (const auto& entry : table) {
    if (entry.name == name) return entry.value;
  }
  return std::nullopt;
}

template <class Enum, size_t n>
void ReadEnum(TomlTable& from, const std::string& key, const std::array<Named<Enum>, n>& table,
              Enum& target) {
  std::vector<std::string> known;
  for (const auto& entry : table) known.emplace_back(entry.name);
  std::string name;
  if (from.Choice(key, name, known)) target = *ValueIn(table, name);
}

void ReadGripper(TomlTable from, Gripper& gripper) {
  from.Integer("tentacles", gripper.tentacles, AtLeast(1));
  from.Number("carrier_radius", gripper.carrier_radius, AtLeast(0, "m"));
  from.Degrees("first_azimuth_deg", gripper.first_azimuth);
  from.Number("pair_spacing", gripper.pair_spacing, AtLeast(0, "m"));
  from.Degrees("tilt_deg", gripper.tilt, Between(-90, 90, "deg"));
  ReadEnum(from, "handedness", kHands, gripper.handedness);
}

void ReadObject(TomlTable from, ObjectSpec& object, double& distance) {
  from.Text("kind", object.kind);
  from.Number("radius", object.radius, AtLeast(0, "m"));
  from.Number("length", object.length, AtLeast(0, "m"));
  from.Vector("position", object.position, Finite("m"));
  from.Vector("axis", object.axis);
  if (object.axis.isZero()) from.Reject("axis", "a direction, not all 0");
  from.Number("mass", object.mass, AtLeast(0, "kg"));
  from.Number("distance", distance, Finite("m"));
}

}  // namespace

std::string NameOf(TrialKind kind) { return NameIn(kKinds, kind); }
std::string NameOf(TrialState state) { return NameIn(kStates, state); }
std::string NameOf(Handedness handedness) { return NameIn(kHands, handedness); }
std::optional<TrialKind> TrialKindOf(std::string_view name) { return ValueIn(kKinds, name); }
std::optional<TrialState> TrialStateOf(std::string_view name) { return ValueIn(kStates, name); }
std::optional<Handedness> HandednessOf(std::string_view name) { return ValueIn(kHands, name); }

Result<TrialSpec> ReadTrialToml(const std::filesystem::path& file) {
  auto document = TomlDocument::Read(file);
  if (!document.ok()) return document.error();
  TomlTable& root = document.value().Root();
  TrialSpec trial;
  root.Required().Text("id", trial.id);
  root.Required().Text("label", trial.label);
  root.Required();
  ReadEnum(root, "kind", kKinds, trial.kind);
  root.Required().Integer("started_ns", trial.started_ns, AtLeast(0, "ns"));
  root.Text("medium", trial.medium);
  root.Number("pull", trial.pull, Between(0, 1, "of the flat tendon length"));
  root.Number("pull_rate", trial.pull_rate, AtLeast(0, "1/s"));
  root.Text("notes", trial.notes);
  ReadObject(root.Table("object"), trial.object, trial.object_distance);
  ReadGripper(root.Table("gripper"), trial.gripper);
  ReadTagTable(root.Table("tags"), trial.tags);
  TomlTable rig = root.Table("rig");
  rig.Text("name", trial.rig_name);
  rig.Text("toml", trial.rig_toml);
  TomlTable design = root.Required().Table("design");
  design.Required().Text("name", trial.design_name);
  ReadDesignTables(design, trial.design);
  if (Status read = document.value().Finish(); !read.ok()) return read.error();
  return trial;
}

std::string TrialToml(const TrialSpec& trial) {
  std::string out = fmt::format(
      "id = {}\nlabel = {}\nkind = \"{}\"\nstarted_ns = {}  # host clock, UTC\nmedium = {}\n"
      "pull = {}  # commanded at the end, of the flat tendon length\npull_rate = {}  # 1/s\nnotes = {}\n\n",
      TomlText(trial.id), TomlText(trial.label), NameOf(trial.kind), trial.started_ns, TomlText(trial.medium),
      TomlNumber(trial.pull), TomlNumber(trial.pull_rate), TomlText(trial.notes));
  out += ObjectToml(trial.object);
  out += fmt::format("distance = {}  # m, carrier to object\n\n", TomlNumber(trial.object_distance));
  out += GripperToml(trial.gripper) + "\n";
  out += TagTableToml(trial.tags) + "\n";
  out += fmt::format("[design]\nname = {}\n\n{}\n", TomlText(trial.design_name),
                     DesignTablesToml(trial.design, "design."));
  out += fmt::format("[rig]\nname = {}\ntoml = {}\n", TomlText(trial.rig_name), TomlText(trial.rig_toml));
  return out;
}

std::string ObjectToml(const ObjectSpec& object) {
  return fmt::format(
      "[object]\nkind = {}\nradius = {}  # m\nlength = {}  # m\nposition = {}  # m, lab frame\naxis = {}\n"
      "mass = {}  # kg\n",
      TomlText(object.kind), TomlNumber(object.radius), TomlNumber(object.length),
      TomlVector(object.position), TomlVector(object.axis), TomlNumber(object.mass));
}

std::string GripperToml(const Gripper& gripper) {
  const std::string spacing =
      gripper.pair_spacing == 0 ? "" : "pair_spacing = " + TomlNumber(gripper.pair_spacing) + "  # m\n";
  return fmt::format(
      "[gripper]\ntentacles = {}\ncarrier_radius = {}  # m\nfirst_azimuth_deg = {}\ntilt_deg = {}\n"
      "handedness = \"{}\"\n{}",
      gripper.tentacles, TomlNumber(gripper.carrier_radius), TomlDegrees(gripper.first_azimuth),
      TomlDegrees(gripper.tilt), NameOf(gripper.handedness), spacing);
}

}  // namespace tendril
