#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "db/files/curve_formats.h"
#include "db/files/hdf5_file.h"
#include "db/files/safe_file.h"

namespace tendril {
namespace {

using hdf5::Array;
using hdf5::Handle;

// One curve's datasets while they are read: the first error stays, with its dataset's name.
struct CurveReader {
  hid_t group;
  std::string place;  // "file: /curve/a"
  Status status = Ok{};

  void Fail(const std::string& dataset, const std::string& what) {
    if (status.ok()) {
      status = Error{ErrorKind::kBadInput, fmt::format("{}/{}: {}", place, dataset, what)};
    }
  }

  // The dataset with its shape checked (0: any size); empty if it is absent or wrong.
  Array Read(const std::string& name, const std::vector<hsize_t>& shape, const std::string& units) {
    auto array = hdf5::ReadArray(group, name);
    if (!array.ok()) {
      Fail(name, array.error().message);
      return {};
    }
    const auto& got = array.value().shape;
    bool fits = got.size() == shape.size();
    for (size_t i = 0; fits && i < shape.size(); ++i) fits = shape[i] == kAny || got[i] == shape[i];
    if (!fits) {
      std::vector<std::string> wanted;
      for (const hsize_t n : shape) wanted.push_back(n == kAny ? "any" : std::to_string(n));
      Fail(name, fmt::format("shape [{}]: expected [{}]", fmt::join(got, ", "), fmt::join(wanted, ", ")));
      return {};
    }
    if (!array.value().units.empty() && array.value().units != units) {
      Fail(name, fmt::format("units = '{}': expected '{}'", array.value().units, units));
    }
    return std::move(array).value();
  }

