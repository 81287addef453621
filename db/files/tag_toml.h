#pragma once
// How a gripper's tags are laid out, as a trial's [tags] table or a file of its own says (docs/formats.md):
// what printing, recording and tracking must agree on.

#include <filesystem>
#include <string>

#include "db/files/toml_read.h"
#include "model/result.h"

namespace tendril {

enum class TagSizes { kEqual, kEach };  // all alike; each as large as its facet holds
enum class TagSides { kBoth, kOuter, kInner };
const char* NameOf(TagSides sides);            // "both", "outer", "inner"
TagSides TagSidesOf(const std::string& name);  // the reverse; kBoth of any other name

// As capture's TagLayoutOptions.
struct TagSpec {
  std::string family = "tag36h11";
  double footprint =
      0;  // printed side with the white ring, m; 0: the largest that fits; of kEach: at most this
  int first_id = 0;
  TagSizes sizes = TagSizes::kEqual;
  int every = 1;  // facets 0, every, 2 every, ... carry tags
  TagSides sides = TagSides::kBoth;
  bool over_hole = false;  // a family whose middle is unused may lie over the tendon's hole
};

void ReadTagTable(TomlTable from, TagSpec& tags);

// "[tags]" and its keys; those from `sizes` on only where they are not the default.
std::string TagTableToml(const TagSpec& tags);

// A file with that table alone.
//   errors  kNotFound no such file; kBadInput names file:line, field, value and what was expected, also where
//   the
//           file has no [tags]
Result<TagSpec> ReadTags(const std::filesystem::path& file);

}  // namespace tendril
