#pragma once
// The page of a tracked trial, and the index of several: HTML that is XML as well, all in one file.

#include <string>
#include <vector>

#include "cli/report_facts.h"
#include "cli/report_figures.h"

namespace tendril::cli {

struct PageStill {
  int camera = 0;
  int frame = 0;
  double time = 0;   // s
  std::string why;   // "first frame", ...
  std::string jpeg;  // the file's bytes
  int width_px = 0, height_px = 0;
};

// Every text of the lab is escaped; nothing refers to another file.
std::string PageOf(const TrialFacts& facts, const PageFigures& figures, const std::vector<PageStill>& stills);

// A page that was written, or a trial that has none.
struct IndexRow {
  TrialOverview trial;
  std::string file;      // beside the index; empty: no page
  std::string why_none;  // then
  int frames = 0;
  double seen = 0;             // share of nodes
  double median_sigma = 0;     // of the seen nodes, over all tentacles, m; NaN: none
  double worst_camera_px = 0;  // largest RMS of a camera; NaN: not known
  std::string object_link;     // of the last moment, with its band; empty: none
  std::vector<std::string> remarks;
};
std::string IndexOf(const std::string& lab, const std::vector<IndexRow>& rows);

// The same key figures of one trial's facts; `file` and `why_none` stay empty.
IndexRow KeyFigures(const TrialFacts& facts);

}  // namespace tendril::cli
