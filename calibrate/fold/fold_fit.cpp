#include "calibrate/fold/fold_fit.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <utility>

#include "calibrate/fold/fit_run.h"
#include "calibrate/fold/pull_hint.h"
#include "calibrate/student_t.h"
#include "model/median.h"

namespace tendril {
namespace {

std::string NameOfShared(int parameter) {
  if (parameter < kFoldParameters) return FoldParameterNames()[static_cast<std::size_t>(parameter)];
  return parameter == kFoldParameters ? "the scatter of the nodes" : "the scatter of the creases";
}

constexpr double kDegree = std::numbers::pi / 180;

// What the misfit looks like: per group of rows over all frames, and per frame.
struct Misfit {
  double group_scale = 0;         // robust standard deviation of a row, sigmas
  std::vector<double> frame_rms;  // per row, sigmas                                 (frames)
};

Misfit MisfitAt(const FitFrames& frames, const Solution& solution, const ShapeResidualOptions& options) {
  Misfit misfit;
  std::vector<double> lengths;
  int group = 1;
  for (const FitFrame& frame : frames.frames) {
    const std::optional<FrameResidual> at =
        EvaluateFrame(frame, solution.parameters, NuisanceOf(frame, solution.nuisances), options);
    if (!at) {
      misfit.frame_rms.push_back(0);
      continue;
    }
    group = at->group;
    for (Eigen::Index row = 0; row < at->value.size(); row += group) {
      lengths.push_back(at->value.segment(row, group).norm());
    }
    misfit.frame_rms.push_back(std::sqrt(at->value.squaredNorm() / static_cast<double>(at->value.size())));
  }
  // Medians of the chi distribution with one and three degrees of freedom.
  misfit.group_scale = (lengths.empty() ? 0 : Median(std::move(lengths))) / (group == 3 ? 1.5382 : 0.6745);
  return misfit;
}

double HuberLength(const FoldFitOptions& options, double scale) {
  const bool positions = options.residual.kind == ShapeResidualKind::kAlignedWindows;
  return options.huber * std::max(scale, 0.05) * (positions ? std::sqrt(3.0) : 1.0);
}

// Frames that no setting of the parameters explains, moved from the used to the left out.
int DropOutlierFrames(FitFrames& frames, const Misfit& misfit, const FoldFitOptions& options) {
  const double usual = misfit.frame_rms.empty() ? 0.2 : std::max(Median(misfit.frame_rms), 0.2);
  std::vector<FitFrame> kept;
  int dropped = 0;
  for (std::size_t i = 0; i < frames.frames.size(); ++i) {
    if (misfit.frame_rms[i] <= options.outlier_frame * usual) {
      kept.push_back(std::move(frames.frames[i]));
      continue;
    }
    ++dropped;
    frames.left_out.push_back(
        {frames.frames[i].observation,
         fmt::format("its shape is {:.1f} times as far from the model as the median frame's",
                     misfit.frame_rms[i] / usual)});
  }
  frames.frames = std::move(kept);
  return dropped;
}

std::string WhyUnidentified(const FitFrames& frames, const FoldFitOptions& options, const Unidentified& one) {
  double largest_pull = 0;
  double widest = 0;
  double narrowest = std::numeric_limits<double>::infinity();
  int creases = 0;
  bool settled = false;
  for (const FitFrame& frame : frames.frames) {
    largest_pull = std::max(largest_pull, frame.commanded_pull);
    widest = std::max(widest, frame.layout->width.maxCoeff());
    narrowest = std::min(narrowest, frame.layout->width.minCoeff());
    creases = std::max(creases, static_cast<int>(frame.layout->width.size()));
    settled = settled || (frame.source != PullSource::kFree && frame.commanded_pull > 0);
  }
  if (largest_pull == 0) return "every frame's commanded pull is 0: the tentacles are flat";
  if (one.parameter == 0 && !settled) {
    return fmt::format(
        "in no frame has the command stood still, or kept its rate, for {} s: the tentacles' lag "
        "hides their pull",
        options.longest_lag);
  }
  if (one.parameter == 1 && creases < 2) return "the tentacles have a single crease";
  if (one.parameter == 2 && widest - narrowest <= 1e-9 * widest) {
    return fmt::format("the tentacles do not taper: every crease is {:.3g} mm wide", 1e3 * widest);
  }
  if (one.twin >= 0) {
    return fmt::format("these shapes do not tell it from {}", NameOfShared(one.twin));
  }
  return fmt::format("the shapes hardly depend on it at the pulls observed (up to {:.3g})", largest_pull);
}

void FillParameter(FittedParameter& parameter, int index, double value, double variance, double quantile) {
  const double error = std::sqrt(variance);
  parameter.value = ShownValue(index, value);
  parameter.standard_error = index == kLogRatio    ? parameter.value * error
                             : index == kRestAngle ? error / kDegree
                                                   : error;
  // The ratio is fitted as its logarithm: the interval is that of the logarithm, and so never reaches 0.
  const double low = value - quantile * error;
  const bool from_zero = index == kRestAngle || index == kFriction;
  parameter.interval = {ShownValue(index, from_zero ? std::max(low, 0.0) : low),
                        ShownValue(index, value + quantile * error)};
}

// The covariance of what was fitted, of the model's parameters as they are shown.
Eigen::MatrixXd ShownCovariance(const SharedMatrix& covariance, const std::vector<int>& shown, double ratio) {
  const Eigen::Index n = static_cast<Eigen::Index>(shown.size());
  const auto factor = [&](int i) { return i == kLogRatio ? ratio : i == kRestAngle ? 1 / kDegree : 1; };
  Eigen::MatrixXd out(n, n);
  for (Eigen::Index a = 0; a < n; ++a) {
    for (Eigen::Index b = 0; b < n; ++b) {
      const int i = shown[static_cast<std::size_t>(a)];
      const int j = shown[static_cast<std::size_t>(b)];
      out(a, b) = factor(i) * factor(j) * covariance(i, j);
    }
  }
  return out;
}

double ResidualRms(const FitFrames& frames, const Solution& solution) {
  double squares = 0;
  double nodes = 0;
  for (const FitFrame& frame : frames.frames) {
    const std::optional<FoldTangent> fold =
        FoldOf(frame, solution.parameters, NuisanceOf(frame, solution.nuisances));
    if (!fold) continue;
    const double rms = AlignedRms(MoveNodes(*frame.layout, *fold).nodes, frame.seen);
    const double count = static_cast<double>(frame.seen.index.size());
    squares += rms * rms * count;
    nodes += count;
  }
  return nodes > 0 ? std::sqrt(squares / nodes) : 0;
}

Status CheckOptions(const FoldFitOptions& o) {
  const auto wrong = [](const char* field, double value, const char* expected) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("fit option {} is {}; expected {}", field, value, expected)};
  };
  if (o.residual.window < 4) return wrong("window", o.residual.window, "4 nodes or more");
  if (!(o.residual.model_error > 0))
    return wrong("model_error", o.residual.model_error, "a length above 0 m");
  if (!(o.longest_lag >= 0)) return wrong("longest_lag", o.longest_lag, "a time of 0 s or more");
  if (!(o.unknown_sigma > 0)) return wrong("unknown_sigma", o.unknown_sigma, "a length above 0 m");
  if (o.fewest_nodes < 4) return wrong("fewest_nodes", o.fewest_nodes, "4 or more");
  if (!(o.outlier_frame > 1)) return wrong("outlier_frame", o.outlier_frame, "a factor above 1");
  if (!(o.huber > 0)) return wrong("huber", o.huber, "a factor above 0");
  if (!(o.confidence > 0 && o.confidence < 1))
    return wrong("confidence", o.confidence, "a share between 0 and 1");
  if (o.iterations < 1) return wrong("iterations", o.iterations, "1 or more");
  if (!(o.start_pull_scale > 0)) return wrong("start_pull_scale", o.start_pull_scale, "a factor above 0");
  if (o.start_ratio <= 0) return wrong("start_ratio", o.start_ratio, "a factor above 0");
  return Ok{};
}

