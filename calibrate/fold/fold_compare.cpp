#include "calibrate/fold/fold_compare.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "calibrate/fold/held_out.h"
#include "calibrate/fold/pull_hint.h"
#include "model/check.h"
#include "model/median.h"

namespace tendril {
namespace {

struct Contender {
  FitRun run;
  Misfits misfits;
  std::size_t index = 0;  // into the comparison's models
};

// Loss of one trial over the curves that every contender could explain.
struct TrialLoss {
  double sum = 0;
  double rows = 0;
};

TrialLoss LossOf(const TrialMisfit& misfit, const std::set<std::size_t>& common, double huber) {
  TrialLoss loss;
  for (std::size_t i = 0; i < misfit.observation.size(); ++i) {
    if (!common.contains(misfit.observation[i])) continue;
    for (const double r : misfit.residual[i]) loss.sum += HuberLoss(r, huber);
    loss.rows += static_cast<double>(misfit.residual[i].size());
  }
  return loss;
}

// The curves that a fit used and, where trials were held out, that its parameters without them reach too.
std::set<std::size_t> CurvesOf(const Misfits& misfits) {
  const auto in = [](const std::vector<TrialMisfit>& trials) {
    std::set<std::size_t> all;
    for (const TrialMisfit& trial : trials) all.insert(trial.observation.begin(), trial.observation.end());
    return all;
  };
  std::set<std::size_t> all = in(misfits.fitted);
  if (misfits.held_out.empty()) return all;
  const std::set<std::size_t> held_out = in(misfits.held_out);
  std::erase_if(all, [&](std::size_t curve) { return !held_out.contains(curve); });
  return all;
}

double SmallestScale(const std::vector<Contender>& contenders) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Contender& one : contenders) {
    std::vector<double> all;
    for (const TrialMisfit& trial : one.misfits.fitted) {
      for (const std::vector<double>& curve : trial.residual)
        all.insert(all.end(), curve.begin(), curve.end());
    }
    if (!all.empty()) smallest = std::min(smallest, Median(std::move(all)) / 0.6745);
  }
  return smallest;
}

// How much loss counts as one: the sandwich's variance over that of independent rows of sigma 1, mean over
// the free parameters. With one trial: of rows that err alone, at their own variance.
double InflationOf(const FitRun& run) {
  constexpr double kLeast = 1e-12;  // shapes that are exactly the model's
  if (!run.fit.clustered) return std::max(run.information.repeats * run.information.row_variance, kLeast);
  const SharedMatrix clustered = ClusteredCovariance(run.information, run.held, run.at_bound);
  SharedMatrix alone = NaiveCovariance(run.information, 1, run.held) / run.information.repeats;
  double sum = 0;
  int count = 0;
  for (int i = 0; i < kFoldParameters; ++i) {
    if (!(clustered(i, i) > 0) || !(alone(i, i) > 0)) continue;
    sum += clustered(i, i) / alone(i, i);
    ++count;
  }
  return count > 0 ? std::max(sum / count, kLeast) : 1;
}

std::string Percent(double share) { return fmt::format("{:.2g} %", 100 * share); }

// Mean difference of loss per row between two models over the trials, and its standard error.
struct Paired {
  double mean = 0;
  double error = 0;
};

Paired Difference(const std::vector<double>& a, const std::vector<double>& b) {
  TENDRIL_CHECK(a.size() == b.size());
  Paired paired;
  const double n = static_cast<double>(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) paired.mean += (a[i] - b[i]) / n;
  for (std::size_t i = 0; i < a.size(); ++i) {
    paired.error += std::pow(a[i] - b[i] - paired.mean, 2) / (n * std::max(n - 1, 1.0));
  }
  paired.error = std::sqrt(paired.error);
  return paired;
}

const char* NameForPeople(bool friction) { return friction ? "friction" : "a rest angle"; }

// The fit of the same law with the most of this model's parameters, from those made before.
const FoldFit* Plainer(const std::vector<ComparedModel>& before, const FoldModel& model) {
  const FoldFit* found = nullptr;
  for (const ComparedModel& one : before) {
    const FoldModel& m = one.model;
    if (!one.fit || m.law != model.law || (m.rest_angle && !model.rest_angle) ||
        (m.friction && !model.friction))
      continue;
    if (found == nullptr || one.fit->parameters.size() >= found->parameters.size()) found = &*one.fit;
  }
  return found;
}