  static constexpr hsize_t kAny = static_cast<hsize_t>(-1);
};

// Rows of a row-major array as columns: frame f of [frames, nodes, 3].
Eigen::Matrix3Xd PointsOf(const Array& array, size_t frame, Eigen::Index nodes) {
  return Eigen::Map<const Eigen::Matrix3Xd>(array.values.data() + frame * static_cast<size_t>(3 * nodes), 3,
                                            nodes);
}

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Frame f of [frames, rows, columns].
Eigen::MatrixXd MatrixOf(const Array& array, size_t frame) {
  const size_t size = array.shape[1] * array.shape[2];
  return Eigen::Map<const RowMajor>(array.values.data() + frame * size,
                                    static_cast<Eigen::Index>(array.shape[1]),
                                    static_cast<Eigen::Index>(array.shape[2]));
}

void CheckPoints(CurveReader& reader, const std::string& name, const Array& array) {
  for (size_t i = 0; i < array.values.size(); ++i) {
    if (!std::isinf(array.values[i])) continue;
    const size_t nodes = array.shape[1];
    return reader.Fail(name, fmt::format("frame {}, node {} is infinite, expected numbers, or NaN where "
                                         "nothing was seen",
                                         i / (3 * nodes), i / 3 % nodes));
  }
}

// Optional datasets of one number per crease and frame.
struct PerCrease {
  const char* name;
  const char* unit;
  std::vector<Eigen::VectorXd> CurveSeries::*values;
};
constexpr PerCrease kPerCrease[] = {{"angle", "rad", &CurveSeries::angle},
                                    {"angle_sigma", "rad", &CurveSeries::angle_sigma},
                                    {"angle_by_pictures", "1", &CurveSeries::angle_by_pictures}};

CurveSeries ReadOne(CurveReader& reader, const std::string& name) {
  CurveSeries series;
  series.name = name;
  const Array points = reader.Read("points", {CurveReader::kAny, CurveReader::kAny, 3}, "m");
  if (!reader.status.ok()) return series;
  const hsize_t frames = points.shape[0];
  const hsize_t nodes = points.shape[1];
  const auto n = static_cast<Eigen::Index>(nodes);
  if (frames > 0 && nodes == 0) reader.Fail("points", "no nodes");
  CheckPoints(reader, "points", points);

  const Array time = reader.Read("time", {frames}, "s");
  for (size_t f = 0; f < time.values.size(); ++f) {
    if (!std::isfinite(time.values[f]) || (f > 0 && time.values[f] < time.values[f - 1])) {
      reader.Fail("time", fmt::format("frame {} = {}: expected a time not before that of the frame before", f,
                                      time.values[f]));
      break;
    }
  }
  Array normals;
  if (hdf5::Has(reader.group, "normals")) {
    normals = reader.Read("normals", {frames, nodes, 3}, "1");
    CheckPoints(reader, "normals", normals);
  }
  Array sigma;
  if (hdf5::Has(reader.group, "sigma")) sigma = reader.Read("sigma", {frames, nodes}, "m");
  for (const double value : sigma.values) {
    if (value < 0) reader.Fail("sigma", fmt::format("{}: expected >= 0 m, or NaN where not seen", value));
  }
  Array interpolated;
  if (hdf5::Has(reader.group, "interpolated")) {
    interpolated = reader.Read("interpolated", {frames, nodes}, "1");
  }
  for (const double value : interpolated.values) {
    if (value != 0 && value != 1) reader.Fail("interpolated", fmt::format("{}: expected 0 or 1", value));
  }
  Array covariance;
  if (hdf5::Has(reader.group, "covariance")) {
    covariance = reader.Read("covariance", {frames, 3 * nodes, CurveReader::kAny}, "m");
  }
  Array turn;
  if (hdf5::Has(reader.group, "turn")) {
    turn = reader.Read("turn", {frames, nodes, CurveReader::kAny}, "rad");
    if (reader.status.ok() && (covariance.shape.empty() || turn.shape[2] < covariance.shape[2])) {
      reader.Fail("turn",
                  fmt::format("{} columns: expected those of covariance ({}) or more", turn.shape[2],
                              covariance.shape.empty() ? "missing" : std::to_string(covariance.shape[2])));
    }
  }
  for (const PerCrease& what : kPerCrease) {
    if (!hdf5::Has(reader.group, what.name)) continue;
    const size_t creases = nodes > 0 ? nodes - 1 : 0;
    const Array values = reader.Read(what.name, {frames, creases}, what.unit);
    for (size_t f = 0; f < frames && reader.status.ok(); ++f) {
      (series.*what.values)
          .emplace_back(Eigen::Map<const Eigen::VectorXd>(values.values.data() + f * creases,
                                                          static_cast<Eigen::Index>(creases)));
    }
  }
  if (!reader.status.ok()) return series;

  series.time = Eigen::Map<const Eigen::VectorXd>(time.values.data(), static_cast<Eigen::Index>(frames));
  for (size_t f = 0; f < frames; ++f) {
    FramedCurve curve;
    curve.points = PointsOf(points, f, n);
    if (!normals.values.empty()) curve.normals = PointsOf(normals, f, n);
    series.curves.push_back(std::move(curve));
    if (!sigma.shape.empty()) {
      series.sigma.emplace_back(Eigen::Map<const Eigen::VectorXd>(sigma.values.data() + f * nodes, n));
    }
    if (!interpolated.shape.empty()) {
      series.interpolated.emplace_back(
          Eigen::Map<const Eigen::VectorXd>(interpolated.values.data() + f * nodes, n).cast<int>());
    }
    if (!covariance.shape.empty()) series.covariance_factor.push_back(MatrixOf(covariance, f));
    if (!turn.shape.empty()) series.turn_factor.push_back(MatrixOf(turn, f));
  }
  return series;
}

// Each frame's columns that belong to its covariance stay at the place they have there, of `rank` columns.
bool WriteTurns(hid_t group, const CurveSeries& series, Eigen::Index rank, hsize_t nodes) {
  if (series.turn_factor.empty()) return true;
  Eigen::Index most = 0;
  for (size_t f = 0; f < series.turn_factor.size(); ++f) {
    most = std::max(most, series.turn_factor[f].cols() - series.covariance_factor[f].cols());
  }
  Array turn{{series.turn_factor.size(), nodes, static_cast<hsize_t>(rank + most)}, {}, "rad"};
  for (size_t f = 0; f < series.turn_factor.size(); ++f) {
    const Eigen::MatrixXd& factor = series.turn_factor[f];
    const Eigen::Index shared = series.covariance_factor[f].cols(), own = factor.cols() - shared;
    RowMajor whole = RowMajor::Zero(factor.rows(), rank + most);
    whole.leftCols(shared) = factor.leftCols(shared);
    whole.middleCols(rank, own) = factor.rightCols(own);
    turn.values.insert(turn.values.end(), whole.data(), whole.data() + whole.size());
  }
  return hdf5::WriteArray(group, "turn", turn, H5T_IEEE_F64LE);
}

bool WriteOne(hid_t group, const CurveSeries& series) {
  const hsize_t frames = series.curves.size();
  const hsize_t nodes = frames == 0 ? 0 : static_cast<hsize_t>(series.curves.front().points.cols());
  const auto append = [](Array& array, const auto& matrix) {
    array.values.insert(array.values.end(), matrix.data(), matrix.data() + matrix.size());
  };
  Array points{{frames, nodes, 3}, {}, "m"};
  Array normals{{frames, nodes, 3}, {}, "1"};
  for (const FramedCurve& curve : series.curves) {
    append(points, curve.points);
    append(normals, curve.normals);
  }
  const Array time{{frames}, {series.time.data(), series.time.data() + series.time.size()}, "s"};
  bool good = hdf5::WriteArray(group, "points", points, H5T_IEEE_F64LE) &&
              hdf5::WriteArray(group, "time", time, H5T_IEEE_F64LE);
  if (!normals.values.empty()) good = good && hdf5::WriteArray(group, "normals", normals, H5T_IEEE_F64LE);
  if (!series.sigma.empty()) {
    Array sigma{{frames, nodes}, {}, "m"};
    for (const Eigen::VectorXd& values : series.sigma) append(sigma, values);
    good = good && hdf5::WriteArray(group, "sigma", sigma, H5T_IEEE_F64LE);
  }
  if (!series.interpolated.empty()) {
    Array interpolated{{frames, nodes}, {}, "1"};
    for (const Eigen::VectorXi& values : series.interpolated) append(interpolated, values);
    good = good && hdf5::WriteArray(group, "interpolated", interpolated, H5T_STD_I8LE);
  }
  if (!series.covariance_factor.empty()) {
    Eigen::Index rank = 0;
    for (const Eigen::MatrixXd& factor : series.covariance_factor) rank = std::max(rank, factor.cols());
    Array covariance{{frames, 3 * nodes, static_cast<hsize_t>(rank)}, {}, "m"};
    for (const Eigen::MatrixXd& factor : series.covariance_factor) {
      // Columns of zeros change no covariance.
      RowMajor whole = Eigen::MatrixXd::Zero(factor.rows(), rank);
      whole.leftCols(factor.cols()) = factor;
      append(covariance, whole);
    }
    good = good && hdf5::WriteArray(group, "covariance", covariance, H5T_IEEE_F64LE) &&
           WriteTurns(group, series, rank, nodes);
  }
  for (const PerCrease& what : kPerCrease) {
    const std::vector<Eigen::VectorXd>& values = series.*what.values;
    if (values.empty()) continue;
    Array array{{frames, static_cast<hsize_t>(values.front().size())}, {}, what.unit};
    for (const Eigen::VectorXd& frame : values) append(array, frame);
    good = good && hdf5::WriteArray(group, what.name, array, H5T_IEEE_F64LE);
  }
  return good;
}

bool WriteAll(hid_t file, std::span<const CurveSeries> curves, std::span<const ObjectSeries> objects,
              const std::string& source) {
  const Handle all = hdf5::MakeGroup(file, "curve");
  bool good = hdf5::WriteText(file, "source", source) && all.ok();
  for (const CurveSeries& series : curves) {
    if (!good) break;
    const Handle group = hdf5::MakeGroup(all.get(), series.name);
    good = group.ok() && hdf5::WriteText(group.get(), "source", source) && WriteOne(group.get(), series);
  }
  return good && (objects.empty() || WriteObjects(file, objects, curves[0].time, source));
}

}  // namespace

Result<std::vector<CurveSeries>> ReadCurvesHdf5(const std::filesystem::path& path) {
  const auto wrong = [&](const std::string& what) {
    return Error{ErrorKind::kBadInput, path.string() + ": " + what};
  };
  const hdf5::Session session;
  const Result<Handle> opened = hdf5::OpenToRead(path);
  if (!opened.ok()) return opened.error();
  const Handle& file = opened.value();
  if (!hdf5::Has(file.get(), "curve")) return wrong("/curve: missing, expected the group of curves");
  const Handle all(H5Gopen2(file.get(), "curve", H5P_DEFAULT), H5Gclose);
  if (!all.ok()) return wrong("/curve: is not a group");
  std::vector<CurveSeries> curves;
  for (const std::string& name : hdf5::GroupNames(all.get())) {
    const Handle group(H5Gopen2(all.get(), name.c_str(), H5P_DEFAULT), H5Gclose);
    CurveReader reader{group.get(), fmt::format("{}: /curve/{}", path.string(), name)};
    curves.push_back(ReadOne(reader, name));
    if (!reader.status.ok()) return reader.status.error();
  }
  if (curves.empty()) return wrong("/curve: holds no curve");
  return curves;
}

Status WriteCurvesHdf5(const std::filesystem::path& path, std::span<const CurveSeries> curves,
                       const std::string& source, std::span<const ObjectSeries> objects) {
  if (curves.empty()) return Error{ErrorKind::kBadInput, path.string() + ": no curve to write"};
  const auto image = hdf5::MakeFile([&](hid_t file) { return WriteAll(file, curves, objects, source); });
  if (!image.ok()) return Error(image.error()).Within(path.string());
  return WriteText(path, image.value());
}

}  // namespace tendril
