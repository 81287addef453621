#pragma once
// The one shape that all stages exchange: a polyline with a unit normal at each node, over time.
//
// Nodes run from base to tip. SI units; a right-handed frame that the owner names (lab unless said).

#include <Eigen/Core>
#include <string>
#include <vector>

namespace tendril {

struct FramedCurve {
  Eigen::Matrix3Xd points;   // m                                             (3, nodes)
  Eigen::Matrix3Xd normals;  // unit vectors; no columns: not known           (3, nodes)
};

// A curve over time. Every frame has the same number of nodes.
struct CurveSeries {
  std::string name;
  Eigen::VectorXd time;                            // s since the trial began                     (frames)
  std::vector<FramedCurve> curves;                 //                                             (frames)
  std::vector<Eigen::VectorXd> sigma;              // 1-sigma position error per node, m; NaN: not seen
                                                   // no entries: not estimated            (frames) x (nodes)
  std::vector<Eigen::VectorXi> interpolated;       // 1: bridged by the model, not seen; no entries: not known
  std::vector<Eigen::MatrixXd> covariance_factor;  // F with cov(points, stacked x0 y0 z0 x1 ...) = F F^T, m
                                                   // no entries: not estimated  (3 nodes, rank)
  std::vector<Eigen::VectorXd> angle = {};  // fold angle phi_i of each crease, rad; no entries: not known
                                            //                                        (frames) x (nodes - 1)
  std::vector<Eigen::VectorXd> angle_sigma = {};  // of these, rad; NaN or no entries: not known
  // Share of what is known of these that pictures told, 0 to 1 (the rest is what a model expects); no
  // entries: not known
  std::vector<Eigen::VectorXd> angle_by_pictures = {};
  // G: where points are off by F z, normals are turned about the curve by G z (right-handed about the tangent
  // from base to tip), rad. Its first columns are those of covariance_factor, z goes on; no entries: not
  // estimated                                                                        (nodes, rank or more)
  std::vector<Eigen::MatrixXd> turn_factor = {};
};

}  // namespace tendril