Error NothingUsable(const FitFrames& frames, std::span<const FoldObservation> observations) {
  std::string reasons;
  for (std::size_t i = 0; i < std::min<std::size_t>(3, frames.left_out.size()); ++i) {
    const LeftOut& out = frames.left_out[i];
    reasons +=
        fmt::format("{}trial {} tentacle {}: {}", i == 0 ? "" : "; ", observations[out.observation].trial,
                    observations[out.observation].tentacle, out.reason);
  }
  return {ErrorKind::kBadInput,
          fmt::format("none of the {} observed curves can be used: {}", observations.size(), reasons)};
}

}  // namespace

double ShownValue(int parameter, double fitted) {
  return parameter == kLogRatio ? std::exp(fitted) : parameter == kRestAngle ? fitted / kDegree : fitted;
}

double FittedValue(int parameter, double shown) {
  return parameter == kLogRatio ? std::log(shown) : parameter == kRestAngle ? shown * kDegree : shown;
}

Result<FoldFit> FitFold(std::span<const FoldObservation> observations, const FoldFitOptions& options,
                        const Progress& progress) {
  Result<FitRun> run = RunFit(observations, options, progress);
  if (!run.ok()) return run.error();
  run.value().fit.hint = HintOf(run.value(), options);
  return std::move(run.value().fit);
}

