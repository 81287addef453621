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
  kLocalDistances,  // hole-to-hole distances over one crease, or over a few
  kAlignedWindows,  // node positions, after the model's window of nodes is laid on the observed one
};

struct ShapeResidualOptions {
  ShapeResidualKind kind = ShapeResidualKind::kLocalDistances;
  int creases = 3;  // that a distance spans, at most
  int window = 9;   // nodes in a window; half a window from one to the next; >= all nodes: one
  // m, 1-sigma; added to the tracker's sigma: no node is better modelled than this.
  double model_error = 0.3e-3;
};

// Distances between nodes that scatter are too long on average: noise and misplaced holes add to their
// squares wherever, misplaced creases as far as they are folded (docs/calibration.md, "Scatter"). Flat in
// squared sigmas of the distance, folded in model_error^2; negative for curves that were smoothed.
struct Scatter {
  double flat = 0;
  double folded = 0;
};
inline constexpr int kScatters = 2;

// The nodes of a frame that were seen, ascending.
struct SeenNodes {
  Eigen::VectorXi index;    //                                                        (seen)
  Eigen::Matrix3Xd points;  // m                                                      (3, seen)
  Eigen::VectorXd sigma;    // 1-sigma position error, m                              (seen)
};

// Columns of slopes: the directions of the fold, then the two scatters.
inline constexpr int kShapeDirections = kFoldDirections + kScatters;

// Groups of `group` rows belong together (a node's three components): a robust loss sees their length.
struct ShapeResidual {
  int group = 1;
  Eigen::VectorXd value;  // in sigmas                                                          (rows)
  Eigen::VectorXd sigma;  // that one sigma of `value` stands for, m                            (rows)
  // By the directions of the fold, then scatter flat and folded                                (rows, 7)
  Eigen::Matrix<double, Eigen::Dynamic, kShapeDirections> slope;
};

// Positions among the seen nodes of those whose distance is compared; a row of kLocalDistances each, in
// order.
struct NodePair {
  Eigen::Index a = 0;
  Eigen::Index b = 0;
};
std::vector<NodePair> PairsOf(const SeenNodes& seen, int creases);

// Rows that ResidualOf gives for these nodes: depends on which were seen, not on where they are.
int ResidualRows(const SeenNodes& seen, int nodes, const ShapeResidualOptions& options);

// The model minus the observed shape. Windows know no scatter (their slopes by it are 0); for them the slope
// is that of the aligned residual with the pose following (variable projection, Kaufman's form): exact for
// the cost's gradient.
ShapeResidual ResidualOf(const NodeMotion& model, const SeenNodes& seen, const ShapeResidualOptions& options,
                         const Scatter& scatter = {});

// RMS distance of the seen nodes from the model's after the best rigid motion, m.
double AlignedRms(const Eigen::Ref<const Eigen::Matrix3Xd>& model_nodes, const SeenNodes& seen);

}  // namespace tendril
