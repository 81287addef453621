#include "cli/tags_answer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

namespace tendril::cli {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

std::vector<std::string> UseNames() {
  std::vector<std::string> names;
  for (int i = 0; i < 6; ++i) names.push_back(NameOf(static_cast<TagUse>(i)));
  return names;
}

int Modules(const TagAnswer& answer) { return FamilyOf(answer.layout.family).value().total_width; }

// Tentacle 0's tag on a facet; null where it carries none.
const TagPlace* TagOn(const TagLayout& layout, size_t facet) {
  for (const TagPlace& tag : layout.tags) {
    if (tag.tentacle == 0 && tag.facet == static_cast<int>(facet)) return &tag;
  }
  return nullptr;
}

// Best uses of facet i over all tentacles, in words: "decoded 7, tracked 1".
std::string SeenOn(const TagSight& sight, int facet) {
  std::map<TagUse, int> count;
  for (const FacetSight& f : sight.facets) {
    if (f.facet == facet) ++count[f.best];
  }
  std::string text;
  for (const auto& [use, n] : count) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", NameOf(use), n);
  return text;
}

void PrintFacets(const TagAnswer& answer, Output& out) {
  const bool seen = answer.sight.has_value();
  out.Print("{:>5} {:>9} {:>8} {:>17} {:>8} {:>8} {:>7}  {}", "facet", "length mm", "width mm",
            "hole to creases", "fits mm", "over it", "tag mm", seen ? "best view of each tentacle's" : "");
  auto& list = out.fields()["facets"];
  list = nlohmann::ordered_json::array();
  for (size_t i = 0; i < answer.rooms.size(); ++i) {
    const FacetRoom& room = answer.rooms[i];
    const TagPlace* tag = TagOn(answer.layout, i);
    const std::string view = seen && tag != nullptr ? SeenOn(*answer.sight, static_cast<int>(i)) : "";
    out.Print("{:>5} {:>9.2f} {:>8.2f} {:>8.2f} {:>8.2f} {:>8.2f} {:>8.2f} {:>7}  {}", i, 1e3 * room.length,
              1e3 * room.width, 1e3 * room.before_hole, 1e3 * room.beyond_hole, 1e3 * room.largest_beside,
              1e3 * room.largest_over,
              tag == nullptr ? "-" : fmt::format("{:.2f}{}", 1e3 * tag->footprint, tag->over_hole ? "*" : ""),
              view);
    list.push_back(
        {{"facet", i},
         {"length_m", room.length},
         {"width_m", room.width},
         {"hole_to_base_crease_m", room.before_hole},
         {"hole_to_tip_crease_m", room.beyond_hole},
         {"largest_beside_hole_m", room.largest_beside},
         {"largest_over_hole_m", room.largest_over},
         {"tag_m", tag == nullptr ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(tag->footprint)},
         {"over_hole", tag != nullptr && tag->over_hole}});
  }
}

void PrintFamily(const TagAnswer& answer, Output& out) {
  if (!answer.choice) return;
  out.Print("family    {}", answer.choice->why);
  out.fields()["family_why"] = answer.choice->why;
  auto& list = out.fields()["families"] = nlohmann::ordered_json::array();
  for (const FamilyOption& option : answer.choice->options) {
    list.push_back({{"family", option.family.name},
                    {"ids", option.family.ids},
                    {"modules", option.family.total_width},
                    {"tags_needed", option.tags},
                    {"module_m", option.module},
                    {"dark_border", !option.family.reversed_border},
                    {"false_tag_share", option.false_tags},
                    {"enough_ids", option.enough_ids}});
  }
}

void PrintCameras(const TagAnswer& answer, Output& out) {
  if (!answer.sight) return;
  const int modules = Modules(answer);
  const std::vector<std::string> names = UseNames();
  out.Print("");
  out.Print("{:<10} {:>14} {:>14} {:>10} {:>10} {:>10}  {}", "camera", "mm per px", "px per module",
            "frontal", "at 45 deg", "at 60 deg", "tags of the straight gripper");
  auto& list = out.fields()["cameras"] = nlohmann::ordered_json::array();
  for (const CameraSight& camera : answer.sight->cameras) {
    std::string counts;
    nlohmann::ordered_json count;
    for (size_t use = 0; use < names.size(); ++use) {
      count[names[use]] = camera.count[use];
      if (camera.count[use] > 0) {
        counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", names[use], camera.count[use]);
      }
    }
    std::array<std::string, 3> use;
    for (size_t i = 0; i < 3; ++i) {
      use[i] = std::isfinite(camera.least_module_px)
                   ? NameOf(UseOf(camera.least_module_px, modules, std::array{0.0, 45.0, 60.0}[i] * kDegree))
                   : "-";
    }
    out.Print("{:<10} {:>14} {:>14} {:>10} {:>10} {:>10}  {}", camera.name,
              fmt::format("{:.3f} .. {:.3f}", 1e3 * camera.nearest_m_per_px, 1e3 * camera.farthest_m_per_px),
              fmt::format("{:.2f} .. {:.2f}", camera.least_module_px, camera.largest_module_px), use[0],
              use[1], use[2], counts);
    list.push_back(
        {{"name", camera.name},
         {"nearest_mm_per_px", NumberOrNull(1e3 * camera.nearest_m_per_px)},
         {"farthest_mm_per_px", NumberOrNull(1e3 * camera.farthest_m_per_px)},
         {"least_px_per_module", NumberOrNull(camera.least_module_px)},
         {"largest_px_per_module", NumberOrNull(camera.largest_module_px)},
         {"px_per_module_at_45_deg", NumberOrNull(camera.least_module_px * std::cos(45 * kDegree))},
         {"use_frontal", use[0]},
         {"use_at_45_deg", use[1]},
         {"use_at_60_deg", use[2]},
         {"tags", count}});
  }
  out.Print(
      "(px per module as if seen frontally, of the smallest and largest tag; uses of the smallest. decoded: "
      "its "
      "id is read in nearly every picture; tracked: read now and then, and followed in between; unsure: not "
      "to be "
      "counted on)");
  out.fields()["widest_angle_deg"] = answer.sight->widest_angle / kDegree;
  auto& views = out.fields()["views"] = nlohmann::ordered_json::array();
  for (const TagOutlook& view : answer.sight->views) {
    views.push_back({{"id", answer.layout.tags[view.tag].id},
                     {"camera", answer.sight->cameras[view.camera].name},
                     {"use", NameOf(view.use)},
                     {"tilt_deg", view.tilt / kDegree},
                     {"px_per_module", NumberOrNull(view.module_px)},
                     {"least_px_per_module", NumberOrNull(view.least_module_px)}});
  }
}

void PrintAlternatives(const TagAnswer& answer, Output& out) {
  out.Print("");
  out.Print("{:<8} {:<6} {:>6} {:>12}  {}", "every", "sides", "tags", "mass added",
            answer.sight ? "facets of the straight gripper seen (by two cameras)" : "");
  auto& list = out.fields()["alternatives"] = nlohmann::ordered_json::array();
  for (const TagAlternative& other : answer.alternatives) {
    const bool chosen = other.every == answer.options.every && other.sides == answer.options.sides;
    out.Print("{:<8} {:<6} {:>6} {:>10.1f} %  {}{}", other.every, NameOf(other.sides), other.tags,
              100 * other.mass_share,
              answer.sight
                  ? fmt::format("{:.0f} % ({:.0f} %)", 100 * other.facets_seen, 100 * other.facets_twice)
                  : "",
              chosen ? "  <- this layout" : "");
    list.push_back({{"every", other.every},
                    {"sides", NameOf(other.sides)},
                    {"tags", other.tags},
                    {"mass_share", other.mass_share},
                    {"facets_seen", NumberOrNull(other.facets_seen)},
                    {"facets_seen_twice", NumberOrNull(other.facets_twice)}});
  }
}

void PrintWeight(const TagAnswer& answer, Output& out) {
  const TagWeight& w = answer.weight;
  out.Print("");
  out.Print(
      "mass      tags add {:.2f} g to a tentacle of {:.2f} g of film ({:.0f} %), at {:.0f} g/m^2 of label "
      "with "
      "adhesive and {:.0f} kg/m^3 of film (assumed)",
      1e3 * w.tag_mass, 1e3 * w.film_mass, 100 * w.tag_mass / w.film_mass,
      1e3 * answer.material.label_grammage, answer.material.film_density);
  const bool both = answer.options.sides == TagSides::kBoth;
  out.Print(
      "stiffness film {:.2g} N mm, a label of {:.2f} mm and {:.2g} GPa (assumed) {:.2g} N mm, per mm of "
      "width; "
      "under {} a facet is {:.0f} times as stiff",
      1e3 * w.film_stiffness, 1e3 * w.label_thickness, 1e-9 * answer.material.label_modulus,
      1e3 * w.label_stiffness, both ? "tags on both sides" : "a tag", both ? w.both_sides : w.one_side);
  out.Print(
      "          a crease in the middle has {:.2g} N mm/rad; tags keep {:.2g} mm off the creases, for one "
      "glued "
      "across would make that {:.2g} N mm/rad",
      1e3 * w.crease, 1e3 * answer.options.clearance, 1e3 * w.crease * w.one_side);
  out.fields()["weight"] = {{"film_mass_g", 1e3 * w.film_mass},
                            {"tag_mass_g", 1e3 * w.tag_mass},
                            {"mass_share", w.tag_mass / w.film_mass},
                            {"label_grammage_g_per_m2", 1e3 * answer.material.label_grammage},
                            {"label_density_kg_per_m3", answer.material.label_density},
                            {"label_modulus_Pa", answer.material.label_modulus},
                            {"film_density_kg_per_m3", answer.material.film_density},
                            {"label_thickness_m", w.label_thickness},
                            {"film_stiffness_Nm", w.film_stiffness},
                            {"label_stiffness_Nm", w.label_stiffness},
                            {"stiffness_ratio_one_side", w.one_side},
                            {"stiffness_ratio_both_sides", w.both_sides},
                            {"crease_stiffness_Nm_per_rad", w.crease},
                            {"facet_stiffness_Nm_per_rad", w.facet}};
}

}  // namespace

