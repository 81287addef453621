#include "model/fold/gripper.h"

#include <cmath>

namespace tendril {

TentacleDesign DesignOfTentacle(const Gripper& gripper, const TentacleDesign& design, int i) {
  return gripper.handedness == Handedness::kMirror && i % 2 != 0 ? Mirrored(design) : design;
}

Eigen::Isometry3d LabFromTentacle(const Gripper& gripper, int i) {
  const double azimuth = gripper.first_azimuth + 2 * std::numbers::pi * i / gripper.tentacles;
  const Eigen::Vector3d outward(std::cos(azimuth), std::sin(azimuth), 0);
  const double sine = std::sin(gripper.tilt);
  const double cosine = std::cos(gripper.tilt);
  Eigen::Vector3d d3 = -sine * outward;
  d3.z() = -cosine;
  Eigen::Vector3d d1 = cosine * outward;
  d1.z() = -sine;
  if (gripper.handedness == Handedness::kNormals && i % 2 != 0) d1 = -d1;

  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() << d1, d3.cross(d1), d3;
  pose.translation() = gripper.carrier_radius * outward;
  return pose;
}

}  // namespace tendril
