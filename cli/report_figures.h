#pragma once
// The plots of a trial's page.

#include <string>
#include <vector>

#include "cli/report_facts.h"
#include "model/progress.h"
#include "model/result.h"

namespace tendril::cli {

struct PageFigure {
  std::string svg;      // an element
  std::string caption;  // what it shows and how to read it, as text
};

struct PageFigures {
  std::vector<PageFigure> folds;   // crease against time, one per tentacle; none: angles are not known
  std::vector<PageFigure> sights;  // node against time, one per tentacle
  std::vector<PageFigure> seen;    // share of nodes over time
  std::vector<PageFigure> sigma;   // along the tentacle
  std::vector<PageFigure> residuals;
  std::vector<PageFigure> link;
};

//   errors  as FigureForPage; kStopped
Result<PageFigures> DrawPageFigures(const TrialFacts& facts, const Progress& progress = {});

}  // namespace tendril::cli
