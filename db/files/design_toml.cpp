#include "db/files/design_toml.h"

#include <fmt/format.h>

#include "db/files/design_tables.h"
#include "db/files/safe_file.h"
#include "model/fold/rising_fold.h"

namespace tendril {

void ReadDesignTables(TomlTable& from, TentacleDesign& design) {
  TomlTable tentacle = from.Table("tentacle");
  tentacle.Number("length", design.length, Above(0, "m"));
  tentacle.Number("base_width", design.base_width, Above(0, "m"));
  tentacle.Number("taper", design.taper, Above(0));
  tentacle.Number("unit_length", design.unit_length, Above(0, "m"));
  tentacle.Number("spacing_ratio", design.spacing_ratio, Above(0));
  tentacle.Degrees("alpha_deg", design.alpha, Inside(0, 180, "deg"));
  tentacle.Degrees("beta_deg", design.beta, Inside(0, 180, "deg"));
  tentacle.Integer("holes", design.holes, AtLeast(2));
  tentacle.Number("hole_diameter", design.hole_diameter, Above(0, "m"));
  tentacle.Number("thickness", design.thickness, Above(0, "m"));
  tentacle.Number("youngs_modulus", design.youngs_modulus, Above(0, "Pa"));
  const Bounds closing{.low = 0, .high = 90, .low_open = true, .unit = "deg"};
  tentacle.Degrees("closed_angle_deg", design.closed_angle, closing);

  TomlTable crease = from.Table("crease");
  crease.Number("crease_length", design.crease_length, Above(0, "m"));
  crease.Degrees("rest_angle_deg", design.rest_angle, Between(-90, 90, "deg"));
  crease.Number("stiffness_exponent", design.stiffness_exponent);
  crease.Number("stiffness_ratio", design.stiffness_ratio, Above(0));
  std::string law;
  if (crease.Choice("law", law, {"paper", "exact"})) design.law = FoldLawOf(law);

  TomlTable tendon = from.Table("tendon");
  tendon.Number("friction", design.tendon_friction, AtLeast(0));
  tendon.Degrees("wrap_angle_deg", design.wrap_angle, Between(0, 180, "deg"));
  tendon.Number("pull_scale", design.pull_scale, Above(0));
}

std::string DesignTablesToml(const TentacleDesign& design, const std::string& prefix) {
  std::string out = fmt::format("[{}tentacle]\n", prefix);
  const auto line = [&](const char* key, const std::string& value, const char* unit = "") {
    out += fmt::format("{} = {}{}{}\n", key, value, *unit == '\0' ? "" : "  # ", unit);
  };
  line("length", TomlNumber(design.length), "m, cut length");
  line("base_width", TomlNumber(design.base_width), "m");
  line("taper", TomlNumber(design.taper), "tip width / base width");
  line("unit_length", TomlNumber(design.unit_length), "m, b + c");
  line("spacing_ratio", TomlNumber(design.spacing_ratio), "c / b");
  line("alpha_deg", TomlDegrees(design.alpha));
  line("beta_deg", TomlDegrees(design.beta));
  line("holes", std::to_string(design.holes));
  line("hole_diameter", TomlNumber(design.hole_diameter), "m");
  line("thickness", TomlNumber(design.thickness), "m");
  line("youngs_modulus", TomlNumber(design.youngs_modulus), "Pa");
  line("closed_angle_deg", TomlDegrees(design.closed_angle), "phi_max");
  out += fmt::format("\n[{}crease]\n", prefix);
  line("crease_length", TomlNumber(design.crease_length), "m");
  line("rest_angle_deg", TomlDegrees(design.rest_angle));
  line("stiffness_exponent", TomlNumber(design.stiffness_exponent));
  line("stiffness_ratio", TomlNumber(design.stiffness_ratio), "beta creases / alpha creases");
  if (design.law) out += fmt::format("law = \"{}\"  # scenes fold by it\n", NameOf(*design.law));
  out += fmt::format("\n[{}tendon]\n", prefix);
  line("friction", TomlNumber(design.tendon_friction));
  line("wrap_angle_deg", TomlDegrees(design.wrap_angle));
  if (design.pull_scale != 1) {
    line("pull_scale", TomlNumber(design.pull_scale), "real pull / commanded pull, in scenes");
  }
  return out;
}

Result<TentacleDesign> ParseDesign(const std::string& toml, const std::string& name_in_messages) {
  auto document = TomlDocument::Parse(toml, name_in_messages);
  if (!document.ok()) return document.error();
  TentacleDesign design;
  ReadDesignTables(document.value().Root(), design);
  if (Status read = document.value().Finish(); !read.ok()) return read.error();
  return design;
}

Result<TentacleDesign> ReadDesign(const std::filesystem::path& file) {
  const auto text = ReadText(file);
  if (!text.ok()) return text.error();
  return ParseDesign(text.value(), file.string());
}

std::string DesignToml(const TentacleDesign& design) { return DesignTablesToml(design, ""); }

}  // namespace tendril
