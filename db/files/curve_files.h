#pragma once
// Framed curves on disk (docs/formats.md): CSV `[frame,time,]curve,node,x,y,z[,nx,ny,nz]` and HDF5
// `/curve/<name>/points` [frames, nodes, 3], `normals`, `sigma`, `time`, `covariance`, `interpolated`,
// `angle`, `angle_sigma`, `angle_by_pictures`, `turn`; beside curves of a simulation, where its objects were:
// `/object/<name>/position` [frames, 3], `orientation` [frames, 4] (x, y, z, w), `force` [frames, 3], `time`.
//
// Metres, seconds, newtons, lab frame. Both keep every double of a curve to the last bit; CSV holds points
// and normals only.

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "model/geometry/framed_curve.h"
#include "model/objects/object_series.h"
#include "model/result.h"

namespace tendril {

// By extension: .csv, or .h5/.hdf5. A CSV without frame,time is one frame at time 0. Curves come in the order
// in which they first appear (CSV) or were written (HDF5). A CSV needs every
// curve in every frame, rows sorted by frame or by curve. HDF5
// points may be NaN where an estimator saw nothing; a CSV's may not.
//   errors  kNotFound no such file; kBadInput names file, line or dataset, field, value and what was
//   expected:
//           truncated, not a number, nodes that do not run 0, 1, 2, ..., sizes that do not agree, no curve
Result<std::vector<CurveSeries>> ReadCurves(const std::filesystem::path& file);

// By extension too. Written beside the target and renamed: a reader sees the whole file or none.
//   source  where the curves came from ("tendril track 0.1.0"); kept as an attribute of an HDF5 file
//   objects at the times of the first curve; a CSV has no place for them and goes without
//   errors  kBadInput sizes that do not agree, a name that is empty, repeated or holds a comma, slash or
//   control
//           character; kIo disk full, not writable
Status WriteCurves(const std::filesystem::path& file, std::span<const CurveSeries> curves,
                   const std::string& source, std::span<const ObjectSeries> objects = {});

struct ObjectsOverTime {
  Eigen::VectorXd time;               // s                                             (frames)
  std::vector<ObjectSeries> objects;  // in the order in which they were written
};

// The objects of an HDF5 file that WriteCurves wrote, poses as exact as a unit quaternion has them (1e-15); a
// file without `/object` has none. A rotation must be a unit quaternion to 1e-6.
//   errors  as ReadCurves; kBadInput  objects whose times differ
Result<ObjectsOverTime> ReadObjectsOverTime(const std::filesystem::path& file);

}  // namespace tendril
