#pragma once
// What a rigid body feels of the medium it moves in: buoyancy, drag and added mass (docs/media.md).
//
// SI units. A union is the sum of its parts, each in an even stream of its own: one part's lee and what parts
// share are not counted. The centre of the displaced volume is taken to be the centre of mass.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "model/objects/rigid_body.h"
#include "model/objects/shape.h"
#include "model/result.h"
#include "model/rods/medium.h"

namespace tendril {

// A part's figures, along and about the axes of its primitive.
struct DragPart {
  PrimitiveKind kind = PrimitiveKind::kSphere;
  Eigen::Isometry3d object_from_part = Eigen::Isometry3d::Identity();
  Eigen::Vector3d area = Eigen::Vector3d::Zero();     // C_d A of moving, m^2
  Eigen::Vector3d turning = Eigen::Vector3d::Zero();  // of turning: torque / (rho/2 spin^2), m^5
  Eigen::Vector3d added = Eigen::Vector3d::Zero();    // C_a V, m^3
};

struct ObjectDrag {
  std::vector<DragPart> parts;
  double volume = 0;  // displaced; where parts overlap both count, m^3
};

// Coefficients: sphere C_d 0.47, cylinder 1.1 across (on 2 r l) and 0.82 along (on its end), box 1.05 on each
// face, capsule as a cylinder with half a sphere at either end (Hoerner 1965; Re from 1e3 to 2e5, sharp edges
// also above). C_a: sphere 1/2, cylinder across 1 (Lamb 1932), box 0.68 (a cube's, DNV-RP-H103), cylinder
// along 8 r^3 / 3 (a disc's, Lamb 1932: too much for long ones). Turning is an estimate: strips across the
// axis, each with the drag of its own speed, and skin friction of 0.01 of the surface where a surface slides
// along itself.
//   errors  kBadInput  no part, a half space, a size that is not above 0
Result<ObjectDrag> DragOf(const Shape& shape);

// What the medium does to a body, in the lab.
struct BodyLoad {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();   // N
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();  // about the centre of mass, N m
};
// Buoyancy, and the mean drag over a kick of `time` (0: drag at this moment), such that drag alone takes
// energy whatever the time: F / (1 + time R), R a bound of the rate at which drag slows body.mass and
// body.inertia. First order in time.
BodyLoad ForceOnBody(const ObjectDrag& drag, const RigidBody& body, const Medium& medium,
                     const Eigen::Vector3d& gravity, double time);

// Kinetic energy of the medium that moves with a body is v^T M v / 2: this M, along the object's axes, kg.
Eigen::Matrix3d AddedMass(const ObjectDrag& drag, const Medium& medium);

}  // namespace tendril
