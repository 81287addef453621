#pragma once
// An object over time: where it was and what rods did to it.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace tendril {

struct ObjectSeries {
  std::string name;
  std::vector<Eigen::Isometry3d> poses;  // lab_from_object                          (frames)
  std::vector<Eigen::Vector3d> forces;   // of rods on it, N, lab                    (frames)
};

}  // namespace tendril
