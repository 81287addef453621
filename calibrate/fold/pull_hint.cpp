#include "calibrate/fold/pull_hint.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "calibrate/fold/view_hint.h"

namespace tendril {
namespace {

// Against one more trial at the best pull, which lowers the standard error by trial_gain of it.
std::string ViewSentence(const ViewHint& view, const std::vector<std::string>& places, double trial_gain) {
  // What a tracker states allows for calibration errors that are alike in all pictures: it bounds those that
  // are new in each.
  const bool measured = view.known_from == PictureErrors::kRepeats;
  const std::string split =
      measured ? fmt::format("{:.0f} % of its variance is of pictures, the rest of tentacles that differ",
                             100 * view.picture_share)
               : fmt::format(
                     "by the stated {} up to {:.0f} % of its variance is of pictures, the rest of tentacles "
                     "that differ",
                     view.known_from == PictureErrors::kCovariance ? "covariance" : "sigmas",
                     100 * view.picture_share);
  const auto lower = [&](double ratio) {
    return fmt::format("{}{:.0f} % lower", measured ? "" : "up to ", 100 * std::max(0.0, 1 - ratio));
  };
  if (view.best < 0) {
    const std::string bound =
        fmt::format("with every node seen without error in all these trials it would have been {} ({})",
                    lower(view.perfect_ratio), split);
    return (1 - view.perfect_ratio <= trial_gain ? "more cameras would help less than that trial: "
                                                 : "more cameras might help more than that trial: ") +
           bound;
  }
  const double gain = 1 - view.error_ratio[static_cast<std::size_t>(view.best)];
  const char* const verdict = gain < 0.03          ? "more views would hardly help"
                              : gain <= trial_gain ? "another view would help less than that trial"
                              : measured           ? "another view would help more than that trial"
                                                   : "another view might help more than that trial";
  return fmt::format("{}: with {} in all these trials it would have been {} ({})", verdict,
                     places[static_cast<std::size_t>(view.best)], lower(1 - gain), split);
}

}  // namespace

std::optional<PullHint> HintOf(const FitRun& run, const FoldFitOptions& options) {
  // The least known: the largest error in units of what is still of use.
  const SharedMatrix now = NaiveCovariance(run.information, 1, run.held);
  const auto& names = FoldParameterNames();
  const auto& useful = LargestStandardErrors();
  int weakest = -1;
  double most = 0;
  for (const FittedParameter& p : run.fit.parameters) {
    const std::size_t i =
        static_cast<std::size_t>(std::find(names.begin(), names.end(), p.name) - names.begin());
    const double error = std::sqrt(now(static_cast<int>(i), static_cast<int>(i))) / useful[i];
    if (run.held[i] || !(error > most)) continue;
    most = error;
    weakest = static_cast<int>(i);
  }
  if (weakest < 0) return std::nullopt;
  std::map<int, std::vector<const FitFrame*>> settled;
  for (const FitFrame& frame : run.frames.frames) {
    if (frame.source == PullSource::kSettled && frame.commanded_pull > 0)
      settled[frame.trial].push_back(&frame);
  }
  if (settled.empty()) return std::nullopt;
  const auto model_trial = std::max_element(settled.begin(), settled.end(), [](const auto& a, const auto& b) {
    return a.second.size() < b.second.size();
  });
  double reach = std::numeric_limits<double>::infinity();
  for (const FitFrame* frame : model_trial->second) reach = std::min(reach, frame->reach);
  // Far beyond what was seen nobody knows whether the model holds: facets may meet there.
  double strongest = 0;
  for (const FitFrame& frame : run.frames.frames) strongest = std::max(strongest, frame.commanded_pull);

  PullHint hint;
  hint.parameter = names[static_cast<std::size_t>(weakest)];
  for (int step = 1; step <= 18; ++step) {
    const double pull = 0.05 * step;
    if (run.solution.parameters[0] * pull > 0.95 * reach || pull > 1.5 * strongest + 1e-9) break;
    Information more = run.information;
    bool possible = true;
    for (const FitFrame* from : model_trial->second) {
      FitFrame frame = *from;
      frame.commanded_pull = pull;
      const std::optional<FrameResidual> at =
          EvaluateFrame(frame, run.solution.parameters, 0, options.residual);
      possible = possible && at.has_value();
      if (at) more.total += at->slope.transpose() * at->slope;
    }
    if (!possible) continue;
    const SharedMatrix then = NaiveCovariance(more, 1, run.held);
    hint.pull.push_back(pull);
    hint.error_ratio.push_back(std::sqrt(then(weakest, weakest) / now(weakest, weakest)));
  }
  if (hint.pull.empty()) return std::nullopt;
  const std::size_t best = static_cast<std::size_t>(
      std::min_element(hint.error_ratio.begin(), hint.error_ratio.end()) - hint.error_ratio.begin());
  hint.best_pull = hint.pull[best];
  hint.sentence = fmt::format(
      "one more trial held at pull {:.2f} would sharpen {} most: its standard error would fall by about "
      "{:.0f} %",
      hint.best_pull, hint.parameter, 100 * (1 - hint.error_ratio[best]));
  hint.view = ViewHintOf(run, options, weakest);
  if (hint.view) hint.view->sentence = ViewSentence(*hint.view, options.places, 1 - hint.error_ratio[best]);
  return hint;
}

}  // namespace tendril