void StartFrom(const FoldFit& plainer, FoldFitOptions& options) {
  options.start_ratio = plainer.parameters[1].value;
  options.start_exponent = plainer.parameters[2].value;
  for (const FittedParameter& p : plainer.parameters) {
    if (p.name == FoldParameterNames()[kRestAngle]) {
      options.start_rest_angle = std::max(FittedValue(kRestAngle, p.value), 0.01);
    }
    if (p.name == FoldParameterNames()[kFriction]) options.start_friction = std::max(p.value, 0.01);
  }
}

// The loss per row of each trial, held out (with one trial: fitted), by the trials' names: models that leave
// out different curves number their trials differently.
std::vector<double> LossByTrial(const Contender& one, const std::set<std::size_t>& common, double huber) {
  const std::vector<TrialMisfit>& trials =
      one.misfits.held_out.empty() ? one.misfits.fitted : one.misfits.held_out;
  std::map<std::string, double> by_name;
  for (std::size_t i = 0; i < trials.size(); ++i) {
    const TrialLoss loss = LossOf(trials[i], common, huber);
    if (loss.rows > 0) by_name[one.run.frames.trials[i]] = loss.sum / loss.rows;
  }
  std::vector<double> losses;
  for (const auto& [name, loss] : by_name) losses.push_back(loss);
  return losses;
}

std::set<std::size_t> CommonCurves(const std::vector<Contender>& contenders) {
  std::set<std::size_t> common = CurvesOf(contenders.front().misfits);
  for (const Contender& one : contenders) {
    const std::set<std::size_t> used = CurvesOf(one.misfits);
    std::erase_if(common, [&](std::size_t curve) { return !used.contains(curve); });
  }
  return common;
}

// Why friction is not tried with a law, from what its plainer models did; empty: it is.
std::string WhyHopeless(const std::vector<Contender>& contenders, const FoldModel& model,
                        const FoldComparisonOptions& options) {
  if (!model.friction || contenders.empty()) return {};
  const std::set<std::size_t> common = CommonCurves(contenders);
  const double huber = options.fit.huber * std::max(SmallestScale(contenders), 0.05);
  std::vector<double> own, other;
  const auto mean = [](const std::vector<double>& v) {
    double sum = 0;
    for (const double x : v) sum += x / static_cast<double>(v.size());
    return v.empty() ? std::numeric_limits<double>::infinity() : sum;
  };
  for (const Contender& one : contenders) {
    if (one.run.fit.model.friction) continue;  // like is compared with like
    const std::vector<double> loss = LossByTrial(one, common, huber);
    std::vector<double>& least = one.run.fit.model.law == model.law ? own : other;
    if (mean(loss) < mean(least)) least = loss;
  }
  if (own.size() < 2 || own.size() != other.size()) return {};  // one trial: nothing was held out
  const Paired apart = Difference(own, other);
  if (apart.mean < options.hopeless * mean(other) || apart.mean < 2 * options.clear * apart.error) return {};
  return fmt::format(
      "not tried: without friction law {} is already {:.0f} % behind the other law on held-out "
      "trials",
      NameOf(model.law), 100 * apart.mean / mean(other));
}