void PrintTagAnswer(const TagAnswer& answer, Output& out) {
  PrintFacets(answer, out);
  PrintCameras(answer, out);
  PrintAlternatives(answer, out);
  PrintWeight(answer, out);
  PrintFamily(answer, out);
  if (!answer.options.over_hole) {
    const TagFamily holed = FamilyOf("tagCustom48h12").value();
    const double void_share = static_cast<double>(holed.void_width) / holed.total_width;
    int larger = 0;
    double over = 1e9;
    for (const FacetRoom& room : answer.rooms) {
      if (void_share * room.largest_over < answer.design.hole_diameter ||
          room.largest_over < 1.25 * room.largest_beside)
        continue;
      ++larger;
      over = std::min(over, room.largest_over);
    }
    if (2 * larger > static_cast<int>(answer.rooms.size())) {
      out.Print(
          "hint      over its hole a tag of tagCustom48h12 could be {:.3g} mm wide on {} of {} facets: "
          "--over-hole",
          1e3 * over, larger, answer.rooms.size());
    }
  }
  const double smallest = 1e3 * SmallestFootprint(answer.layout);
  const double largest = 1e3 * LargestFootprint(answer.layout);
  out.Print("tags      {} of {} on {} tentacle{}: ids {} to {}, printed {} mm wide with the white ring",
            answer.layout.tags.size(), answer.layout.family, answer.gripper.tentacles,
            answer.gripper.tentacles == 1 ? "" : "s", answer.layout.tags.front().id,
            answer.layout.tags.back().id,
            largest - smallest < 0.005 ? fmt::format("{:.4g}", largest)
                                       : fmt::format("{:.3g} to {:.3g}", smallest, largest));
}

