#pragma once
// The planar centerline of a limb that carries a chain of tags, seen side-on by one camera: nodes are the
// tags' centres in order. What was not seen is not made up: its points and sigma (of a coordinate)
// are NaN.
//
// Lab frame: the limb moves in the plane y = 0; the camera looks along +y with x to the right, z up.

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "db/files/recording_logs.h"
#include "model/geometry/framed_curve.h"
#include "model/result.h"

namespace tendril {

struct PlanarChainOptions {
  std::vector<int> chain;  // tag ids from base to tip, two or more
  double sigma_px = 0.5;   // standard deviation of a tag's centre in x and in y
  // Where in the plane a pixel lies: (x, z), m; none where it sees no point of it.
  std::function<std::optional<Eigen::Vector2d>(const Eigen::Vector2d& pixel)> plane_of_pixel;
};

struct PlanarChain {
  CurveSeries curve;  // covariance: pixels that err for themselves; zero where not seen  (3 nodes, 2 nodes)
  // NaN in frames where a tag of the chain is missing.
  Eigen::VectorXd tip_angle;       // of the last segment against the first, along the chain, rad     (frames)
  Eigen::VectorXd mean_curvature;  // tip_angle / arc length between those segments' middles, 1/m    (frames)
  int complete_frames = 0;         // in which the whole chain was seen
  double seen_fraction = 0;        // of all nodes and frames
  double rms_sigma = 0;            // over the nodes seen, m
};

// The centre of a tag: where its diagonals cross (the mean is off under perspective). Four equal corners
// stand for a recording that holds centres only.
Eigen::Vector2d TagCenter(const Eigen::Matrix<double, 2, 4>& corners_px);

// Median distance of neighbours in the chain over all frames, px; NaN if no two neighbours were ever seen at
// once.
double MedianSpacingPx(std::span<const DetectionRow> detections, std::span<const int> chain);

//   detections  of one camera; of two rows for a tag and frame the one with the larger margin counts
//   time        of each frame, s; frame numbers of the detections index it
//   errors      kBadInput: fewer than two tags in the chain or one twice, a frame beyond `time`
Result<PlanarChain> FollowPlanarChain(std::span<const DetectionRow> detections, const Eigen::VectorXd& time,
                                      const PlanarChainOptions& options);

}  // namespace tendril