void Judge(const FoldComparisonOptions& options, double largest_pull, FoldComparison& comparison) {
  std::vector<ComparedModel>& models = comparison.models;
  std::vector<std::string>& verdict = comparison.verdict;
  if (comparison.chosen < 0) return;
  const ComparedModel& chosen = models[static_cast<std::size_t>(comparison.chosen)];
  const ComparedModel& best = models[static_cast<std::size_t>(comparison.best)];
  verdict.push_back(fmt::format("these data ask for model {}", NameOf(chosen.model)));
  const bool judged = std::isfinite(best.held_out);
  if (!judged) {
    verdict.push_back("one trial only: nothing was held out, AIC alone decided; record more trials");
    return;
  }
  // The other law at its best.
  const ComparedModel* other = nullptr;
  for (const ComparedModel& one : models) {
    if (!one.fit || one.model.law == chosen.model.law ||
        one.held_out_by_trial.size() != chosen.held_out_by_trial.size())
      continue;
    if (other == nullptr || one.held_out < other->held_out) other = &one;
  }
  if (other != nullptr) {
    const Paired apart = Difference(other->held_out_by_trial, chosen.held_out_by_trial);
    if (apart.mean > options.clear * apart.error) {
      verdict.push_back(fmt::format(
          "law {} fits held-out trials better than law {} ({:.3f} against {:.3f} mm)",
          NameOf(chosen.model.law), NameOf(other->model.law), 1e3 * chosen.held_out, 1e3 * other->held_out));
    } else {
      verdict.push_back(fmt::format(
          "the two laws cannot be told apart by these pulls (up to {:.3g}): {} against {} differ by {:.1f} "
          "standard errors; larger pulls or more trials would",
          largest_pull, NameOf(other->model), NameOf(chosen.model),
          std::abs(apart.mean) / std::max(apart.error, 1e-300)));
    }
  }
  for (const bool friction : {false, true}) {
    FoldModel twin = chosen.model;
    (friction ? twin.friction : twin.rest_angle) ^= true;
    const auto found = std::find_if(models.begin(), models.end(),
                                    [&](const ComparedModel& m) { return m.model == twin && m.fit; });
    if (found == models.end() || found->held_out_by_trial.size() != chosen.held_out_by_trial.size()) continue;
    const bool has = friction ? chosen.model.friction : chosen.model.rest_angle;
    const char* const what = NameForPeople(friction);
    const Paired apart = Difference(has ? found->held_out_by_trial : chosen.held_out_by_trial,
                                    has ? chosen.held_out_by_trial : found->held_out_by_trial);
    if (has) {
      verdict.push_back(
          fmt::format("{} is needed: without it the error on held-out trials rises from {:.3f} to "
                      "{:.3f} mm",
                      what, 1e3 * chosen.held_out, 1e3 * found->held_out));
    } else if (apart.mean <= 0) {
      verdict.push_back(fmt::format(
          "{} is not needed by these data: with it held-out trials are no better explained", what));
    } else {
      verdict.push_back(fmt::format(
          "{} is not needed by these data: it changes the error on held-out trials by "
          "{} only, {:.1f} standard errors",
          what, Percent(1 - found->held_out / chosen.held_out), apart.mean / std::max(apart.error, 1e-300)));
    }
  }
}

}  // namespace

