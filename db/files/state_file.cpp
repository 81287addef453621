#include "db/files/state_file.h"

#include <Eigen/Core>

#include "db/files/hdf5_file.h"
#include "db/files/safe_file.h"

namespace tendril {
namespace {

using Eigen::Index;

hdf5::Array Flat(const std::vector<double>& values) { return {{values.size()}, values, ""}; }

// Frames, nodes, and x y z of node and normal.
hdf5::Array CurvesAsArray(const CurveSeries& series) {
  hdf5::Array array;
  const Index nodes = series.curves.empty() ? 0 : series.curves[0].points.cols();
  array.shape = {series.curves.size(), static_cast<hsize_t>(nodes), 6};
  for (const FramedCurve& curve : series.curves) {
    for (Index i = 0; i < nodes; ++i) {
      for (Index k = 0; k < 3; ++k) array.values.push_back(curve.points(k, i));
      for (Index k = 0; k < 3; ++k) array.values.push_back(curve.normals(k, i));
    }
  }
  return array;
}

std::vector<FramedCurve> CurvesOfArray(const hdf5::Array& array) {
  std::vector<FramedCurve> curves;
  const auto nodes = static_cast<Index>(array.shape[1]);
  const double* from = array.values.data();
  for (hsize_t f = 0; f < array.shape[0]; ++f) {
    FramedCurve& curve = curves.emplace_back();
    curve.points.resize(3, nodes);
    curve.normals.resize(3, nodes);
    for (Index i = 0; i < nodes; ++i, from += 6) {
      curve.points.col(i) = Eigen::Map<const Eigen::Vector3d>(from);
      curve.normals.col(i) = Eigen::Map<const Eigen::Vector3d>(from + 3);
    }
  }
  return curves;
}

std::string NameOfCurves(std::size_t rod) { return "curves_" + std::to_string(rod); }

}  // namespace

Status WriteState(const std::filesystem::path& file, const SimulationState& state, const std::string& run) {
  // The hash as numbers: a dataset of its own, read like the rest.
  std::vector<double> run_numbers(run.begin(), run.end());
  const Result<std::string> bytes = hdf5::MakeFile([&](hid_t out) {
    bool good = hdf5::WriteArray(out, "run", Flat(run_numbers), H5T_IEEE_F64LE) &&
                hdf5::WriteArray(out, "numbers", Flat(state.numbers), H5T_IEEE_F64LE);
    if (state.curves.empty() || state.curves[0].curves.empty()) return good;
    const Eigen::VectorXd& time = state.curves[0].time;
    good = good && hdf5::WriteArray(out, "time", Flat({time.begin(), time.end()}), H5T_IEEE_F64LE);
    for (std::size_t r = 0; good && r < state.curves.size(); ++r) {
      good = hdf5::WriteArray(out, NameOfCurves(r), CurvesAsArray(state.curves[r]), H5T_IEEE_F64LE);
    }
    return good;
  });
  if (!bytes.ok()) return Error(bytes.error()).Within(file.string());
  return WriteText(file, bytes.value());
}

Result<SimulationState> ReadState(const std::filesystem::path& file, const std::string& run) {
  const auto wrong = [&](const std::string& what) {
    return Error{ErrorKind::kBadInput,
                 file.string() + ": " + what + "; delete it to start anew, or name another file"};
  };
  if (!std::filesystem::exists(file)) return Error{ErrorKind::kNotFound, file.string() + ": no such file"};
  const hdf5::Session session;
  const hdf5::Handle in(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), &H5Fclose);
  if (!in.ok()) return wrong("is no state of a simulation, or damaged");
  const Result<hdf5::Array> of = hdf5::ReadArray(in.get(), "run");
  const Result<hdf5::Array> numbers = hdf5::ReadArray(in.get(), "numbers");
  if (!of.ok() || !numbers.ok()) return wrong("is no state of a simulation, or damaged");
  if (of.value().values != std::vector<double>(run.begin(), run.end())) {
    return wrong("is the state of another run: its scene, options or program differ");
  }
  SimulationState state;
  state.numbers = numbers.value().values;
  if (!hdf5::Has(in.get(), "time")) return state;
  const Result<hdf5::Array> time = hdf5::ReadArray(in.get(), "time");
  if (!time.ok()) return wrong("is damaged");
  const std::vector<double>& times = time.value().values;
  for (std::size_t r = 0; hdf5::Has(in.get(), NameOfCurves(r)); ++r) {
    const Result<hdf5::Array> array = hdf5::ReadArray(in.get(), NameOfCurves(r));
    if (!array.ok() || array.value().shape.size() != 3 || array.value().shape[2] != 6 ||
        array.value().shape[0] != times.size()) {
      return wrong("is damaged");
    }
    CurveSeries& series = state.curves.emplace_back();
    series.time = Eigen::Map<const Eigen::VectorXd>(times.data(), static_cast<Index>(times.size()));
    series.curves = CurvesOfArray(array.value());
  }
  return state;
}

}  // namespace tendril
