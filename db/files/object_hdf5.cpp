// Objects over time in an HDF5 file of curves: `/object/<name>/position`, `orientation`, `force`, `time`.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "db/files/curve_files.h"
#include "db/files/curve_formats.h"
#include "db/files/hdf5_file.h"

namespace tendril {
namespace {

using hdf5::Array;
using hdf5::Handle;

constexpr hsize_t kAny = static_cast<hsize_t>(-1);

// [frames, width] of finite numbers; width 0: [frames].
Result<Array> Read(hid_t group, const std::string& name, hsize_t frames, hsize_t width,
                   const std::string& units) {
  Result<Array> array = hdf5::ReadArray(group, name);
  if (!array.ok()) return std::move(array).error().Within(name);
  const std::vector<hsize_t>& shape = array.value().shape;
  const auto wrong = [&](const std::string& what) { return Error{ErrorKind::kBadInput, name + ": " + what}; };
  if (shape.size() != (width == 0 ? 1U : 2U) || (frames != kAny && shape[0] != frames) ||
      (width > 0 && shape[1] != width)) {
    return wrong(fmt::format("shape [{}]: expected [{}{}]", fmt::join(shape, ", "),
                             frames == kAny ? "any" : std::to_string(frames),
                             width == 0 ? "" : ", " + std::to_string(width)));
  }
  if (!array.value().units.empty() && array.value().units != units) {
    return wrong(fmt::format("units = '{}': expected '{}'", array.value().units, units));
  }
  for (const double value : array.value().values) {
    if (!std::isfinite(value)) return wrong(fmt::format("{}: expected numbers", value));
  }
  return array;
}

struct OneObject {
  Array time;
  ObjectSeries series;
};

Result<OneObject> ReadOne(hid_t group, const std::string& name) {
  OneObject one;
  one.series.name = name;
  Result<Array> time = Read(group, "time", kAny, 0, "s");
  if (!time.ok()) return std::move(time).error();
  one.time = std::move(time).value();
  const hsize_t frames = one.time.shape[0];
  if (!std::is_sorted(one.time.values.begin(), one.time.values.end())) {
    return Error{ErrorKind::kBadInput, "time: expected times that never fall"};
  }
  const Result<Array> position = Read(group, "position", frames, 3, "m");
  if (!position.ok()) return position.error();
  const Result<Array> orientation = Read(group, "orientation", frames, 4, "1");
  if (!orientation.ok()) return orientation.error();
  const Result<Array> force = Read(group, "force", frames, 3, "N");
  if (!force.ok()) return force.error();
  for (hsize_t f = 0; f < frames; ++f) {
    const double* const q = orientation.value().values.data() + 4 * f;
    const Eigen::Quaterniond turned(q[3], q[0], q[1], q[2]);
    if (std::abs(turned.norm() - 1) > 1e-6) {
      return Error{ErrorKind::kBadInput,
                   fmt::format("orientation: frame {} has length {}: expected a unit quaternion (x, y, z, w)",
                               f, turned.norm())};
    }
    Eigen::Isometry3d& pose = one.series.poses.emplace_back(turned.normalized());
    pose.translation() = Eigen::Map<const Eigen::Vector3d>(position.value().values.data() + 3 * f);
    one.series.forces.emplace_back(Eigen::Map<const Eigen::Vector3d>(force.value().values.data() + 3 * f));
  }
  return one;
}

bool WriteOne(hid_t group, const ObjectSeries& series, const Eigen::VectorXd& time) {
  const hsize_t frames = series.poses.size();
  Array position{{frames, 3}, {}, "m"}, orientation{{frames, 4}, {}, "1"}, force{{frames, 3}, {}, "N"};
  Eigen::Quaterniond before = Eigen::Quaterniond::Identity();
  for (hsize_t f = 0; f < frames; ++f) {
    const Eigen::Isometry3d& pose = series.poses[f];
    Eigen::Quaterniond turned(pose.linear());
    turned.normalize();
    // Of the two signs the one nearer to the frame before: differences of frames then mean something.
    if (turned.dot(before) < 0) turned.coeffs() *= -1;
    before = turned;
    position.values.insert(position.values.end(), pose.translation().begin(), pose.translation().end());
    orientation.values.insert(orientation.values.end(), turned.coeffs().begin(), turned.coeffs().end());
    force.values.insert(force.values.end(), series.forces[f].begin(), series.forces[f].end());
  }
  const Array times{{frames}, {time.begin(), time.end()}, "s"};
  return hdf5::WriteArray(group, "position", position, H5T_IEEE_F64LE) &&
         hdf5::WriteArray(group, "orientation", orientation, H5T_IEEE_F64LE) &&
         hdf5::WriteArray(group, "force", force, H5T_IEEE_F64LE) &&
         hdf5::WriteArray(group, "time", times, H5T_IEEE_F64LE);
}

}  // namespace

bool WriteObjects(std::int64_t file, std::span<const ObjectSeries> objects, const Eigen::VectorXd& time,
                  const std::string& source) {
  const Handle all = hdf5::MakeGroup(file, "object");
  bool good = all.ok();
  for (const ObjectSeries& series : objects) {
    if (!good) break;
    const Handle group = hdf5::MakeGroup(all.get(), series.name);
    good =
        group.ok() && hdf5::WriteText(group.get(), "source", source) && WriteOne(group.get(), series, time);
  }
  return good;
}

Result<ObjectsOverTime> ReadObjectsOverTime(const std::filesystem::path& path) {
  const auto wrong = [&](const std::string& what) {
    return Error{ErrorKind::kBadInput, path.string() + ": " + what};
  };
  const hdf5::Session session;
  const Result<Handle> opened = hdf5::OpenToRead(path);
  if (!opened.ok()) return opened.error();
  const Handle& file = opened.value();
  ObjectsOverTime found;
  if (!hdf5::Has(file.get(), "object")) return found;
  const Handle all(H5Gopen2(file.get(), "object", H5P_DEFAULT), H5Gclose);
  if (!all.ok()) return wrong("/object: is not a group");
  for (const std::string& name : hdf5::GroupNames(all.get())) {
    const Handle group(H5Gopen2(all.get(), name.c_str(), H5P_DEFAULT), H5Gclose);
    Result<OneObject> one = ReadOne(group.get(), name);
    if (!one.ok()) {
      return std::move(one).error().Within(fmt::format("{}: /object/{}", path.string(), name));
    }
    const std::vector<double>& times = one.value().time.values;
    const Eigen::Map<const Eigen::VectorXd> time(times.data(), static_cast<Eigen::Index>(times.size()));
    if (found.objects.empty()) {
      found.time = time;
    } else if (found.time.size() != time.size() || found.time != time) {
      return wrong(
          fmt::format("/object/{}/time: expected the times of /object/{}", name, found.objects.front().name));
    }
    found.objects.push_back(std::move(one.value().series));
  }
  return found;
}

}  // namespace tendril
