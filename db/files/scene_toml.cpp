#include "db/files/scene_toml.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <set>

#include "db/files/design_toml.h"
#include "db/files/toml_read.h"

namespace tendril {
namespace {

namespace fs = std::filesystem;

void ReadRodKeys(TomlTable& table, RodDesign& design, double& damping) {
  table.Number("base_radius", design.base_radius, Above(0, "m"));
  table.Number("density", design.density, Above(0, "kg/m^3"));
  table.Number("youngs_modulus", design.youngs_modulus, Above(0, "Pa"));
  table.Number("shear_modulus", design.shear_modulus, Above(0, "Pa"));
  table.Integer("elements", design.elements, Between(2, 100000));
  table.Number("damping", damping, AtLeast(0, "1/s"));
}

// A pair [low, high] in ascending order.
void ReadSpan(TomlTable& table, const std::string& key, double& low, double& high) {
  std::vector<double> span;
  if (!table.Numbers(key, span, AtLeast(0, "s"))) return;
  if (span.size() != 2 || span[0] > span[1]) {
    table.Reject(key, "two numbers, [from, to], from not above to");
    return;
  }
  low = span[0];
  high = span[1];
}

Status ReadGripper(TomlTable table, const fs::path& scene_file, SceneGripper& g) {
  std::string design;
  table.Required().Text("design", design);
  table.Integer("tentacles", g.gripper.tentacles, Between(1, 1000));
  table.Number("carrier_radius", g.gripper.carrier_radius, AtLeast(0, "m"));
  table.Degrees("first_azimuth_deg", g.gripper.first_azimuth);
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

SceneObject ReadObject(TomlTable& table) {
  SceneObject object;
  double length = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero(), axis = Eigen::Vector3d::UnitX();
  std::string motion = "fixed";
  table.Required().Choice("kind", object.kind, {"cylinder", "capsule", "sphere"});
  table.Required().Number("radius", object.body.radius, Above(0, "m"));
  if (object.kind != "sphere") {
    table.Required().Number("length", length, Above(0, "m"));
    table.Vector("axis", axis);
    if (!(axis.norm() > 0)) table.Reject("axis", "a direction, not all zeros");
  }
  table.Vector("position", position);
  table.Choice("motion", motion, {"fixed"});
  // The body's ends are round: a cylinder counts as a capsule of its length, ends included.
  const double half = std::max(0.0, 0.5 * length - object.body.radius);
  const Eigen::Vector3d along = axis.norm() > 0 ? axis.normalized() : Eigen::Vector3d::UnitX();
  object.body.start = position - half * along;
  object.body.end = position + half * along;
  return object;
}

void ReadMotion(TomlTable table, EndMotion& motion) {
  if (!table.exists()) return;
  table.Vector("velocity", motion.velocity, Finite("m/s"));
  table.Vector("spin", motion.spin, Finite("rad/s"));
  table.Required().Number("until", motion.until, Above(0, "s"));
  table.Number("from", motion.from, AtLeast(0, "s"));
  if (motion.from > motion.until) table.Reject("from", "a time not after until");
}

SceneRod ReadRod(TomlTable& table, std::size_t number) {
  SceneRod rod;
  rod.name = "rod" + std::to_string(number);
  table.Text("name", rod.name);
  const auto odd = [](char c) { return c == ',' || c == '/' || static_cast<unsigned char>(c) < ' '; };
  if (rod.name.empty() || std::any_of(rod.name.begin(), rod.name.end(), odd)) {
    table.Reject("name", "a name without comma, slash or control character");
  }
  table.Vector("start", rod.design.start);
  table.Vector("direction", rod.design.direction);
  // A rod along x has its d1 elsewhere, unless it is told.
  if (!table.Vector("normal", rod.design.normal) &&
      rod.design.direction.cross(rod.design.normal).norm() < 1e-6 * rod.design.direction.norm()) {
    rod.design.normal = Eigen::Vector3d::UnitZ();
  }
  table.Number("length", rod.design.length, Above(0, "m"));
  table.Number("taper", rod.design.taper, Above(0));
  ReadRodKeys(table, rod.design, rod.damping);
  std::string clamp = "base";
  table.Choice("clamp", clamp, {"base", "both", "none"});
  rod.design.base = clamp == "none" ? EndHold::kFree : EndHold::kFrame;
  rod.design.tip = clamp == "both" ? EndHold::kFrame : EndHold::kFree;
  table.Vector("start_curvature", rod.design.start_curvature, Finite("1/m"));
  table.Vector("rest_curvature", rod.rest_curvature, Finite("1/m"));
  ReadSpan(table, "ramp", rod.ramp_start, rod.ramp_end);
  table.Vector("velocity", rod.velocity, Finite("m/s"));
  table.Vector("spin", rod.spin, Finite("rad/s"));
  table.Vector("tip_force", rod.tip_force, Finite("N"));
  table.Vector("tip_couple", rod.tip_couple, Finite("N m"));
  if (clamp == "none" && table.Has("base_motion"))
    table.Reject("clamp", "base or both, where there is a base_motion");
  if (clamp != "both" && table.Has("tip_motion")) table.Reject("clamp", "both, where there is a tip_motion");
  if (clamp == "both" && (rod.tip_force.norm() > 0 || rod.tip_couple.norm() > 0)) {
    table.Reject("clamp", "base or none, where there is a tip_force or tip_couple: a held tip does not give");
  }
  ReadMotion(table.Table("base_motion"), rod.base_motion);
  ReadMotion(table.Table("tip_motion"), rod.tip_motion);
  return rod;
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

Result<Scene> ReadScene(const fs::path& file) {
  Result<TomlDocument> parsed = TomlDocument::Read(file);
  if (!parsed.ok()) return parsed.error();
  TomlDocument& document = parsed.value();
  TomlTable& root = document.Root();
  Scene scene;
  scene.name = file.stem().string();
  root.Text("name", scene.name);
  root.Number("duration", scene.duration, Above(0, "s"));
  std::int64_t seed = 1;
  root.Integer("seed", seed, AtLeast(0));
  scene.seed = static_cast<std::uint64_t>(seed);
  std::string level = "standard", medium_kind = "vacuum", law = "hertz_segments";
  root.Choice("level", level, {"paper", "standard", "fast", "static"});
  scene.level = LevelNamed(level);
  root.Number("time_step", scene.time_step, Above(0, "s"));

  TomlTable medium = document.Table("medium");
  medium.Choice("kind", medium_kind, {"vacuum"});
  medium.Vector("gravity", scene.gravity, Finite("m/s^2"));

  TomlTable gripper = document.Table("gripper");
  Status designed = Ok{};
  if (gripper.exists()) designed = ReadGripper(gripper, file, scene.gripper.emplace());
  for (TomlTable& table : document.Tables("object")) scene.objects.push_back(ReadObject(table));

  TomlTable contact = document.Table("contact");
  contact.Choice("law", law, {"hertz_segments", "hertz_equal", "hertz_centers"});
  scene.contact.law = law == "hertz_segments" ? ContactLaw::kHertzSegments
                      : law == "hertz_equal"  ? ContactLaw::kHertzEqual
                                              : ContactLaw::kHertzCenters;
  contact.Number("stiffness", scene.contact.stiffness, AtLeast(0, "N/m^1.5"));
  contact.Number("damping", scene.contact.damping, AtLeast(0, "N s/m"));
  std::size_t number = 0;
  std::set<std::string> names;
  for (TomlTable& table : document.Tables("rod")) {
    scene.rods.push_back(ReadRod(table, number++));
    if (!names.insert(scene.rods.back().name).second) table.Reject("name", "a name of its own for each rod");
  }

  if (Status read = document.Finish(); !read.ok()) return std::move(read).error();
  if (!designed.ok()) return std::move(designed).error();
  return scene;
}

}  // namespace tendril
