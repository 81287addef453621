#include "calibrate/fold/fold_profile.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibrate/fold/fit_run.h"
#include "calibrate/fold/held_out.h"
#include "calibrate/student_t.h"
#include "model/check.h"

namespace tendril {
namespace {

// Infinite where a frame's pull cannot be.
double LossAt(const FitRun& run, const Solution& solution, const FoldFitOptions& options) {
  double loss = 0;
  for (const FitFrame& frame : run.frames.frames) {
    const std::optional<FrameResidual> at =
        EvaluateFrame(frame, solution.parameters, NuisanceOf(frame, solution.nuisances), options.residual);
    if (!at) return std::numeric_limits<double>::infinity();
    for (Eigen::Index row = 0; row < at->value.size(); row += at->group) {
      loss += HuberLoss(at->value.segment(row, at->group).norm(), run.huber);
    }
  }
  return loss;
}

// Where the deviance reaches the threshold between two neighbours.
double Crossing(double inside, double outside, double low, double high, double threshold) {
  // In the root of the deviance a parabola is a line.
  const double a = std::sqrt(std::max(low, 0.0));
  const double b = std::sqrt(std::max(high, 0.0));
  return inside +
         (outside - inside) * std::clamp((std::sqrt(threshold) - a) / std::max(b - a, 1e-300), 0.0, 1.0);
}

}  // namespace

Result<FoldProfile> ProfileFold(std::span<const FoldObservation> observations, const FoldFitOptions& options,
                                const std::string& name, const Progress& progress) {
  const auto& names = FoldParameterNames();
  const int parameter = static_cast<int>(std::find(names.begin(), names.end(), name) - names.begin());
  const std::vector<int> free = FreeParametersOf(options.model);
  if (std::find(free.begin(), free.end(), parameter) == free.end()) {
    std::string known;
    for (const int p : free)
      known += (known.empty() ? "" : ", ") + std::string(names[static_cast<std::size_t>(p)]);
    return Error{ErrorKind::kBadInput, fmt::format("profile of {}: model {} has no such parameter; it has {}",
                                                   name, NameOf(options.model), known)};
  }
  const auto part = [&](double from, double to) {
    return Progress(
        [&progress, from, to](double done) { return !progress || progress(from + (to - from) * done); });
  };
  Result<FitRun> fitted = RunFit(observations, options, part(0, 0.3));
  if (!fitted.ok()) return fitted.error();
  FitRun& run = fitted.value();
  FoldProfile profile;
  profile.name = name;
  profile.fit = run.fit;
  const auto found = std::find_if(run.fit.parameters.begin(), run.fit.parameters.end(),
                                  [&](const FittedParameter& p) { return p.name == name; });
  TENDRIL_CHECK(found != run.fit.parameters.end());
  const std::size_t at = static_cast<std::size_t>(parameter);
  if (run.held[at] || !std::isfinite(found->standard_error)) {
    return Error{ErrorKind::kBadInput, fmt::format("profile of {}: not identified: {}", name, found->why)};
  }
  const SharedMatrix clustered =
      run.fit.clustered ? ClusteredCovariance(run.information, run.held, run.at_bound)
                        : NaiveCovariance(run.information, run.information.row_variance, run.held);
  const SharedMatrix alone = NaiveCovariance(run.information, 1, run.held) / run.information.repeats;
  const double error = std::sqrt(clustered(parameter, parameter));
  const double inflation = clustered(parameter, parameter) / alone(parameter, parameter);
  const double quantile =
      StudentTQuantile(0.5 + options.confidence / 2, run.fit.clustered ? run.fit.degrees_of_freedom : 1e6);
  profile.threshold = quantile * quantile;

  HeldParameters held = run.held;
  held[at] = true;
  const bool has_bound = parameter == kRestAngle || parameter == kFriction;
  const double estimate = run.solution.parameters[parameter];
  const double base = LossAt(run, run.solution, options);
  struct Point {
    double value, deviance;
  };
  std::vector<Point> points = {{estimate, 0}};
  double done = 0;
  for (const double sign : {-1.0, 1.0}) {
    Solution solution = run.solution;
    for (int i = 1; i <= 12; ++i) {
      double value = estimate + sign * 0.5 * quantile * error * (i <= 4 ? i : 2 * i - 4);
      const bool at_end = has_bound && value <= 0;
      if (at_end) value = 0;
      if (at_end && estimate <= 1e-7) break;
      solution.parameters[parameter] = value;
      if (!std::isfinite(LossAt(run, solution, options))) break;  // beyond the reach of some frame
      FoldFitOptions few = options;
      few.iterations = 30;
      const Progress go = part(0.3 + 0.7 * done, std::min(1.0, 0.3 + 0.7 * (done + 0.05)));
      done = std::min(done + 0.05, 0.95);
      if (const Status s = SolveFit(run.frames, held, run.huber, {few, go, 0, 1}, solution); !s.ok())
        return s.error();
      const double deviance = (LossAt(run, solution, options) - base) / inflation;
      points.push_back({value, std::max(deviance, 0.0)});
      if (deviance > 2 * profile.threshold || at_end) break;
    }
  }
  std::sort(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.value < b.value; });
  const std::size_t middle = static_cast<std::size_t>(
      std::find_if(points.begin(), points.end(), [&](const Point& p) { return p.value == estimate; }) -
      points.begin());
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  double low = kNaN, high = kNaN;
  for (std::size_t i = middle; i-- > 0;) {
    if (points[i].deviance < profile.threshold) continue;
    low = Crossing(points[i + 1].value, points[i].value, points[i + 1].deviance, points[i].deviance,
                   profile.threshold);
    break;
  }
  for (std::size_t i = middle + 1; i < points.size(); ++i) {
    if (points[i].deviance < profile.threshold) continue;
    high = Crossing(points[i - 1].value, points[i].value, points[i - 1].deviance, points[i].deviance,
                    profile.threshold);
    break;
  }
  if (std::isnan(low) && has_bound && points.front().value <= 1e-7) {
    low = 0;
    profile.from_bound = true;
  }
  profile.interval = {ShownValue(parameter, low), ShownValue(parameter, high)};
  for (const Point& p : points) {
    profile.value.push_back(ShownValue(parameter, p.value));
    profile.deviance.push_back(p.deviance);
  }
  return profile;
}

}  // namespace tendril
