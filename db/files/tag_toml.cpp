#include "db/files/tag_toml.h"

#include <fmt/format.h>

#include "db/files/toml_write.h"

namespace tendril {

const char* NameOf(TagSides sides) {
  return sides == TagSides::kOuter ? "outer" : sides == TagSides::kInner ? "inner" : "both";
}
TagSides TagSidesOf(const std::string& name) {
  return name == "outer" ? TagSides::kOuter : name == "inner" ? TagSides::kInner : TagSides::kBoth;
}

void ReadTagTable(TomlTable from, TagSpec& tags) {
  from.Text("family", tags.family);
  from.Number("footprint", tags.footprint, AtLeast(0, "m"));
  from.Integer("first_id", tags.first_id, AtLeast(0));
  std::string name;
  if (from.Choice("sizes", name, {"equal", "each"})) {
    tags.sizes = name == "each" ? TagSizes::kEach : TagSizes::kEqual;
  }
  from.Integer("every", tags.every, AtLeast(1, "facets"));
  if (from.Choice("sides", name, {"both", "outer", "inner"})) tags.sides = TagSidesOf(name);
  from.Flag("over_hole", tags.over_hole);
}

std::string TagTableToml(const TagSpec& tags) {
  std::string out =
      fmt::format("[tags]\nfamily = {}\nfootprint = {}  # m; 0: the largest that fits\nfirst_id = {}\n",
                  TomlText(tags.family), TomlNumber(tags.footprint), tags.first_id);
  if (tags.sizes == TagSizes::kEach) out += "sizes = \"each\"  # as large as its facet holds\n";
  if (tags.every != 1) out += fmt::format("every = {}  # facets\n", tags.every);
  if (tags.sides != TagSides::kBoth) out += fmt::format("sides = {}\n", TomlText(NameOf(tags.sides)));
  if (tags.over_hole) out += "over_hole = true\n";
  return out;
}

Result<TagSpec> ReadTags(const std::filesystem::path& file) {
  auto document = TomlDocument::Read(file);
  if (!document.ok()) return document.error();
  TagSpec tags;
  ReadTagTable(document.value().Root().Required().Table("tags"), tags);
  if (Status read = document.value().Finish(); !read.ok()) return read.error();
  return tags;
}

}  // namespace tendril
