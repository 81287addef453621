#pragma once
// The closest points of two segments.

#include <Eigen/Core>

namespace tendril {

struct ClosestPoints {
  double s = 0;           // on the first segment, from 0 at its start to 1 at its end
  double t = 0;           // on the second
  Eigen::Vector3d apart;  // from the first's point to the second's, m
};

// Of segments a0 a1 and b0 b1; a segment may be a point. Of segments within 1e-7 rad of parallel
// that lie side by side, the middle of where they do: the answer then does not jump with rounding.
ClosestPoints ClosestOfSegments(const Eigen::Vector3d& a0, const Eigen::Vector3d& a1,
                                const Eigen::Vector3d& b0, const Eigen::Vector3d& b1);

}  // namespace tendril
