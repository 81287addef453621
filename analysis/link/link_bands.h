#pragma once
// How sure a link is when the curves are not: the distribution of every value over curves drawn from their
// covariance, and the crossings of which it is not known which strand lies in front.

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "analysis/link/link.h"
#include "model/geometry/framed_curve.h"
#include "model/progress.h"
#include "model/result.h"

namespace tendril {

// Values that lie apart by more than half a turn from all others: strands that passed each other.
struct LinkMode {
  double value = 0;  // mean of the draws in it, turns
  double share = 0;  // of all draws
};

// Of one value over the draws; all NaN where it is not known in some of them.
struct LinkBand {
  double mean = 0, standard_deviation = 0;
  double low68 = 0, high68 = 0, low95 = 0, high95 = 0;  // equal tails
  std::vector<LinkMode> modes;                          // by share; one where nothing passed
};

// Two strands, or a strand and the axis, that are apart by less than a few standard deviations of that
// distance.
struct UndecidedCrossing {
  int a = 0, b = 0;                  // curves, a <= b; b = -1: the object's axis
  double node_a = 0, node_b = 0;     // where, in nodes from the base
  double separation = 0, sigma = 0;  // m
};

struct CurveBands {
  LinkBand writhe, self_link, object_link;
};
struct PairBands {
  int a = 0, b = 0;
  LinkBand link, gauss;
};
struct LinkBands {
  std::vector<CurveBands> curves;
  std::vector<PairBands> pairs;
  LinkBand mutual_link, object_link, performance;
  std::vector<UndecidedCrossing> undecided;
  int draws = 0;
  bool normals_drawn = false;  // of every curve that has normals
};

struct LinkBandOptions {
  int draws = 400;
  std::uint32_t seed = 1;
  double undecided_sigmas = 3;
};

// Curves are drawn as points + F z with z standard normal, each curve by itself; their normals are made
// perpendicular to the drawn curve and turned about it by G z. Without G they are not turned: the self-link's
// band then knows the centerline's errors only, and is too narrow.
//   factors  of each curve: F with cov(points, x0 y0 z0 x1 ...) = F F^T, m                    (3 nodes, any)
//   turns    of each curve: G, rad; its first columns are those of F, and z goes on for the others. None, or
//            a G without rows: not known                                        (nodes, F's columns or more)
//   errors   kBadInput  as MeasureLink; a factor of another number of nodes or not finite; a G with fewer
//                       columns than F; draws < 2
//            kStopped   progress said so
Result<LinkBands> MeasureLinkBands(std::span<const FramedCurve> curves,
                                   std::span<const Eigen::MatrixXd> factors, const LinkOptions& options,
                                   const LinkBandOptions& band_options = {}, const Progress& progress = {},
                                   std::span<const Eigen::MatrixXd> turns = {});

// Crossings nearer than `sigmas` standard deviations of their own separation, along the line between them;
// the nearest of each neighbourhood. Of one curve with itself only pieces that are more than three segments,
// and three times their separation, apart along the curve.
std::vector<UndecidedCrossing> FindUndecided(std::span<const FramedCurve> curves,
                                             std::span<const Eigen::MatrixXd> factors,
                                             const std::optional<Axis>& axis, double sigmas);

}  // namespace tendril
