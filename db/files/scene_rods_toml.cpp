#include <algorithm>
#include <set>

#include "db/files/scene_tables.h"
#include "model/rods/start_shape.h"

namespace tendril {
namespace {

void ReadMotion(TomlTable table, EndMotion& motion) {
  if (!table.exists()) return;
  table.Vector("velocity", motion.velocity, Finite("m/s"));
  table.Vector("spin", motion.spin, Finite("rad/s"));
  table.Required().Number("until", motion.until, Above(0, "s"));
  table.Number("from", motion.from, AtLeast(0, "s"));
  if (motion.from > motion.until) table.Reject("from", "a time not after until");
}

// In their place are start, direction, length and start_curvature.
void ReadStartPoints(TomlTable& table, RodDesign& design) {
  std::vector<double> numbers;
  if (!table.Numbers("start_points", numbers, Finite("m"))) return;
  for (const char* key : {"start", "direction", "length", "start_curvature"}) {
    if (table.Has(key)) table.Reject(key, "none beside start_points, which say it");
  }
  const auto points = static_cast<Eigen::Index>(numbers.size() / 3);
  const Eigen::Map<const Eigen::Matrix3Xd> at(numbers.data(), 3, points);
  if (numbers.size() % 3 != 0 || !LayThrough(at, design).ok()) {
    table.Reject("start_points", "x, y, z of four points or more, each elsewhere than the one before");
  }
}

SceneRod ReadRod(TomlTable& table, std::size_t number) {
  SceneRod rod;
  rod.name = "rod" + std::to_string(number);
  ReadName(table, rod.name);
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
  ReadWetted(table, rod.design.base_radius, rod.wetted);
  ReadStartPoints(table, rod.design);
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

void ReadRodKeys(TomlTable& table, RodDesign& design, double& damping) {
  table.Number("base_radius", design.base_radius, Above(0, "m"));
  table.Number("density", design.density, Above(0, "kg/m^3"));
  table.Number("youngs_modulus", design.youngs_modulus, Above(0, "Pa"));
  table.Number("shear_modulus", design.shear_modulus, Above(0, "Pa"));
  table.Integer("elements", design.elements, Between(2, 100000));
  table.Number("damping", damping, AtLeast(0, "1/s"));
}

void ReadWetted(TomlTable& table, double base_radius, Wetted& wetted) {
  double diameter = 0;
  if (table.Number("drag_diameter", diameter, AtLeast(0, "m"))) {
    wetted.drag_diameter_scale = diameter / (2 * base_radius);
  }
  table.Number("displaced", wetted.displaced, AtLeast(0));
}

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

void ReadName(TomlTable& table, std::string& name) {
  table.Text("name", name);
  const auto odd = [](char c) { return c == ',' || c == '/' || static_cast<unsigned char>(c) < ' '; };
  if (name.empty() || std::any_of(name.begin(), name.end(), odd)) {
    table.Reject("name", "a name without comma, slash or control character");
  }
}

std::vector<SceneRod> ReadRods(TomlDocument& document) {
  std::vector<SceneRod> rods;
  std::set<std::string> names;
  for (TomlTable& table : document.Tables("rod")) {
    rods.push_back(ReadRod(table, rods.size()));
    if (!names.insert(rods.back().name).second) table.Reject("name", "a name of its own for each rod");
  }
  return rods;
}

}  // namespace tendril
