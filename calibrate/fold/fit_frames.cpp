#include "calibrate/fold/fit_frames.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "model/fold/rising_fold.h"

namespace tendril {
namespace {

// Equal for designs that lay out alike.
std::string KeyOf(const TentacleDesign& d) {
  return fmt::format("{} {} {} {} {} {} {} {} {}", d.length, d.base_width, d.taper, d.unit_length,
                     d.spacing_ratio, d.alpha, d.beta, d.holes, d.closed_angle);
}

SeenNodes SeenIn(const FoldObservation& observation, double unknown_sigma) {
  std::vector<int> index;
  for (Eigen::Index i = 0; i < observation.curve.points.cols(); ++i) {
    const bool seen = observation.curve.points.col(i).allFinite() &&
                      (observation.sigma.size() == 0 ||
                       (std::isfinite(observation.sigma[i]) && observation.sigma[i] >= 0)) &&
                      (observation.interpolated.size() == 0 || observation.interpolated[i] == 0);
    if (seen) index.push_back(static_cast<int>(i));
  }
  SeenNodes nodes;
  const Eigen::Index n = static_cast<Eigen::Index>(index.size());
  nodes.index.resize(n);
  nodes.points.resize(3, n);
  nodes.sigma.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const int node = index[static_cast<std::size_t>(i)];
    nodes.index[i] = node;
    nodes.points.col(i) = observation.curve.points.col(node);
    nodes.sigma[i] = observation.sigma.size() == 0 ? unknown_sigma : observation.sigma[node];
  }
  return nodes;
}

// What is wrong with the call itself, as against a frame that merely cannot be used.
std::optional<Error> WrongSizes(const FoldObservation& o, std::size_t index) {
  const auto wrong = [&](const std::string& what) {
    return Error{ErrorKind::kBadInput, fmt::format("observation {} (trial {}, tentacle {}, {:.3f} s): {}",
                                                   index, o.trial, o.tentacle, o.time, what)};
  };
  const Eigen::Index nodes = o.curve.points.cols();
  if (nodes != o.design.holes) {
    return wrong(
        fmt::format("curve has {} nodes; expected one per hole of its design, {}", nodes, o.design.holes));
  }
  if (o.sigma.size() != 0 && o.sigma.size() != nodes) {
    return wrong(fmt::format("sigma has {} entries; expected {} or none", o.sigma.size(), nodes));
  }
  if (o.interpolated.size() != 0 && o.interpolated.size() != nodes) {
    return wrong(
        fmt::format("interpolated has {} entries; expected {} or none", o.interpolated.size(), nodes));
  }
  if (o.cameras.size() != 0 && o.cameras.size() != nodes)
    return wrong(fmt::format("cameras has {} entries; expected {} or none", o.cameras.size(), nodes));
  if (o.further.size() != 0 && o.further.cols() != nodes)
    return wrong(fmt::format("further has {} columns; expected {} or none", o.further.cols(), nodes));
  if (o.covariance_factor.size() != 0 && o.covariance_factor.rows() != 3 * nodes) {
    return wrong(fmt::format("covariance factor has {} rows; expected {} or none", o.covariance_factor.rows(),
                             3 * nodes));
  }
  return std::nullopt;
}

struct Lag {
  int frames = 0;
  int nuisance = -1;
};

// Decides how each frame's pull follows from its command (fold_fit.h says by which rule).
void ChoosePullSources(std::span<const FoldObservation> observations, const FoldFitOptions& options,
                       FitFrames& prepared) {
  using Key = std::pair<int, int>;  // trial, tentacle
  const auto key_of = [&](const FitFrame& frame) {
    return Key{frame.trial, observations[frame.observation].tentacle};
  };
  const auto settled = [&](const FitFrame& frame) {
    return observations[frame.observation].settled_for >= options.longest_lag;
  };
  std::map<Key, bool> has_settled;
  std::map<Key, Lag> lags;
  for (const FitFrame& frame : prepared.frames) {
    if (settled(frame) && frame.commanded_pull > 0) has_settled[key_of(frame)] = true;
  }
  const auto lagged = [&](const FitFrame& frame) {
    const FoldObservation& o = observations[frame.observation];
    return !settled(frame) && !has_settled.contains(key_of(frame)) && o.steady_for >= options.longest_lag;
  };
  for (const FitFrame& frame : prepared.frames) {
    if (lagged(frame)) ++lags[key_of(frame)].frames;
  }
  const auto new_nuisance = [&](PullSource kind, double start) {
    prepared.nuisance_kind.push_back(kind);
    prepared.nuisance_start.push_back(start);
    return static_cast<int>(prepared.nuisance_kind.size()) - 1;
  };
  for (FitFrame& frame : prepared.frames) {
    if (settled(frame)) continue;
    if (lagged(frame)) {
      frame.source = PullSource::kLagged;
      Lag& lag = lags[key_of(frame)];
      if (lag.nuisance < 0) lag.nuisance = new_nuisance(PullSource::kLagged, 0);
      frame.nuisance = lag.nuisance;
      continue;
    }
    frame.source = PullSource::kFree;
    const double start =
        std::clamp(options.start_pull_scale * frame.commanded_pull, 1e-4 * frame.reach, 0.9 * frame.reach);
    frame.nuisance = new_nuisance(PullSource::kFree, start);
  }
}

}  // namespace

