#pragma once
// The two formats behind db/files/curve_files.h, which others include instead. Writers expect sizes that
// agree.

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "model/geometry/framed_curve.h"
#include "model/result.h"

namespace tendril {

Result<std::vector<CurveSeries>> ReadCurvesCsv(const std::filesystem::path& file);
Status WriteCurvesCsv(const std::filesystem::path& file, std::span<const CurveSeries> curves);

Result<std::vector<CurveSeries>> ReadCurvesHdf5(const std::filesystem::path& file);
Status WriteCurvesHdf5(const std::filesystem::path& file, std::span<const CurveSeries> curves,
                       const std::string& source);

}  // namespace tendril
