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
  double hole_diameter = 0;    // of the hole to punch through tags that lie over one, m; 0: not drawn
  std::string title;
};

// One drawing as SVG texts, one per page, or as one PDF. All of it is lines and areas, placed to 0.0014 mm (a
// 256th of a point). Each page has bars of 100 mm along and across to check the printer's scale by, and each
// tag a gray outline to cut along; where all tags are alike, marks at the page's rim carry on the rows and
// columns for a cutter. A tag's top is toward the tip; below it stand its id, tentacle, facet and side
// ("out": the face with normal +x).
//   errors  kBadInput: an unknown family or id; a tag wider than the page
Result<std::vector<std::string>> TagSheetSvg(const TagLayout& layout, const TagSheetOptions& options = {});
Result<std::string> TagSheetPdf(const TagLayout& layout, const TagSheetOptions& options = {});

}  // namespace tendril
