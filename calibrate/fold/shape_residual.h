#pragma once
// How far an observed curve's shape is from the model's, whatever its pose: the residual of the fold fit and
// its derivatives.

#include <Eigen/Core>
#include <vector>

#include "calibrate/fold/node_motion.h"
#include "model/geometry/framed_curve.h"

namespace tendril {

// Compared in docs/calibration.md, which says why the first is the default.
enum class ShapeResidualKind {
  kAlignedWindows,  // node positions, after the model's window of nodes is laid on the observed one
  kLocalDistances,  // hole-to-hole distances over one, two and three creases
};

struct ShapeResidualOptions {
  ShapeResidualKind kind = ShapeResidualKind::kAlignedWindows;
  int window = 9;  // nodes in a window; half a window from one to the next; >= all nodes: one
  double model_error =
      0.3e-3;  // m, 1-sigma; added to the tracker's sigma: no node is better modelled than this
};

// The nodes of a frame that were seen, ascending.
struct SeenNodes {
  Eigen::VectorXi index;    //                                                        (seen)
  Eigen::Matrix3Xd points;  // m                                                      (3, seen)
  Eigen::VectorXd sigma;    // 1-sigma position error, m                              (seen)
};

// Groups of `group` rows belong together (a node's three components): a robust loss sees their length.
struct ShapeResidual {
  int group = 1;
  Eigen::VectorXd value;                                         // in sigmas          (rows)
  Eigen::Matrix<double, Eigen::Dynamic, kFoldDirections> slope;  // by pull, ln ratio, exponent (rows, 3)
};

// Rows that ResidualOf gives for these nodes: depends on which were seen, not on where they are.
int ResidualRows(const SeenNodes& seen, int nodes, const ShapeResidualOptions& options);
// A frame's rows count each node this many times on average (windows overlap; distances share nodes).
double RowsPerNode(const SeenNodes& seen, int nodes, const ShapeResidualOptions& options);

// The model minus the observed shape. For windows, the slope is that of the aligned residual with the
// pose following (variable projection, Kaufman's form): exact for the cost's gradient.
ShapeResidual ResidualOf(const NodeMotion& model, const SeenNodes& seen, const ShapeResidualOptions& options);

// RMS distance of the seen nodes from the model's after the best rigid motion, m.
double AlignedRms(const Eigen::Ref<const Eigen::Matrix3Xd>& model_nodes, const SeenNodes& seen);

}  // namespace tendril
