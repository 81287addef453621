#pragma once
// Rotations and their vectors (axis times angle, rad): exp and log of SO(3), with all their digits at every
// angle from 0 to pi.

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace tendril {

// The rotation by |v| about v, rad. Exact to a few rounding errors of each entry, also where |v|^2
// underflows.
Eigen::Matrix3d ExpSo3(const Eigen::Vector3d& v);
Eigen::Quaterniond ExpSo3Quaternion(const Eigen::Vector3d& v);

// The shortest vector v with ExpSo3(v) = rotation, |v| in [0, pi]. At pi both signs are right; one is given.
//   rotation  orthonormal to rounding; a quaternion of unit length to rounding, either sign
//   returns   v to about 1e-15 of its length, absolute 1e-15 near pi: a quaternion (by its largest component)
//             keeps the angle's digits at 0, where the trace has none, and at pi, where R - R^T has none
Eigen::Vector3d LogSo3(const Eigen::Matrix3d& rotation);
Eigen::Vector3d LogSo3(const Eigen::Quaterniond& rotation);

}  // namespace tendril
