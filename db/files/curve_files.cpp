#include "db/files/curve_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "db/files/curve_formats.h"

namespace tendril {
namespace {

enum class Format { kCsv, kHdf5, kUnknown };

Format FormatOf(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".csv") return Format::kCsv;
  if (extension == ".h5" || extension == ".hdf5") return Format::kHdf5;
  return Format::kUnknown;
}

Error UnknownFormat(const std::filesystem::path& file) {
  return Error{ErrorKind::kBadInput, fmt::format("{}: extension '{}': expected .csv, .h5 or .hdf5",
                                                 file.string(), file.extension().string())};
}

bool IsName(const std::string& name) {
  return !name.empty() && name != "." && name != ".." &&
         std::all_of(name.begin(), name.end(),
                     [](char c) {
                       return static_cast<unsigned char>(c) >= 0x20 && c != ',' && c != '/' && c != '\x7f';
                     }) &&
         name.front() != ' ' && name.back() != ' ';
}

// What is wrong with the sizes of a series; empty: nothing.
std::string Disagreement(const CurveSeries& series) {
  const auto frames = static_cast<Eigen::Index>(series.curves.size());
  if (series.time.size() != frames) return fmt::format("{} times for {} frames", series.time.size(), frames);
  if (!series.time.allFinite()) return "a time that is not a number";
  if (frames == 0) return "";
  const Eigen::Index nodes = series.curves.front().points.cols();
  const bool normals = series.curves.front().normals.cols() > 0;
  if (nodes == 0) return "no nodes";
  for (const FramedCurve& curve : series.curves) {
    if (curve.points.cols() != nodes) {
      return fmt::format("{} nodes, after {} in the first frame", curve.points.cols(), nodes);
    }
    if (curve.normals.cols() != (normals ? nodes : 0)) {
      return fmt::format("{} normals for {} nodes", curve.normals.cols(), nodes);
    }
  }
  const auto per_frame = [&](const char* what, size_t count) {
    return count == 0 || count == series.curves.size()
               ? std::string()
               : fmt::format("{} {} entries for {} frames", count, what, frames);
  };
  for (const std::string& problem :
       {per_frame("sigma", series.sigma.size()), per_frame("interpolated", series.interpolated.size()),
        per_frame("covariance", series.covariance_factor.size()), per_frame("angle", series.angle.size()),
        per_frame("angle_sigma", series.angle_sigma.size()),
        per_frame("angle_by_pictures", series.angle_by_pictures.size()),
        per_frame("turn", series.turn_factor.size())}) {
    if (!problem.empty()) return problem;
  }
  for (const auto& sigma : series.sigma) {
    if (sigma.size() != nodes) return fmt::format("{} sigmas for {} nodes", sigma.size(), nodes);
  }
  for (const auto& interpolated : series.interpolated) {
    if (interpolated.size() != nodes) {
      return fmt::format("{} interpolated for {} nodes", interpolated.size(), nodes);
    }
  }
  for (const auto& [what, values] : {std::pair{"angles", &series.angle},
                                     {"sigmas of angles", &series.angle_sigma},
                                     {"shares of angles by pictures", &series.angle_by_pictures}}) {
    for (const Eigen::VectorXd& per_crease : *values) {
      if (per_crease.size() != nodes - 1)
        return fmt::format("{} {} for {} nodes, expected one less", per_crease.size(), what, nodes);
    }
  }
  for (const auto& factor : series.covariance_factor) {
    if (factor.rows() != 3 * nodes) {
      return fmt::format("a covariance factor of {} rows for {} nodes, expected three each", factor.rows(),
                         nodes);
    }
  }
  if (!series.turn_factor.empty() && series.covariance_factor.empty()) return "turns without a covariance";
  for (std::size_t f = 0; f < series.turn_factor.size(); ++f) {
    const Eigen::MatrixXd& turn = series.turn_factor[f];
    if (turn.rows() != nodes || turn.cols() < series.covariance_factor[f].cols()) {
      return fmt::format("turns of {} x {} for {} nodes and a covariance of {} columns", turn.rows(),
                         turn.cols(), nodes, series.covariance_factor[f].cols());
    }
  }
  return "";
}

}  // namespace

Result<std::vector<CurveSeries>> ReadCurves(const std::filesystem::path& file) {
  switch (FormatOf(file)) {
    case Format::kCsv:
      return ReadCurvesCsv(file);
    case Format::kHdf5:
      return ReadCurvesHdf5(file);
    case Format::kUnknown:
      break;
  }
  return UnknownFormat(file);
}

Status WriteCurves(const std::filesystem::path& file, std::span<const CurveSeries> curves,
                   const std::string& source, std::span<const ObjectSeries> objects) {
  std::set<std::string> names;
  for (const CurveSeries& series : curves) {
    if (!IsName(series.name) || !names.insert(series.name).second) {
      return Error{ErrorKind::kBadInput,
                   fmt::format("{}: curve name '{}': expected names that differ, without comma, slash or "
                               "control character",
                               file.string(), series.name)};
    }
    if (const std::string problem = Disagreement(series); !problem.empty()) {
      return Error{ErrorKind::kBadInput,
                   fmt::format("{}: curve '{}' has {}", file.string(), series.name, problem)};
    }
  }
  names.clear();
  for (const ObjectSeries& object : objects) {
    const std::size_t frames = curves.empty() ? 0 : curves.front().curves.size();
    if (!IsName(object.name) || !names.insert(object.name).second) {
      return Error{ErrorKind::kBadInput,
                   fmt::format("{}: object name '{}': expected names that differ, without comma, slash or "
                               "control character",
                               file.string(), object.name)};
    }
    if (object.poses.size() != frames || object.forces.size() != frames) {
      return Error{ErrorKind::kBadInput,
                   fmt::format("{}: object '{}' has {} poses and {} forces for {} frames", file.string(),
                               object.name, object.poses.size(), object.forces.size(), frames)};
    }
  }
  switch (FormatOf(file)) {
    case Format::kCsv:
      return WriteCurvesCsv(file, curves);
    case Format::kHdf5:
      return WriteCurvesHdf5(file, curves, source, objects);
    case Format::kUnknown:
      break;
  }
  return UnknownFormat(file);
}

}  // namespace tendril
