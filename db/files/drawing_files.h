#pragma once
// A cut pattern as files that a plotter's software opens: SVG in millimetres with a group per layer
// (Inkscape's layers), and DXF R12 (AC1009) in millimetres. Layers CUT (outline), HOLE (circles),
// CREASE_M and CREASE_V (mountains and valleys seen from the drawn, outer face: real dash segments, not a
// line style).

#include <filesystem>
#include <string>

#include "model/fold/cut_pattern.h"
#include "model/result.h"

namespace tendril {

//   title  shown by viewers; any text
std::string CutSvg(const CutPattern& pattern, const std::string& title);
std::string CutDxf(const CutPattern& pattern);

// Written beside the target and renamed.   errors  as WriteText
Status WriteCutSvg(const std::filesystem::path& file, const CutPattern& pattern, const std::string& title);
Status WriteCutDxf(const std::filesystem::path& file, const CutPattern& pattern);

}  // namespace tendril
