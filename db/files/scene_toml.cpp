#include "db/files/scene_toml.h"

#include <fmt/format.h>

#include "db/files/design_toml.h"
#include "db/files/scene_tables.h"
#include "db/files/toml_read.h"
#include "model/scene/scene_check.h"

namespace tendril {
namespace {

namespace fs = std::filesystem;

Stow ReadStow(TomlTable& table) {
  Stow stow;
  const bool by_radius = table.Number("inner_radius", stow.inner_radius, Above(0, "m"));
  const bool by_turns = table.Number("turns", stow.turns, Above(0));
  if (by_radius && by_turns) table.Reject("turns", "turns or an inner_radius, not both");
  if (!table.Has("inner_radius") && !table.Has("turns")) table.Reject("turns", "turns or an inner_radius");
  table.Number("gap", stow.gap, AtLeast(0, "m"));
  table.Number("release_time", stow.release_time, AtLeast(0, "s"));
  table.Number("unroll_time", stow.unroll_time, AtLeast(0, "s"));
  table.Number("eject_speed", stow.eject_speed, AtLeast(0, "m/s"));
  return stow;
}

Status ReadGripper(TomlTable table, const fs::path& scene_file, SceneGripper& g) {
  std::string design;
  table.Required().Text("design", design);
  table.Integer("tentacles", g.gripper.tentacles, Between(1, 1000));
  table.Number("carrier_radius", g.gripper.carrier_radius, AtLeast(0, "m"));
  table.Degrees("first_azimuth_deg", g.gripper.first_azimuth);
  if (table.Number("pair_spacing", g.gripper.pair_spacing, AtLeast(0, "m")) &&
      g.gripper.pair_spacing > WidestPairSpacing(g.gripper)) {
    table.Reject("pair_spacing", g.gripper.tentacles % 2 != 0
                                     ? "an even number of tentacles beside it"
                                     : fmt::format("at most {:.4g} m: beyond, pairs reach into each other",
                                                   WidestPairSpacing(g.gripper)));
  }
  table.Degrees("tilt_deg", g.gripper.tilt, Between(-90, 90, "deg"));
  std::string handedness = "mirror", map = "turning", shortening = "carrier";
  table.Choice("handedness", handedness, {"mirror", "normals", "same"});
  g.gripper.handedness = handedness == "mirror"    ? Handedness::kMirror
                         : handedness == "normals" ? Handedness::kNormals
                                                   : Handedness::kSame;
  table.Choice("curvature_map", map, {"turning", "material", "unscaled"});
  g.curvature_map = map == "turning"    ? CurvatureMap::kTurning
                    : map == "material" ? CurvatureMap::kMaterial
                                        : CurvatureMap::kUnscaled;
  table.Number("pull", g.pull, Between(0, 1));
  table.Number("pull_rate", g.pull_rate, Above(0, "1/s"));
  ReadSpan(table, "delay", g.delay_low, g.delay_high);
  table.Number("rate_perturbation", g.rate_perturbation, AtLeast(0, "1/s"));
  if (g.rate_perturbation >= g.pull_rate) table.Reject("rate_perturbation", "a number below pull_rate");
  table.Choice("shortening", shortening, {"carrier", "true"});
  g.shortening = shortening == "carrier" ? Shortening::kCarrier : Shortening::kTrue;
  if (g.pull >= 1 && g.shortening == Shortening::kCarrier) {
    table.Reject("pull", "a number below 1: the carrier grows as 1 / (1 - pull)");
  }
  TomlTable rod = table.Table("rod");
  ReadRodKeys(rod, g.rod, g.damping);
  ReadWetted(rod, g.rod.base_radius, g.wetted);
  TomlTable stowed = table.Table("stowed");
  if (stowed.exists()) g.stowed = ReadStow(stowed);
  if (design.empty()) return Ok{};  // said by the document
  const fs::path folder = scene_file.parent_path();
  fs::path file = folder / design;
  if (!fs::exists(file)) file = folder / ".." / design;
  if (!fs::exists(file)) {
    table.Reject("design", "a design file beside the scene or in the folder above it");
    return Ok{};
  }
  Result<TentacleDesign> read = ReadDesign(file);
  if (!read.ok()) return read.error();
  g.design = std::move(read).value();
  g.design_name = file.stem().string();
  return Ok{};
}

void ReadMedium(TomlTable& table, Scene& scene) {
  std::string kind = "vacuum";
  table.Choice("kind", kind, {"vacuum", "air", "water"});
  table.Vector("gravity", scene.gravity, Finite("m/s^2"));
  Medium& medium = scene.medium;
  if (kind == "air") medium = Air();
  if (kind == "water") medium = Water();
  table.Number("density", medium.density, Above(0, "kg/m^3"));
  table.Vector("flow", medium.flow, Finite("m/s"));
  table.Number("cross_drag", medium.cross_drag, AtLeast(0));
  table.Number("along_drag", medium.along_drag, AtLeast(0));
  table.Number("added_mass", medium.added_mass, AtLeast(0));
  for (const char* key : {"density", "flow", "cross_drag", "along_drag", "added_mass"}) {
    if (kind == "vacuum" && table.Has(key)) table.Reject(key, "kind = air or water beside it");
  }
}

void ReadContact(TomlTable& table, Contact& contact) {
  std::string law = "hertz_segments";
  table.Choice("law", law, {"hertz_segments", "hertz_equal", "hertz_centers"});
  contact.law = law == "hertz_segments" ? ContactLaw::kHertzSegments
                : law == "hertz_equal"  ? ContactLaw::kHertzEqual
                                        : ContactLaw::kHertzCenters;
  table.Number("stiffness", contact.stiffness, AtLeast(0, "N/m^1.5"));
  table.Number("damping", contact.damping, AtLeast(0, "N s/m"));
  table.Number("friction", contact.friction, AtLeast(0));
  if (table.Number("friction_static", contact.static_friction, AtLeast(0)) &&
      contact.static_friction < contact.friction) {
    table.Reject("friction_static", "a number not below friction");
  }
  table.Number("tangential_stiffness_ratio", contact.tangential_ratio, Above(0));
}

}  // namespace

SimulationLevel LevelNamed(const std::string& name) {
  return name == "paper"    ? SimulationLevel::kPaper
         : name == "fast"   ? SimulationLevel::kFast
         : name == "static" ? SimulationLevel::kStatic
                            : SimulationLevel::kStandard;
}

std::string NameOf(SimulationLevel level) {
  for (const char* name : {"paper", "fast", "static"}) {
    if (LevelNamed(name) == level) return name;
  }
  return "standard";
}

Result<Scene> ReadScene(const fs::path& file, const std::vector<std::string>& settings,
                        std::optional<SimulationLevel> instead) {
  Result<TomlDocument> parsed = TomlDocument::Read(file);
  if (!parsed.ok()) return parsed.error();
  TomlDocument& document = parsed.value();
  if (Status set = document.Set(settings); !set.ok()) return std::move(set).error();
  TomlTable& root = document.Root();
  Scene scene;
  scene.name = file.stem().string();
  root.Text("name", scene.name);
  root.Number("duration", scene.duration, Above(0, "s"));
  std::int64_t seed = 1;
  root.Integer("seed", seed, AtLeast(0));
  scene.seed = static_cast<std::uint64_t>(seed);
  std::string level = "standard";
  root.Choice("level", level, {"paper", "standard", "fast", "static"});
  scene.level = instead.value_or(LevelNamed(level));
  root.Number("time_step", scene.time_step, Above(0, "s"));

  TomlTable medium = document.Table("medium");
  ReadMedium(medium, scene);

  TomlTable gripper = document.Table("gripper");
  Status designed = Ok{};
  if (gripper.exists()) designed = ReadGripper(gripper, file, scene.gripper.emplace());
  scene.objects = ReadObjects(document, scene.gravity);
  scene.rods = ReadRods(document);
  ReadPhases(document, scene);
  TomlTable contact = document.Table("contact");
  ReadContact(contact, scene.contact);
  const std::optional<SceneConflict> conflict = ConflictIn(scene);
  const bool of_call = conflict && conflict->key == "level" && instead;
  if (conflict && !of_call) {
    (conflict->table.empty() ? root : contact).Reject(conflict->key, conflict->expected);
  }

  if (Status read = document.Finish(); !read.ok()) return std::move(read).error();
  if (!designed.ok()) return std::move(designed).error();
  if (of_call) {
    return Error{ErrorKind::kBadInput, fmt::format("{}: --level {}: expected {}", file.string(),
                                                   NameOf(scene.level), conflict->expected)};
  }
  return scene;
}

}  // namespace tendril
