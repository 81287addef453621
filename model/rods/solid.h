#pragma once
// An object as contact sees it at one moment, and what contact does to it.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "model/objects/shape.h"

namespace tendril {

struct Solid {
  Shape shape;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  // lab_from_object
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      // of the object's origin, m/s
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();          // lab, rad/s
  double friction = -1, static_friction = -1;              // mu; below 0: the contact's
};

struct Wrench {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();   // N
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();  // about the object's origin, lab, N m
};

}  // namespace tendril
