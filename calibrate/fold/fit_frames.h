#pragma once
// Observations made ready for the fold fit: which nodes count, how a frame's pull follows from the command,
// and what is left out and why. Internal to calibrate/fold.

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calibrate/fold/fold_fit.h"
#include "calibrate/fold/shape_residual.h"

namespace tendril {

enum class PullSource {
  kSettled,  // pull_scale * command
  kLagged,   // pull_scale * (command - lag), one lag per tentacle and trial
  kFree,     // fitted for this frame alone
};

struct FitFrame {
  std::size_t observation = 0;  // index into the caller's observations
  const FoldObservation* observed = nullptr;
  const TentacleLayout* layout = nullptr;
  int trial = 0;
  double commanded_pull = 0;
  FoldLaw law = FoldLaw::kPaper;
  bool by_rest_angle = false;  // free in the model
  bool by_friction = false;
  double reach = 0;  // the law's largest pull
  SeenNodes seen;
  PullSource source = PullSource::kSettled;
  int nuisance = -1;  // index of its lag or free pull; -1: none
};

struct FitFrames {
  std::vector<FitFrame> frames;
  std::map<std::string, TentacleLayout> layouts;  // by the design's numbers; frames point into it
  std::vector<std::string> trials;
  std::vector<double> nuisance_start;  // lag (pull fraction) or free pull
  std::vector<PullSource> nuisance_kind;
  std::vector<LeftOut> left_out;
};

//   errors  kBadInput as FitFold
Result<FitFrames> PrepareFrames(std::span<const FoldObservation> observations, const FoldFitOptions& options);

// What all frames share, as the solver sees it: pull_scale, ln stiffness_ratio, stiffness_exponent, rest
// angle (rad), friction; then the two scatters (nuisances).
inline constexpr int kShared = kFoldParameters + kScatters;
using SharedVector = Eigen::Matrix<double, kShared, 1>;
using SharedMatrix = Eigen::Matrix<double, kShared, kShared>;

// A frame's residual with its derivatives by what all frames share and by its nuisance.
struct FrameResidual {
  int group = 1;
  Eigen::VectorXd value;  // in sigmas                                  (rows)
  Eigen::Matrix<double, Eigen::Dynamic, kShared> slope;
  Eigen::VectorXd nuisance_slope;  // zero where the frame has none              (rows)
};

// A frame's lag or free pull; 0 where it has none.
double NuisanceOf(const FitFrame& frame, const std::vector<double>& nuisances);

// The tentacle's pull in a frame. None: negative, or beyond reach.
std::optional<double> EffectivePull(const FitFrame& frame, const SharedVector& parameters, double nuisance);

// The model's fold in a frame. None where the pull cannot be.
std::optional<FoldTangent> FoldOf(const FitFrame& frame, const SharedVector& parameters, double nuisance);

// The same where the model's nodes are known.
FrameResidual ResidualOfFrame(const FitFrame& frame, const NodeMotion& motion, const SharedVector& parameters,
                              double nuisance, const ShapeResidualOptions& options);

// None where the pull cannot be.
std::optional<FrameResidual> EvaluateFrame(const FitFrame& frame, const SharedVector& parameters,
                                           double nuisance, const ShapeResidualOptions& options);

}  // namespace tendril
