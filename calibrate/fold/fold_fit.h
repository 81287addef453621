#pragma once
// Which fold-model parameters explain observed shapes, and how surely? (docs/calibration.md)
//
// Always pull_scale (the tendon's real pull = pull_scale * commanded pull), stiffness_ratio (beta creases /
// alpha creases) and stiffness_exponent (a crease's stiffness grows with width^p); if the model says so, the
// creases' rest angle and the tendon's friction. Shapes are compared free of pose. SI units.

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calibrate/fold/fold_model.h"
#include "calibrate/fold/shape_residual.h"
#include "model/fold/design.h"
#include "model/geometry/framed_curve.h"
#include "model/progress.h"
#include "model/result.h"

namespace tendril {

// One tentacle in one frame.
struct FoldObservation {
  std::string trial;  // observations of one trial may err together: standard errors allow for it
  int tentacle = 0;
  TentacleDesign design;      // of this tentacle (mirrored where the gripper mirrors it)
  double time = 0;            // s since the trial began
  double commanded_pull = 0;  // fraction
  // How long, at this frame, the command has stood still, and how long its rate has been the same; s.
  // A tentacle lags its command: only where the command has stood still long enough are the two equal.
  double settled_for = std::numeric_limits<double>::infinity();
  double steady_for = std::numeric_limits<double>::infinity();
  bool released = false;         // the command had gone back before: friction then remembers
  FramedCurve curve;             // nodes are the holes
  Eigen::VectorXd sigma;         // 1-sigma position error per node, m; NaN: not seen; no entries: not known
  Eigen::VectorXi interpolated;  // 1: not seen, bridged; no entries: all seen
  // For the hint of a further view (view_places.h makes them); no entries: not known.
  Eigen::VectorXi cameras;  // that saw the node's facet                                        (nodes)
  Eigen::MatrixXi further;  // views of it that each of the options' places would add   (places, nodes)
  // F with cov(curve.points, stacked x0 y0 z0 x1 ...) = F F^T, m; some observations' is enough
  // (3 nodes, rank)
  Eigen::MatrixXd covariance_factor;
};

struct FoldFitOptions {
  FoldModel model;
  ShapeResidualOptions residual;
  // A tentacle has followed its command after this, s. Servo logs carry each servo's own command; where the
  // command is common and start-up delays are not logged, it takes longer.
  double longest_lag = 0.25;
  double unknown_sigma = 0.5e-3;  // m: for curves that come without sigma
  int fewest_nodes = 6;           // a frame with fewer seen nodes is left out
  double outlier_frame = 6;       // a frame whose RMS is this many times the median frame's is left out
  double huber = 2.5;             // residuals beyond this many robust standard deviations count linearly
  double confidence = 0.95;
  int iterations = 100;
  // Start, and what a parameter is held at that the data cannot identify. NaN: the first design's value.
  double start_pull_scale = 1;
  double start_ratio = std::numeric_limits<double>::quiet_NaN();
  double start_exponent = std::numeric_limits<double>::quiet_NaN();
  double start_rest_angle = std::numeric_limits<double>::quiet_NaN();  // rad; NaN: the design's, or 0.05
  double start_friction = std::numeric_limits<double>::quiet_NaN();    // NaN: the design's, or 0.03
  // What could be seen besides, as the hint's sentence names it: "another camera at ...". Rows of `further`.
  std::vector<std::string> places;
};

// (db/trial_store.h has a FitParameter of its own, for the row.)
struct FittedParameter {
  std::string name;  // of FoldParameterNames(), which say the unit
  double value = 0;  // where not identified: what it was held at
  double standard_error = std::numeric_limits<double>::quiet_NaN();
  struct Interval {
    double low = std::numeric_limits<double>::quiet_NaN();
    double high = std::numeric_limits<double>::quiet_NaN();
  } interval;  // at options.confidence; NaN: none
  bool identified = false;
  bool at_bound = false;  // rests at 0, its least value: its profile shows what lies beside (fold_profile.h)
  std::string why;        // why not identified
};

struct LeftOut {
  std::size_t observation = 0;  // index into the observations
  std::string reason;
};

// Where the size of errors that are new in each picture is known from.
enum class PictureErrors {
  kRepeats,      // frames in which a tentacle is held at one pull: they differ by nothing else
  kCovariance,   // the covariance that the tracker states along the curve
  kStatedSigma,  // each node's sigma, as if nodes erred alone: too much where neighbours err together
};

// What other views would do for the parameter that the hint is about (docs/calibration.md, "Pull or view").
// Standard errors are those that these same trials would have had, clustered by trial.
struct ViewHint {
  // Share of its variance that comes of errors which are new in each picture. The rest is of tentacles that
  // differ from the model and from trial to trial, which no camera mends.
  double picture_share = 0;
  PictureErrors known_from = PictureErrors::kStatedSigma;
  double perfect_ratio = 1;         // with every node seen, without error / now
  std::vector<double> error_ratio;  // with each of the options' places / now; empty: not known
  int best = -1;                    // of the places; -1: not known
  std::string sentence;
};

// Which pull would tell most about the least known parameter (the one with most error for what is of use).
struct PullHint {
  std::string parameter;
  std::vector<double> pull;         // commanded, candidates
  std::vector<double> error_ratio;  // its standard error after one more trial held there / now
  double best_pull = 0;
  std::string sentence;
  std::optional<ViewHint> view;  // none: one trial, or not compared by distances
};

struct FoldFit {
  FoldModel model;
  std::vector<FittedParameter> parameters;  // the model's, in the order of FoldParameterNames()
  // Of these; NaN in rows and columns of what is not identified.
  Eigen::MatrixXd covariance;        // clustered by trial; the naive one where there is one trial only
  Eigen::MatrixXd naive_covariance;  // as if every node of every frame erred alone
  bool clustered = false;
  int degrees_of_freedom = 0;  // of the t quantile behind the intervals: trials - 1
  Scatter scatter;             // nuisances; shape_residual.h says what they are
  double residual_rms = 0;     // aligned model - observed, seen nodes of the used frames, m
  int trials = 0;
  int frames_used = 0;
  int frames_settled = 0;  // used frames whose pull the command states; the others' pull is fitted besides
  std::vector<LeftOut> left_out;
  int iterations = 0;
  bool converged = false;
  std::string message;  // why the solver stopped
  std::vector<std::string> warnings;
  std::optional<PullHint> hint;  // of FitFold
  double seconds = 0;
};

// Fits by least squares under a Huber loss.
//
// A frame's pull is the command's where it has stood still for longest_lag. Else the tentacle lags by an
// unknown delay: if its trial has a settled frame at a pull above zero, the moving frames' pulls are fitted
// one by one (they then tell of ratio and exponent only); if not, one lag per tentacle and trial is fitted to
// the frames in which the command's rate has been steady for longest_lag.
//
// Two scatters (shape_residual.h) are fitted besides, unless the data cannot tell them from the parameters.
//
// Standard errors: sandwich, clustered by trial, in the form of the linearised delete-one-trial jackknife
// (which carries the small-sample correction); intervals by Student's t with trials - 1 degrees of freedom.
// With one trial they fall back to independent nodes, which understates them: `clustered` and a warning say
// so.
//
//   errors  kBadInput: no observations; a curve whose nodes are not the design's holes, or an option out of
//           range (names them); no frame is usable (names the reasons); kStopped: progress said so
Result<FoldFit> FitFold(std::span<const FoldObservation> observations, const FoldFitOptions& options = {},
                        const Progress& progress = {});

}  // namespace tendril
