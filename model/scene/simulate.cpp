#include "model/scene/simulate.h"

#include <algorithm>
#include <cmath>

#include "model/scene/statics.h"
#include "model/scene/stepper.h"

namespace tendril {
namespace {

// Kicks between two looks at the progress.
constexpr std::int64_t kLook = 100;

// Writes down curves as they come.
class Record {
 public:
  Record(const std::vector<Driven>& rods, std::vector<CurveSeries> before) : series_(std::move(before)) {
    series_.resize(rods.size());
    for (std::size_t r = 0; r < rods.size(); ++r) series_[r].name = rods[r].name;
    for (Eigen::Index f = 0; f < series_[0].time.size(); ++f) times_.push_back(series_[0].time[f]);
  }
  std::size_t frames() const { return times_.size(); }
  void Add(double time, const std::vector<Rod>& rods) {
    times_.push_back(time);
    for (std::size_t r = 0; r < rods.size(); ++r) series_[r].curves.push_back(CurveOf(rods[r]));
  }
  std::vector<CurveSeries> Curves() const {
    std::vector<CurveSeries> curves = series_;
    for (CurveSeries& one : curves) {
      one.time = Eigen::Map<const Eigen::VectorXd>(times_.data(), static_cast<Eigen::Index>(times_.size()));
    }
    return curves;
  }

 private:
  std::vector<CurveSeries> series_;
  std::vector<double> times_;
};

Result<Simulated> Statics(const Scene& scene, std::vector<Driven> rods, const std::vector<double>& times,
                          const SimulateHooks& hooks) {
  Record record(rods, {});
  Result<StaticSolver> made = StaticSolver::Make(scene, std::move(rods));
  if (!made.ok()) return made.error();
  StaticSolver& solver = made.value();
  Simulated result;
  for (const double time : times) {
    Result<std::vector<Rod>> at = solver.At(time);
    if (!at.ok()) return at.error();
    record.Add(time, at.value());
    result.stopped = hooks.progress && !hooks.progress(scene.duration > 0 ? time / scene.duration : 1);
    if (result.stopped) break;
  }
  result.steps = solver.solved();
  result.curves = record.Curves();
  return result;
}

// Whether a state's curves are of these rods, at the first of these times.
bool FramesAreThose(const SimulationState& state, const std::vector<Driven>& rods,
                    const std::vector<double>& times) {
  if (state.curves.size() != rods.size()) return state.curves.empty();
  for (std::size_t r = 0; r < rods.size(); ++r) {
    const CurveSeries& series = state.curves[r];
    if (series.curves.size() != static_cast<std::size_t>(series.time.size()) ||
        series.curves.size() > times.size() ||
        !std::equal(series.time.begin(), series.time.end(), times.begin())) {
      return false;
    }
    for (const FramedCurve& curve : series.curves) {
      if (curve.points.cols() != rods[r].rod.position.cols()) return false;
    }
  }
  return true;
}

}  // namespace

Result<Simulated> Simulate(const Scene& scene, const SimulationPlan& plan, const std::vector<double>& times,
                           std::uint64_t trial, const SimulateHooks& hooks) {
  const auto good = [&](double time) { return time >= 0 && time <= scene.duration; };
  if (times.empty() || !std::all_of(times.begin(), times.end(), good) ||
      !std::is_sorted(times.begin(), times.end()) || !std::isfinite(scene.duration)) {
    return Error{ErrorKind::kBadInput, "times: expected seconds from 0 to the duration, " +
                                           ShortNumber(scene.duration) + " s, in ascending order"};
  }
  if (!(plan.time_step > 0) || !(scene.duration > 0)) {
    return Error{ErrorKind::kBadInput, "duration = " + ShortNumber(scene.duration) + " s, time_step = " +
                                           ShortNumber(plan.time_step) + " s: expected numbers above 0"};
  }
  Result<std::vector<Driven>> made = MakeRods(scene, trial);
  if (!made.ok()) return made.error();
  if (made.value().empty()) return Error{ErrorKind::kBadInput, "a scene needs a [gripper] or a [[rod]]"};
  if (scene.level == SimulationLevel::kStatic) return Statics(scene, std::move(made).value(), times, hooks);

  const double whole = std::max(1.0, std::ceil(scene.duration / plan.time_step * (1 - 1e-12)));
  Stepper stepper(scene, plan, std::move(made).value(), scene.duration / whole, hooks.threads);
  const double step = stepper.time_step();
  const bool resumes = hooks.resume_from != nullptr;
  Record record(stepper.rods(), resumes ? hooks.resume_from->curves : std::vector<CurveSeries>());
  if (resumes &&
      !(FramesAreThose(*hooks.resume_from, stepper.rods(), times) &&
        stepper.Restore(hooks.resume_from->numbers) && static_cast<double>(stepper.kicks()) <= whole &&
        (record.frames() == times.size() ||
         std::llround(times[record.frames()] / step) >= stepper.kicks()))) {
    return Error{
        ErrorKind::kBadInput,
        "the state to go on from is of another scene, level, plan or program: start anew without it"};
  }
  Simulated result;
  bool stopping = false;  // at the end of the block, so that it can be kept
  const auto advance = [&](std::int64_t to) {
    while (stepper.kicks() < to && !result.diverged && !result.stopped) {
      const std::int64_t block = (stepper.kicks() / kBlock + 1) * kBlock;
      result.diverged = stepper.AdvanceTo(std::min({to, block, stepper.kicks() + kLook}));
      if (result.diverged) return;
      const double done = static_cast<double>(stepper.kicks()) * step / scene.duration;
      if (!stopping) stopping = hooks.progress && !hooks.progress(done);
      if (stepper.kicks() == block) {
        stepper.ForgetHistory();
        result.diverged = stepper.CheckEnergy();
        if (!result.diverged && hooks.keep) {
          hooks.keep([&] { return SimulationState{stepper.Save(), record.Curves()}; });
        }
      }
      result.stopped = stopping && (!hooks.keep || stepper.kicks() == block);
    }
  };
  for (std::size_t k = record.frames(); k < times.size(); ++k) {
    // The kick before which `time` lies at most half a step behind.
    advance(std::min<std::int64_t>(std::llround(times[k] / step), std::llround(whole)));
    if (result.diverged || result.stopped) break;
    record.Add(times[k], stepper.At(times[k]));
  }
  result.steps = stepper.kicks();
  result.time_step = step;
  if (const ContactList* contacts = stepper.contacts()) {
    result.least_axis_distance = contacts->least_distance();
    result.least_axis_share = contacts->least_share();
    result.longest_move = contacts->longest_move();
    result.nothing_passed = contacts->NothingPassed();
    if (result.diverged && result.nothing_passed) result.nothing_passed = false;
  }
  result.curves = record.Curves();
  return result;
}

}  // namespace tendril
