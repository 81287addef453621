// tendril design tags: pages to print a gripper's tags from, and the map of which tag goes where.
#include "cli/design_tags_command.h"

#include <filesystem>
#include <memory>
#include <vector>

#include "capture/rig/tag_layout.h"
#include "capture/rig/tag_sheet.h"
#include "db/files/design_toml.h"
#include "db/files/safe_file.h"

namespace tendril::cli {
namespace {

struct TagsCall {
  std::string design;
  Gripper gripper{.tentacles = 2};
  TagLayoutOptions options;
  double size_mm = 0;
  std::string svg;
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

Status RunTags(const TagsCall& call, Output& out) {
  const auto design = ReadDesign(call.design);
  if (!design.ok()) return design.error();
  TagLayoutOptions options = call.options;
  options.footprint = 1e-3 * call.size_mm;
  const auto layout = LayOutTags(design.value(), call.gripper, options);
  if (!layout.ok()) return Error(layout.error()).Within(call.design);
  const std::vector<TagPlace>& tags = layout.value().tags;
  const auto pages =
      TagSheetSvg(layout.value(), {.title = std::filesystem::path(call.design).stem().string()});
  if (!pages.ok()) return pages.error();

  auto& fields = out.fields();
  fields["design"] = call.design;
  fields["family"] = layout.value().family;
  fields["footprint_m"] = tags.front().footprint;
  auto& list = fields["tags"] = nlohmann::ordered_json::array();
  for (const TagPlace& tag : tags) {
    const Eigen::Vector3d center = tag.corners_in_sheet.rowwise().mean();
    list.push_back({{"id", tag.id},
                    {"tentacle", tag.tentacle},
                    {"facet", tag.facet},
                    {"side", tag.side == TagSide::kOuter ? "outer" : "inner"},
                    {"center_in_sheet_m", {center.x(), center.y(), center.z()}}});
  }
  out.Print("{} tags of {} on {} tentacle{}: ids {} to {}, printed {:.4g} mm wide with the white ring",
            tags.size(), layout.value().family, call.gripper.tentacles,
            call.gripper.tentacles == 1 ? "" : "s", tags.front().id, tags.back().id,
            1e3 * tags.front().footprint);
  if (!call.svg.empty()) {
    const auto names = PageNames(call.svg, pages.value().size());
    for (size_t i = 0; i < names.size(); ++i) {
      if (Status s = WriteText(names[i], pages.value()[i]); !s.ok()) return s;
      out.Print("{}: A4 page {} of {}; print at 100 %", names[i], i + 1, names.size());
    }
    fields["svg"] = names;
  }
  return Ok{};
}

}  // namespace

Command MakeDesignTagsCommand() {
  auto call = std::make_shared<TagsCall>();
  return {
      .path = "design tags",
      .help = "printable tag sheet, and which tag goes on which facet and side",
      .example = "tendril design tags examples/designs/paper.toml --tentacles 2 --svg tags.svg",
      .declare =
          [call](CLI::App& app) {
            app.add_option("design", call->design, "design file (TOML)")->required();
            app.add_option("--tentacles", call->gripper.tentacles, "tentacles of the gripper (count)")
                ->capture_default_str();
            app.add_option("--family", call->options.family, "tag family (name)")->capture_default_str();
            app.add_option(
                   "--size-mm", call->size_mm,
                   "a tag's printed side with its white ring, mm; 0: the largest that fits, at most 8 mm")
                ->capture_default_str();
            app.add_option("--first-id", call->options.first_id, "id of the first tag (number)")
                ->capture_default_str();
            app.add_option("--svg", call->svg,
                           "write A4 pages (file; more than one: file-1.svg, file-2.svg, ...)");
          },
      .run = [call](Output& out) { return RunTags(*call, out); },
  };
}

}  // namespace tendril::cli
