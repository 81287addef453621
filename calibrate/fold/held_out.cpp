#include "calibrate/fold/held_out.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace tendril {
namespace {

TrialMisfit MisfitOf(const FitRun& run, std::size_t trial, const SharedVector& parameters,
                     const std::vector<double>& nuisances, const FoldFitOptions& options) {
  TrialMisfit misfit;
  for (const FitFrame& frame : run.frames.frames) {
    if (static_cast<std::size_t>(frame.trial) != trial) continue;
    const std::optional<FrameResidual> at =
        EvaluateFrame(frame, parameters, NuisanceOf(frame, nuisances), options.residual);
    if (!at) continue;
    misfit.observation.push_back(frame.observation);
    std::vector<double>& lengths = misfit.residual.emplace_back();
    for (Eigen::Index row = 0; row < at->value.size(); row += at->group) {
      lengths.push_back(at->value.segment(row, at->group).norm());
    }
  }
  return misfit;
}

}  // namespace

double HuberLoss(double residual, double huber) {
  const double size = std::abs(residual);
  return size <= huber ? size * size : huber * (2 * size - huber);
}

SharedVector ParametersWithout(const FitRun& run, std::size_t trial) {
  HeldParameters held = run.held;
  for (std::size_t i = 0; i < held.size(); ++i) held[i] = held[i] || run.at_bound[i];
  SharedVector change = ChangeWithout(run.information, trial, held);
  if (!change.allFinite()) change.setZero();
  SharedVector parameters = run.solution.parameters + change;
  for (const int i : {kRestAngle, kFriction}) parameters[i] = std::max(parameters[i], 0.0);
  return parameters;
}

std::vector<double> NuisancesAt(const FitRun& run, std::size_t trial, const SharedVector& parameters,
                                const FoldFitOptions& options) {
  std::vector<double> nuisances = run.solution.nuisances;
  std::map<int, std::vector<const FitFrame*>> frames;
  for (const FitFrame& frame : run.frames.frames) {
    if (static_cast<std::size_t>(frame.trial) == trial && frame.nuisance >= 0) {
      frames[frame.nuisance].push_back(&frame);
    }
  }
  for (const auto& [nuisance, of] : frames) {
    double& value = nuisances[static_cast<std::size_t>(nuisance)];
    for (int step = 0; step < 4; ++step) {
      double score = 0;
      double information = 0;
      double most = std::numeric_limits<double>::infinity();
      for (const FitFrame* frame : of) {
        const std::optional<FrameResidual> at = EvaluateFrame(*frame, parameters, value, options.residual);
        if (!at) continue;
        if (frame->source == PullSource::kFree) most = frame->reach;
        for (Eigen::Index row = 0; row < at->value.size(); row += at->group) {
          const auto r = at->value.segment(row, at->group);
          const auto slope = at->nuisance_slope.segment(row, at->group);
          const double weight = std::min(1.0, run.huber / std::max(r.norm(), 1e-300));
          score += weight * slope.dot(r);
          information += weight * slope.squaredNorm();
        }
      }
      if (!(information > 0)) break;
      double next = value - score / information;
      if (std::isfinite(most)) next = std::clamp(next, std::min(1e-9, value), most);
      if (!std::isfinite(next)) break;
      const bool done = std::abs(next - value) < 1e-9;
      value = next;
      if (done) break;
    }
  }
  return nuisances;
}

Misfits MisfitsOf(const FitRun& run, const FoldFitOptions& options) {
  Misfits misfits;
  for (std::size_t trial = 0; trial < run.frames.trials.size(); ++trial) {
    misfits.fitted.push_back(MisfitOf(run, trial, run.solution.parameters, run.solution.nuisances, options));
    if (run.fit.trials < 2) continue;
    const SharedVector without = ParametersWithout(run, trial);
    misfits.held_out.push_back(
        MisfitOf(run, trial, without, NuisancesAt(run, trial, without, options), options));
  }
  return misfits;
}

}  // namespace tendril