std::vector<std::string> TagWarnings(const TagAnswer& answer) {
  std::vector<std::string> warnings;
  const int modules = Modules(answer);
  if (answer.sight) {
    const TagSight& sight = *answer.sight;
    std::string unread;
    for (const CameraSight& camera : sight.cameras) {
      if (!(camera.least_module_px > 0)) {
        warnings.push_back(
            fmt::format("camera {} has no tag before it: its pose in the rig file is not the gripper's, or "
                        "looks elsewhere",
                        camera.name));
      } else if (camera.least_module_px < DecodeLimitPx(0)) {
        unread += fmt::format("{}{} ({:.2f} px per module, {:.3f} mm per px)", unread.empty() ? "" : ", ",
                              camera.name, camera.least_module_px, 1e3 * camera.farthest_m_per_px);
      }
    }
    if (!unread.empty()) {
      warnings.push_back(
          fmt::format("tags fall below the decode limit of 2 px per module even frontally in {}: come "
                      "nearer, take a longer lens, or "
                      "make {:.3g} mm tags larger",
                      unread, 1e3 * SmallestFootprint(answer.layout)));
    }
    std::map<int, int> nowhere;
    int count = 0;
    for (const FacetSight& facet : sight.facets) {
      if (facet.best <= TagUse::kTracked) continue;
      ++nowhere[facet.tentacle];
      ++count;
    }
    if (count > 0) {
      std::string where;
      for (const auto& [tentacle, n] : nowhere) {
        where += fmt::format("{}{} of tentacle {}", where.empty() ? "" : ", ", n, tentacle);
      }
      warnings.push_back(
          fmt::format("{} of {} tagged facets are neither decoded nor tracked by any camera while the "
                      "gripper hangs straight: {}",
                      count, sight.facets.size(), where));
    }
    if (sight.cameras.size() == 1) {
      warnings.push_back(
          "one camera: a small tag's tilt and depth are not to be had from it alone; take two, about 60 "
          "degrees apart");
    } else if (sight.widest_angle < 20 * kDegree || sight.widest_angle > 160 * kDegree) {
      warnings.push_back(
          fmt::format("the cameras look along almost one line ({:.0f} degrees between them): depth will be "
                      "uncertain; about 60 degrees do well",
                      sight.widest_angle / kDegree));
    }
  } else if (SmallestFootprint(answer.layout) < 0.005) {
    warnings.push_back(
        fmt::format("the smallest tag is {:.3g} mm wide: it needs {:.3g} mm per px or finer to be decoded "
                    "frontally (--rig tells what the cameras have)",
                    1e3 * SmallestFootprint(answer.layout),
                    1e3 * SmallestFootprint(answer.layout) / (modules * DecodeLimitPx(0))));
  }
  const auto family = FamilyOf(answer.layout.family).value();
  const int left = family.ids - answer.layout.tags.back().id - 1;
  if (left < static_cast<int>(answer.layout.tags.size()) / answer.gripper.tentacles) {
    warnings.push_back(
        fmt::format("{} ids of {} are left: not enough for one more tentacle", left, family.name));
  }
  const auto bare =
      static_cast<size_t>(std::count_if(answer.rooms.begin(), answer.rooms.end(), [&](const auto& room) {
        const auto i = static_cast<size_t>(&room - answer.rooms.data());
        return i % static_cast<size_t>(answer.options.every) == 0 && TagOn(answer.layout, i) == nullptr;
      }));
  if (bare > 0) {
    warnings.push_back(
        fmt::format("{} facets of a tentacle hold no tag of {:.3g} mm and carry none: only sums of folds "
                    "are seen there",
                    bare, 1e3 * answer.options.smallest_footprint));
  }
  int over = 0;
  for (const TagPlace& tag : answer.layout.tags) over += tag.over_hole ? 1 : 0;
  if (over > 0) {
    warnings.push_back(
        fmt::format("{} tags lie over their tendon holes: punch the hole of {:.3g} mm, drawn in gray, "
                    "through each before it is glued",
                    over, 1e3 * answer.design.hole_diameter));
  }
  const double share = answer.weight.tag_mass / answer.weight.film_mass;
  if (share > 0.1) {
    warnings.push_back(
        fmt::format("the tags weigh {:.0f} % of the film: a tagged tentacle sags and swings otherwise than a "
                    "bare one; --every 2, --sides or a lighter label cut that",
                    100 * share));
  }
  return warnings;
}

}  // namespace tendril::cli
