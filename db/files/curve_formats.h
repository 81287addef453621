#pragma once
// The two formats behind db/files/curve_files.h, which others include instead. Writers expect sizes that
// agree.

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "model/geometry/framed_curve.h"
#include "model/objects/object_series.h"
#include "model/result.h"

namespace tendril {

Result<std::vector<CurveSeries>> ReadCurvesCsv(const std::filesystem::path& file);
Status WriteCurvesCsv(const std::filesystem::path& file, std::span<const CurveSeries> curves);

Result<std::vector<CurveSeries>> ReadCurvesHdf5(const std::filesystem::path& file);
Status WriteCurvesHdf5(const std::filesystem::path& file, std::span<const CurveSeries> curves,
                       const std::string& source, std::span<const ObjectSeries> objects);

// `/object` of an open, new file: false once HDF5 says that a write failed.
bool WriteObjects(std::int64_t file, std::span<const ObjectSeries> objects, const Eigen::VectorXd& time,
                  const std::string& source);

}  // namespace tendril
