// tendril design tags: which tags suit a design and the cameras, pages to print them from, and the map of
// which tag goes where.
#include "cli/design_tags_command.h"

#include <algorithm>
#include <filesystem>
#include <limits>
#include <memory>
#include <numbers>
#include <set>
#include <vector>

#include "capture/rig/tag_sheet.h"
#include "cli/tags_answer.h"
#include "db/files/design_toml.h"
#include "db/files/safe_file.h"
#include "db/files/trial_toml.h"

namespace tendril::cli {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

struct TagsCall {
  std::string design;
  std::string rig;
  Gripper gripper{.tentacles = 2};
  std::string handedness = "mirror";
  double first_azimuth_deg = 22.5;
  double tilt_deg = 5;
  TagSpec tags{.family = ""};
  std::string sizes = "equal";
  std::string sides = "both";
  double size_mm = 0;
  double label_gsm = 100;
  std::string svg;
  std::string pdf;
  std::string table;
};

// sheet.svg where one page is enough, else sheet-1.svg, sheet-2.svg, ...
std::vector<std::string> PageNames(const std::string& svg, size_t pages) {
  if (pages == 1) return {svg};
  const std::filesystem::path file(svg);
  std::vector<std::string> names;
  for (size_t i = 1; i <= pages; ++i) {
    names.push_back(
        (file.parent_path() / fmt::format("{}-{}{}", file.stem().string(), i, file.extension().string()))
            .string());
  }
  return names;
}

// Which facets and sides else, and what that would give.
Result<std::vector<TagAlternative>> AlternativesOf(const TagAnswer& answer, const Rig* rig) {
  std::vector<TagAlternative> all;
  const int tentacles = answer.gripper.tentacles;
  std::set<int> every = {1, 2, 3, answer.options.every};
  for (const int n : every) {
    for (const TagSides sides : {TagSides::kBoth, TagSides::kOuter, TagSides::kInner}) {
      TagLayoutOptions options = answer.options;
      options.every = n;
      options.sides = sides;
      // More tags than this family has ids: counted all the same, with one that has them.
      options.first_id = 0;
      auto layout = LayOutTags(answer.design, answer.gripper, options);
      if (!layout.ok()) {
        options.family = options.over_hole ? options.family : "tagStandard52h13";
        layout = LayOutTags(answer.design, answer.gripper, options);
      }
      if (!layout.ok()) continue;
      const auto weight = WeighTags(answer.design, layout.value(), answer.material);
      if (!weight.ok()) return weight.error();
      TagAlternative other{.every = n,
                           .sides = sides,
                           .tags = static_cast<int>(layout.value().tags.size()),
                           .mass_share = weight.value().tag_mass / weight.value().film_mass,
                           .facets_seen = std::numeric_limits<double>::quiet_NaN(),
                           .facets_twice = std::numeric_limits<double>::quiet_NaN()};
      if (rig != nullptr) {
        const auto sight = SeeTags(answer.design, answer.gripper, layout.value(), *rig);
        if (!sight.ok()) return sight.error();
        double seen = 0;
        double twice = 0;
        for (const FacetSight& facet : sight.value().facets) {
          seen += facet.cameras >= 1 ? 1 : 0;
          twice += facet.cameras >= 2 ? 1 : 0;
        }
        const double facets = static_cast<double>(answer.design.holes) * tentacles;
        other.facets_seen = seen / facets;
        other.facets_twice = twice / facets;
      }
      all.push_back(other);
    }
  }
  return all;
}

Result<TagAnswer> AnswerOf(const TagsCall& call, TagSpec& tags, const Rig* rig) {
  TagAnswer answer;
  const auto design = ReadDesign(call.design);
  if (!design.ok()) return design.error();
  answer.design = design.value();
  answer.gripper = call.gripper;
  answer.gripper.first_azimuth = call.first_azimuth_deg * kDegree;
  answer.gripper.tilt = call.tilt_deg * kDegree;
  answer.gripper.handedness = HandednessOf(call.handedness).value_or(Handedness::kMirror);
  answer.options = LayoutOptionsOf(tags);
  if (tags.family.empty()) {
    std::optional<double> finest;
    if (rig != nullptr) {
      TagLayoutOptions any = answer.options;
      any.family = any.over_hole ? "tagCustom48h12" : "tagStandard52h13";
      const auto layout = LayOutTags(answer.design, answer.gripper, any);
      if (!layout.ok()) return Error(layout.error()).Within(call.design);
      const auto sight = SeeTags(answer.design, answer.gripper, layout.value(), *rig);
      if (!sight.ok()) return sight.error();
      for (const CameraSight& camera : sight.value().cameras) {
        if (camera.farthest_m_per_px > 0) finest = std::min(finest.value_or(1e9), camera.farthest_m_per_px);
      }
    }
    auto choice = ChooseFamily(answer.design, answer.gripper, answer.options, finest);
    if (!choice.ok()) return Error(choice.error()).Within(call.design);
    answer.choice = std::move(choice).value();
    tags.family = answer.choice->family;
    answer.options.family = tags.family;
    // Another family than the one that could have lain over holes.
    tags.over_hole = answer.options.over_hole =
        answer.options.over_hole && FamilyOf(tags.family).value().void_width > 0;
  }
  auto layout = LayOutTags(answer.design, answer.gripper, answer.options);
  if (!layout.ok()) return Error(layout.error()).Within(call.design);
  answer.layout = std::move(layout).value();
  const auto sheet = LayOut(DesignOfTentacle(answer.gripper, answer.design, 0));
  if (!sheet.ok()) return Error(sheet.error()).Within(call.design);
  answer.rooms = RoomsOf(answer.design, sheet.value(), answer.options.clearance);
  if (rig != nullptr) {
    auto sight = SeeTags(answer.design, answer.gripper, answer.layout, *rig);
    if (!sight.ok()) return sight.error();
    answer.sight = std::move(sight).value();
  }
  answer.material.label_grammage = 1e-3 * call.label_gsm;
  const auto weight = WeighTags(answer.design, answer.layout, answer.material);
  if (!weight.ok()) return weight.error();
  answer.weight = weight.value();
  auto others = AlternativesOf(answer, rig);
  if (!others.ok()) return others.error();
  answer.alternatives = std::move(others).value();
  return answer;
}

Status WriteFiles(const TagsCall& call, const TagSpec& tags, const TagAnswer& answer, Output& out) {
  const TagSheetOptions sheet{.hole_diameter = answer.design.hole_diameter,
                              .title = std::filesystem::path(call.design).stem().string()};
  if (!call.svg.empty()) {
    const auto pages = TagSheetSvg(answer.layout, sheet);
    if (!pages.ok()) return pages.error();
    const auto names = PageNames(call.svg, pages.value().size());
    for (size_t i = 0; i < names.size(); ++i) {
      if (Status s = WriteText(names[i], pages.value()[i]); !s.ok()) return s;
      out.Print("{}: A4 page {} of {}; print at 100 %", names[i], i + 1, names.size());
    }
    out.fields()["svg"] = names;
  }
  if (!call.pdf.empty()) {
    const auto pages = TagSheetPdf(answer.layout, sheet);
    if (!pages.ok()) return pages.error();
    if (Status s = WriteText(call.pdf, pages.value()); !s.ok()) return s;
    out.Print("{}: A4; print at 100 %", call.pdf);
    out.fields()["pdf"] = call.pdf;
  }
  if (!call.table.empty()) {
    if (Status s = WriteText(call.table, TagTableToml(tags)); !s.ok()) return s;
    out.Print("{}: give it to `tendril record --tags {}`", call.table, call.table);
    out.fields()["out"] = call.table;
  } else if (TagTableToml(tags) != TagTableToml({})) {
    out.Warn(
        "`record` takes tag36h11 of equal size on every facet and side unless told: keep this layout with "
        "--out FILE "
        "and record with --tags FILE");
  }
  return Ok{};
}

Status RunTags(const TagsCall& call, Output& out) {
  TagSpec tags = call.tags;
  tags.footprint = 1e-3 * call.size_mm;
  tags.sizes = call.sizes == "each" ? TagSizes::kEach : TagSizes::kEqual;
  tags.sides = TagSidesOf(call.sides);
  std::optional<Rig> rig;
  if (!call.rig.empty()) {
    auto read = ReadRig(call.rig);
    if (!read.ok()) return read.error();
    if (read.value().cameras.empty()) {
      return Error{ErrorKind::kBadInput, call.rig + ": the rig has no camera; expected one or more"};
    }
    rig = std::move(read).value();
  }
  const auto made = AnswerOf(call, tags, rig ? &*rig : nullptr);
  if (!made.ok()) return made.error();
  const TagAnswer& answer = made.value();

  auto& fields = out.fields();
  fields["design"] = call.design;
  fields["family"] = answer.layout.family;
  fields["footprint_m"] = SmallestFootprint(answer.layout);
  auto& list = fields["tags"] = nlohmann::ordered_json::array();
  for (const TagPlace& tag : answer.layout.tags) {
    const Eigen::Vector3d center = tag.corners_in_sheet.rowwise().mean();
    list.push_back({{"id", tag.id},
                    {"tentacle", tag.tentacle},
                    {"facet", tag.facet},
                    {"side", tag.side == TagSide::kOuter ? "outer" : "inner"},
                    {"footprint_m", tag.footprint},
                    {"over_hole", tag.over_hole},
                    {"center_in_sheet_m", {center.x(), center.y(), center.z()}}});
  }
  PrintTagAnswer(answer, out);
  for (const std::string& warning : TagWarnings(answer)) out.Warn(warning);
  return WriteFiles(call, tags, answer, out);
}

void DeclareGripper(CLI::App& app, TagsCall& call) {
  app.add_option("--tentacles", call.gripper.tentacles, "tentacles of the gripper (count)")
      ->capture_default_str();
  app.add_option("--handedness", call.handedness, "of neighbouring tentacles")
      ->check(CLI::IsMember({"mirror", "normals", "same"}))
      ->capture_default_str();
  app.add_option("--rig", call.rig, "rig file (TOML): what its cameras would see of the tags");
  app.add_option("--carrier-radius", call.gripper.carrier_radius,
                 "with --rig: of the circle of holes 0, metres")
      ->capture_default_str();
  app.add_option("--first-azimuth-deg", call.first_azimuth_deg,
                 "with --rig: of tentacle 0 about z, degrees from x")
      ->capture_default_str();
  app.add_option("--tilt-deg", call.tilt_deg, "with --rig: of the tentacles toward the axis, degrees")
      ->capture_default_str();
}

void DeclareTags(CLI::App& app, TagsCall& call) {
  app.add_option("--family", call.tags.family,
                 "tag family (name); left out: the one that suits best, and why");
  app.add_option("--size-mm", call.size_mm,
                 "a tag's printed side with its white ring, mm; 0: the largest that fits, at most 8 mm; with "
                 "--sizes each: "
                 "at most this, 0: as large as the facet holds")
      ->capture_default_str();
  app.add_option("--sizes", call.sizes, "equal, or each as large as its facet holds")
      ->check(CLI::IsMember({"equal", "each"}))
      ->capture_default_str();
  app.add_option("--every", call.tags.every, "tags on facets 0, n, 2n, ... (number)")->capture_default_str();
  app.add_option("--sides", call.sides, "which faces carry tags")
      ->check(CLI::IsMember({"both", "outer", "inner"}))
      ->capture_default_str();
  app.add_flag(
      "--over-hole", call.tags.over_hole,
      "tags with an unused middle (tagCustom48h12) may lie over the tendon's hole where it is wide enough");
  app.add_option("--first-id", call.tags.first_id, "id of the first tag (number)")->capture_default_str();
  app.add_option("--label-gsm", call.label_gsm, "the printed label with its adhesive, g/m^2")
      ->capture_default_str();
}

}  // namespace

Command MakeDesignTagsCommand() {
  auto call = std::make_shared<TagsCall>();
  return {
      .path = "design tags",
      .help = "tags for a design and its cameras: family, sizes, what is seen; sheets to print",
      .example =
          "tendril design tags examples/designs/paper.toml --rig examples/rigs/two_cameras.toml --pdf "
          "tags.pdf",
      .declare =
          [call](CLI::App& app) {
            app.add_option("design", call->design, "design file (TOML)")->required();
            DeclareGripper(app, *call);
            DeclareTags(app, *call);
            app.add_option("--svg", call->svg,
                           "write A4 pages (file; more than one: file-1.svg, file-2.svg, ...)");
            app.add_option("--pdf", call->pdf, "write A4 pages (file)");
            app.add_option("--out", call->table, "write the layout for `record --tags` (file, TOML)");
          },
      .run = [call](Output& out) { return RunTags(*call, out); },
  };
}

}  // namespace tendril::cli