Result<FoldComparison> CompareFoldModels(std::span<const FoldObservation> observations,
                                         const FoldComparisonOptions& options, const Progress& progress) {
  const auto started = std::chrono::steady_clock::now();
  if (options.models.empty()) return Error{ErrorKind::kBadInput, "no model to compare; expected one or more"};
  FoldComparison comparison;
  std::vector<Contender> contenders;
  std::optional<Error> last_error;
  for (std::size_t i = 0; i < options.models.size(); ++i) {
    const double from = static_cast<double>(i) / static_cast<double>(options.models.size());
    const double to = static_cast<double>(i + 1) / static_cast<double>(options.models.size());
    FoldFitOptions with = options.fit;
    with.model = options.models[i];
    if (const FoldFit* plainer = Plainer(comparison.models, with.model)) StartFrom(*plainer, with);
    const Progress share = [&](double done) { return !progress || progress(from + (to - from) * done); };
    if (!share(0)) return Error{ErrorKind::kStopped, "the comparison was asked to stop"};
    ComparedModel& one = comparison.models.emplace_back();
    one.model = options.models[i];
    one.why_not = WhyHopeless(contenders, one.model, options);
    if (!one.why_not.empty()) continue;
    Result<FitRun> run = RunFit(observations, with, share);
    if (!run.ok()) {
      if (run.error().kind == ErrorKind::kStopped) return run.error();
      one.why_not = run.error().message;
      last_error = run.error();
      continue;
    }
    one.fit = run.value().fit;
    Misfits misfits = MisfitsOf(run.value(), with);
    contenders.push_back({std::move(run).value(), std::move(misfits), i});
  }
  if (contenders.empty()) return *last_error;

  // The same curves for all: those that every model used.
  const std::set<std::size_t> common = CommonCurves(contenders);
  const double scale = std::max(SmallestScale(contenders), 0.05);
  const double huber = options.fit.huber * scale;
  const Contender* richest = &contenders.front();
  for (const Contender& one : contenders) {
    if (one.run.fit.model.parameters() > richest->run.fit.model.parameters()) richest = &one;
  }
  double sigma2 = 0;
  double sigmas = 0;
  double largest_pull = 0;
  const FitRun& first = contenders.front().run;
  for (const FitFrame& frame : first.frames.frames) {
    largest_pull = std::max(largest_pull, frame.commanded_pull);
    const std::optional<FoldTangent> fold =
        FoldOf(frame, first.solution.parameters, NuisanceOf(frame, first.solution.nuisances));
    if (!fold) continue;
    const Eigen::VectorXd sigma =
        ResidualOf(MoveNodes(*frame.layout, *fold), frame.seen, options.fit.residual, first.fit.scatter)
            .sigma;
    sigma2 += sigma.squaredNorm();
    sigmas += static_cast<double>(sigma.size());
  }
  const double row_sigma = std::sqrt(sigma2 / std::max(sigmas, 1.0));

  std::vector<double> aic(comparison.models.size(), std::numeric_limits<double>::infinity());
  comparison.inflation = InflationOf(richest->run);
  for (const Contender& one : contenders) {
    ComparedModel& model = comparison.models[one.index];
    TrialLoss fitted, held_out;
    for (const TrialMisfit& trial : one.misfits.fitted) {
      const TrialLoss loss = LossOf(trial, common, huber);
      fitted.sum += loss.sum;
      fitted.rows += loss.rows;
    }
    for (const TrialMisfit& trial : one.misfits.held_out) {
      const TrialLoss loss = LossOf(trial, common, huber);
      held_out.sum += loss.sum;
      held_out.rows += loss.rows;
    }
    if (!one.misfits.held_out.empty()) model.held_out_by_trial = LossByTrial(one, common, huber);
    if (held_out.rows > 0) model.held_out = row_sigma * std::sqrt(held_out.sum / held_out.rows);
    aic[one.index] = fitted.sum / comparison.inflation + 2 * model.model.parameters();
    comparison.rows = static_cast<long>(fitted.rows);
    comparison.trials = std::max(comparison.trials, one.run.fit.trials);
  }
  const double least_aic = *std::min_element(aic.begin(), aic.end());
  const auto better = [&](std::size_t a, std::size_t b) {
    const double left = comparison.models[a].held_out;
    const double right = comparison.models[b].held_out;
    if (std::isfinite(left) && std::isfinite(right)) return left < right;
    return aic[a] < aic[b];
  };
  for (const Contender& one : contenders) {
    comparison.models[one.index].aic_difference = aic[one.index] - least_aic;
    if (comparison.best < 0 || better(one.index, static_cast<std::size_t>(comparison.best))) {
      comparison.best = static_cast<int>(one.index);
    }
  }
  const ComparedModel& best = comparison.models[static_cast<std::size_t>(comparison.best)];
  comparison.chosen = comparison.best;
  double best_loss = 0;
  for (const double loss : best.held_out_by_trial) {
    best_loss += loss / static_cast<double>(best.held_out_by_trial.size());
  }
  for (const Contender& one : contenders) {
    ComparedModel& model = comparison.models[one.index];
    if (model.held_out_by_trial.size() != best.held_out_by_trial.size() || best_loss == 0) continue;
    const Paired apart = Difference(model.held_out_by_trial, best.held_out_by_trial);
    model.behind = apart.mean / best_loss;
    model.behind_error = apart.error / best_loss;
    const ComparedModel& chosen = comparison.models[static_cast<std::size_t>(comparison.chosen)];
    const bool fewer =
        model.model.parameters() < chosen.model.parameters() ||
        (model.model.parameters() == chosen.model.parameters() && model.held_out < chosen.held_out);
    if (fewer && apart.mean <= options.clear * apart.error) comparison.chosen = static_cast<int>(one.index);
  }
  for (const Contender& one : contenders) {
    if (static_cast<int>(one.index) != comparison.chosen) continue;
    comparison.models[one.index].fit->hint = HintOf(one.run, options.fit);
  }
  Judge(options, largest_pull, comparison);
  comparison.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  return comparison;
}

}  // namespace tendril
