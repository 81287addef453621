#include "model/fold/gripper.h"

#include <algorithm>
#include <cmath>

namespace tendril {

TentacleDesign DesignOfTentacle(const Gripper& gripper, const TentacleDesign& design, int i) {
  return gripper.handedness == Handedness::kMirror && i % 2 != 0 ? Mirrored(design) : design;
}

double WidestPairSpacing(const Gripper& gripper) {
  if (gripper.tentacles % 2 != 0) return 0;
  const double half = std::min(std::numbers::pi / 2, 2 * std::numbers::pi / gripper.tentacles);
  return 2 * gripper.carrier_radius * std::sin(half);
}

double AzimuthOfTentacle(const Gripper& gripper, int i) {
  const double even = gripper.first_azimuth + 2 * std::numbers::pi * i / gripper.tentacles;
  if (gripper.pair_spacing == 0) return even;
  const double side = i % 2 == 0 ? -1 : 1;
  const double half = std::asin(std::min(1.0, 0.5 * gripper.pair_spacing / gripper.carrier_radius));
  return even + side * (half - std::numbers::pi / gripper.tentacles);
}

Eigen::Isometry3d LabFromTentacle(const Gripper& gripper, int i) {
  const double azimuth = AzimuthOfTentacle(gripper, i);
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
