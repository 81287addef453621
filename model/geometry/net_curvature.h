#pragma once
// How much a curve bends over all its length, frame by frame, and how sure that is.
//
// SI units. Nodes as FramedCurve numbers them; segments join neighbouring nodes.

#include <Eigen/Core>

#include "model/geometry/framed_curve.h"

namespace tendril {

struct NetCurvature {
  Eigen::VectorXd value;  // 1/m; NaN: a node has no position, or two are in one place     (frames)
  Eigen::VectorXd sigma;  // 1-sigma error from the nodes' covariance, 1/m; NaN: none is stated,
                          // or no frame of the series turns at all                      (frames)
};

// The turns from segment to segment, summed as vectors along their axes, about the axis that the series turns
// about most; over the length between the middles of the first and the last segment, as that is what turns so
// far.
//   first, last  nodes that count, 0 <= first, last < nodes; last -1: the last
//   returns      sigma by first-order propagation of the covariance factor, central differences along each of
//                its columns; the axis is taken as known. Errors that stretch all lengths alike (the scale)
//                are not in the factor of a chain that was scaled by hand, nor in sigma.
NetCurvature NetCurvatureOf(const CurveSeries& series, Eigen::Index first = 0, Eigen::Index last = -1);

}  // namespace tendril
