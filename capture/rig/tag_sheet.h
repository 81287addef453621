#pragma once
// Pages to print tags from: every tag of a layout at its true size, with what it is and where it goes.

#include <string>
#include <vector>

#include "capture/rig/tag_layout.h"
#include "model/result.h"

namespace tendril {

struct TagSheetOptions {
  double page_width = 0.210;   // m; A4
  double page_height = 0.297;  // m
  double margin = 0.010;       // m
  std::string title;
};

// SVG texts, one per page, in millimetres. Each page has a bar of 100 mm to check the printer's scale by. A
// tag's top is toward the tip; below it stand its id, tentacle, facet and side ("out": the face with normal
// +x).
//   errors  kBadInput: an unknown family or id; a tag wider than the page
Result<std::vector<std::string>> TagSheet(const TagLayout& layout, const TagSheetOptions& options = {});

}  // namespace tendril