Result<FitFrames> PrepareFrames(std::span<const FoldObservation> observations,
                                const FoldFitOptions& options) {
  FitFrames prepared;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const FoldObservation& o = observations[i];
    if (auto wrong = WrongSizes(o, i)) return *wrong;
    const auto leave_out = [&](std::string reason) { prepared.left_out.push_back({i, std::move(reason)}); };
    if (!std::isfinite(o.commanded_pull) || o.commanded_pull < 0) {
      leave_out(fmt::format("commanded pull {} is not a fraction", o.commanded_pull));
      continue;
    }
    if (options.model.friction && o.released) {
      leave_out("the command had gone back before: with friction the fit knows rising pulls only");
      continue;
    }
    auto [place, fresh] = prepared.layouts.try_emplace(KeyOf(o.design));
    if (fresh) {
      Result<TentacleLayout> layout = LayOut(o.design);
      if (!layout.ok()) return Error(layout.error()).Within(fmt::format("trial {}: design", o.trial));
      place->second = std::move(layout).value();
    }
    const double reach = LargestPullOf(options.model.law, place->second, o.design.closed_angle);
    if (options.start_pull_scale * o.commanded_pull >= reach) {
      leave_out(
          fmt::format("commanded pull {:.4g} is beyond the design's reach, {:.4g}", o.commanded_pull, reach));
      continue;
    }
    FitFrame frame;
    frame.seen = SeenIn(o, options.unknown_sigma);
    if (frame.seen.index.size() < options.fewest_nodes) {
      leave_out(fmt::format("{} of {} nodes seen; {} are needed", frame.seen.index.size(), o.design.holes,
                            options.fewest_nodes));
      continue;
    }
    if (ResidualRows(frame.seen, o.design.holes, options.residual) == 0) {
      leave_out("the seen nodes lie too far apart to compare shapes");
      continue;
    }
    frame.layout = &place->second;
    frame.observed = &o;
    frame.observation = i;
    frame.commanded_pull = o.commanded_pull;
    frame.law = options.model.law;
    frame.by_rest_angle = options.model.rest_angle;
    frame.by_friction = options.model.friction;
    frame.reach = reach;
    const auto trial = std::find(prepared.trials.begin(), prepared.trials.end(), o.trial);
    frame.trial = static_cast<int>(trial - prepared.trials.begin());
    if (trial == prepared.trials.end()) prepared.trials.push_back(o.trial);
    prepared.frames.push_back(std::move(frame));
  }
  ChoosePullSources(observations, options, prepared);
  return prepared;
}

double NuisanceOf(const FitFrame& frame, const std::vector<double>& nuisances) {
  return frame.nuisance < 0 ? 0 : nuisances[static_cast<std::size_t>(frame.nuisance)];
}

std::optional<double> EffectivePull(const FitFrame& frame, const SharedVector& parameters, double nuisance) {
  double pull = nuisance;
  if (frame.source == PullSource::kSettled) pull = parameters[0] * frame.commanded_pull;
  if (frame.source == PullSource::kLagged) pull = parameters[0] * (frame.commanded_pull - nuisance);
  if (!(pull >= 0) || pull > frame.reach) return std::nullopt;
  return pull;
}

std::optional<FoldTangent> FoldOf(const FitFrame& frame, const SharedVector& parameters, double nuisance) {
  const std::optional<double> pull = EffectivePull(frame, parameters, nuisance);
  if (!pull) return std::nullopt;
  Result<FoldTangent> fold = FoldAt(frame.observed->design, *frame.layout,
                                    {.effective_pull = *pull,
                                     .log_ratio = parameters[1],
                                     .exponent = parameters[2],
                                     .rest_angle = parameters[3],
                                     .friction = parameters[4],
                                     .law = frame.law,
                                     .by_rest_angle = frame.by_rest_angle,
                                     .by_friction = frame.by_friction});
  if (!fold.ok()) return std::nullopt;
  return std::move(fold).value();
}

std::optional<FrameResidual> EvaluateFrame(const FitFrame& frame, const SharedVector& parameters,
                                           double nuisance, const ShapeResidualOptions& options) {
  const std::optional<FoldTangent> fold = FoldOf(frame, parameters, nuisance);
  if (!fold) return std::nullopt;
  return ResidualOfFrame(frame, MoveNodes(*frame.layout, *fold), parameters, nuisance, options);
}

FrameResidual ResidualOfFrame(const FitFrame& frame, const NodeMotion& motion, const SharedVector& parameters,
                              double nuisance, const ShapeResidualOptions& options) {
  ShapeResidual shape =
      ResidualOf(motion, frame.seen, options, {parameters[kFoldParameters], parameters[kFoldParameters + 1]});

  FrameResidual residual;
  residual.group = shape.group;
  residual.value = std::move(shape.value);
  residual.slope = shape.slope;
  residual.nuisance_slope.setZero(residual.value.size());
  const Eigen::VectorXd by_pull = shape.slope.col(kEffectivePull);
  switch (frame.source) {
    case PullSource::kSettled:
      residual.slope.col(0) = frame.commanded_pull * by_pull;
      break;
    case PullSource::kLagged:
      residual.slope.col(0) = (frame.commanded_pull - nuisance) * by_pull;
      residual.nuisance_slope = -parameters[0] * by_pull;
      break;
    case PullSource::kFree:
      residual.slope.col(0).setZero();
      residual.nuisance_slope = by_pull;
      break;
  }
  return residual;
}

}  // namespace tendril