Result<FitRun> RunFit(std::span<const FoldObservation> observations, const FoldFitOptions& options,
                      const Progress& progress) {
  const auto started = std::chrono::steady_clock::now();
  if (const Status s = CheckOptions(options); !s.ok()) return s.error();
  if (observations.empty())
    return Error{ErrorKind::kBadInput, "no observed curves to fit; expected one or more"};
  Result<FitFrames> prepared = PrepareFrames(observations, options);
  if (!prepared.ok()) return prepared.error();
  FitFrames frames = std::move(prepared).value();
  if (frames.frames.empty()) return NothingUsable(frames, observations);

  const TentacleDesign& first = frames.frames.front().observed->design;
  Solution solution;
  const double ratio = std::isnan(options.start_ratio) ? first.stiffness_ratio : options.start_ratio;
  const double exponent =
      std::isnan(options.start_exponent) ? first.stiffness_exponent : options.start_exponent;
  if (!(ratio > 0) || !std::isfinite(ratio) || !std::isfinite(exponent)) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("design: stiffness_ratio {}, stiffness_exponent {}; expected a "
                             "finite ratio above 0 and a finite exponent",
                             ratio, exponent)};
  }
  SharedVector start = SharedVector::Zero();
  const bool exact = options.model.law == FoldLaw::kExact;
  const auto from_zero = [](bool free, double wanted, double designed, double else_at) {
    if (!free) return designed;
    return std::isfinite(wanted) ? wanted : designed > 0 ? designed : else_at;
  };
  const double rest =
      from_zero(options.model.rest_angle, options.start_rest_angle, exact ? first.rest_angle : 0, 0.05);
  const double friction =
      from_zero(options.model.friction, options.start_friction, exact ? first.tendon_friction : 0, 0.03);
  if (!(rest >= 0 && rest < 0.95 * first.closed_angle) || !(friction >= 0) || !std::isfinite(friction)) {
    return Error{
        ErrorKind::kBadInput,
        fmt::format("design: rest angle {} rad, friction {}; expected an angle from 0 to below {} rad "
                    "and a friction of 0 or more",
                    rest, friction, 0.95 * first.closed_angle)};
  }
  start.head<kFoldParameters>() << options.start_pull_scale, std::log(ratio), exponent, rest, friction;
  SharedVector fallback = start;  // what is held where the data cannot tell: the design's
  if (options.model.rest_angle) fallback[kRestAngle] = exact ? first.rest_angle : 0;
  if (options.model.friction) fallback[kFriction] = exact ? first.tendon_friction : 0;
  solution.parameters = start;
  solution.nuisances = frames.nuisance_start;

  FoldFit fit;
  HeldParameters held{};
  held[kRestAngle] = !options.model.rest_angle;
  held[kFriction] = !options.model.friction;
  std::array<std::string, kShared> why;
  const auto hold = [&](const std::vector<Unidentified>& found) {
    for (const Unidentified& one : found) {
      const std::size_t i = static_cast<std::size_t>(one.parameter);
      held[i] = true;
      solution.parameters[one.parameter] = fallback[one.parameter];
      why[i] = WhyUnidentified(frames, options, one);
    }
    return !found.empty();
  };
  double huber = 3 * HuberLength(options, 1);
  hold(FindUnidentified(
      InformationAt(frames, solution.parameters, solution.nuisances, options.residual, huber), 1, held));

  // A first look with a wide loss gives the scale of the misfit; the second is the fit. What turns out
  // unidentified only there is held, and the fit made again.
  if (const Status s = SolveFit(frames, held, huber, {options, progress, 0, 0.4, 15}, solution); !s.ok())
    return s.error();
  const int dropped = DropOutlierFrames(frames, MisfitAt(frames, solution, options.residual), options);
  if (dropped > 0) {
    fit.warnings.push_back(
        fmt::format("{} frames left out: their shapes are too far from the model's", dropped));
  }
  Information information;
  for (int round = 0; round <= kShared; ++round) {
    huber = HuberLength(options, MisfitAt(frames, solution, options.residual).group_scale);
    if (const Status s = SolveFit(frames, held, huber, {options, progress, 0.4, 1}, solution); !s.ok())
      return s.error();
    information = InformationAt(frames, solution.parameters, solution.nuisances, options.residual, huber);
    if (!hold(FindUnidentified(information, information.row_variance, held))) break;
  }

  fit.trials = 0;
  for (const TrialInformation& trial : information.trials)
    fit.trials += trial.information.trace() > 0 ? 1 : 0;
  const SharedMatrix naive = NaiveCovariance(information, information.row_variance, held);
  fit.clustered = fit.trials > 1;
  HeldParameters at_bound{};
  for (const int i : {kRestAngle, kFriction}) {
    const std::size_t at = static_cast<std::size_t>(i);
    at_bound[at] = !held[at] && solution.parameters[i] < 1e-7;
  }
  const SharedMatrix covariance = fit.clustered ? ClusteredCovariance(information, held, at_bound) : naive;
  fit.degrees_of_freedom = std::max(1, fit.trials - 1);
  const double quantile = fit.clustered
                              ? StudentTQuantile(0.5 + options.confidence / 2, fit.degrees_of_freedom)
                              : StudentTQuantile(0.5 + options.confidence / 2, 1e6);
  const std::vector<int> shown = FreeParametersOf(options.model);
  for (const int i : shown) {
    const std::size_t at = static_cast<std::size_t>(i);
    FittedParameter& parameter = fit.parameters.emplace_back();
    parameter.name = NameOfShared(i);
    parameter.value = ShownValue(i, solution.parameters[i]);
    parameter.at_bound = at_bound[at];
    if (!held[at] && std::isfinite(covariance(i, i))) {
      FillParameter(parameter, i, solution.parameters[i], covariance(i, i), quantile);
      const double most = LargestStandardErrors()[at];
      parameter.identified = std::sqrt(covariance(i, i)) <= most;
      if (!parameter.identified) {
        parameter.why = fmt::format("the trials disagree: its standard error, {:.2g}, is above {:.2g}",
                                    std::sqrt(covariance(i, i)), most);
      }
    } else {
      parameter.why =
          held[at] ? why[at] : "only one of the trials tells of it: no standard error between trials";
    }
    if (!parameter.identified) {
      fit.warnings.push_back(fmt::format("{} is not identified{}: {}", parameter.name,
                                         held[at] ? fmt::format(" (held at {:.6g})", parameter.value) : "",
                                         parameter.why));
    }
  }
  if (!fit.clustered) {
    fit.warnings.push_back(
        "one trial only: standard errors take every node as independent and are too small; record more "
        "trials");
  } else if (fit.trials < 4) {
    fit.warnings.push_back(fmt::format(
        "{} trials only: their scatter, which standard errors rest on, is hardly known; record more trials",
        fit.trials));
  }
  fit.covariance = ShownCovariance(covariance, shown, fit.parameters[1].value);
  fit.naive_covariance = ShownCovariance(naive, shown, fit.parameters[1].value);
  fit.model = options.model;
  fit.scatter = {solution.parameters[kFoldParameters], solution.parameters[kFoldParameters + 1]};
  fit.residual_rms = ResidualRms(frames, solution);
  fit.frames_used = static_cast<int>(frames.frames.size());
  fit.frames_settled =
      static_cast<int>(std::count_if(frames.frames.begin(), frames.frames.end(),
                                     [](const FitFrame& f) { return f.source == PullSource::kSettled; }));
  fit.left_out = frames.left_out;
  fit.iterations = solution.iterations;
  fit.converged = solution.converged;
  fit.message = solution.message;
  if (!fit.converged) fit.warnings.push_back(fmt::format("the fit did not converge: {}", fit.message));
  fit.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  return FitRun{.fit = std::move(fit),
                .frames = std::move(frames),
                .solution = std::move(solution),
                .held = held,
                .at_bound = at_bound,
                .information = std::move(information),
                .huber = huber};
}

}  // namespace tendril
