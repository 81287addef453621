#pragma once
// Figures of what a lab holds: success rates, centerlines, links over time. SVG or PNG by the file's
// extension.

#include <filesystem>
#include <string>
#include <vector>

#include "db/trial_query.h"
#include "model/geometry/framed_curve.h"
#include "model/result.h"

namespace tendril::cli {

// Success rate with Wilson intervals over the last key (numbers), one series per value of the keys before it.
//   groups  as CountGrasps gives them for one key or more
//   scale   what the last key's values are multiplied by, as for metres shown in mm
Status PlotRates(const std::vector<RateGroup>& groups, const std::string& x_label, double scale,
                 const std::filesystem::path& file);

// Centerlines of one frame in the x-z and the y-z plane: nodes that were seen, nodes that were bridged. A
// line joins the nodes of `truth`, where there is one, else those of the curves themselves.
//   frame  -1: the last
Status PlotCenterlines(const std::vector<CurveSeries>& curves, const std::vector<CurveSeries>* truth,
                       int frame, const std::string& title, const std::filesystem::path& file);

// A tracked trial's object link and self-link over time.
Status PlotLinks(const std::filesystem::path& trial_folder, const std::string& title,
                 const std::filesystem::path& file);

}  // namespace tendril::cli
