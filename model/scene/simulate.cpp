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
  Record(const Scene& scene, const std::vector<Driven>& rods, std::vector<CurveSeries> before)
      : series_(std::move(before)) {
    for (std::size_t o = 0; o < scene.objects.size(); ++o) {
      const std::string& name = scene.objects[o].name;
      objects_.push_back({name.empty() ? "object" + std::to_string(o) : name, {}, {}});
    }
    series_.resize(rods.size());
    for (std::size_t r = 0; r < rods.size(); ++r) series_[r].name = rods[r].name;
    for (Eigen::Index f = 0; f < series_[0].time.size(); ++f) times_.push_back(series_[0].time[f]);
  }
  std::size_t frames() const { return times_.size(); }
  void Add(double time, const std::vector<Rod>& rods) {
    times_.push_back(time);
    for (std::size_t r = 0; r < rods.size(); ++r) series_[r].curves.push_back(CurveOf(rods[r]));
  }
  void AddObjects(const std::vector<Eigen::Isometry3d>& poses, const std::vector<Eigen::Vector3d>& forces) {
    for (std::size_t o = 0; o < objects_.size(); ++o) {
      objects_[o].poses.push_back(poses[o]);
      objects_[o].forces.push_back(forces[o]);
    }
  }
  const std::vector<ObjectSeries>& objects() const { return objects_; }

  // Behind a state's numbers, and from there.
  void SaveObjects(std::vector<double>& numbers) const {
    const std::size_t before = numbers.size();
    for (const ObjectSeries& object : objects_) {
      for (std::size_t f = 0; f < object.poses.size(); ++f) {
        const Eigen::Matrix4d& pose = object.poses[f].matrix();
        numbers.insert(numbers.end(), pose.data(), pose.data() + 16);
        numbers.insert(numbers.end(), object.forces[f].begin(), object.forces[f].end());
      }
    }
    numbers.push_back(static_cast<double>(numbers.size() - before));
  }
  //   returns  false  they are not of such a record
  bool TakeObjects(std::vector<double>& numbers) {
    const double expected = static_cast<double>(19 * frames() * objects_.size());
    if (numbers.empty() || numbers.back() != expected || static_cast<double>(numbers.size()) < 1 + expected) {
      return false;
    }
    const std::size_t begin = numbers.size() - 1 - 19 * frames() * objects_.size();
    const double* from = numbers.data() + begin;
    for (ObjectSeries& object : objects_) {
      for (std::size_t f = 0; f < frames(); ++f, from += 19) {
        Eigen::Isometry3d& pose = object.poses.emplace_back();
        pose.matrix() = Eigen::Map<const Eigen::Matrix4d>(from);
        object.forces.emplace_back(from[16], from[17], from[18]);
      }
    }
    numbers.resize(begin);
    return true;
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
  std::vector<ObjectSeries> objects_;
  std::vector<double> times_;
};

// Why a run cannot be trusted.
std::vector<std::string> DoubtsOf(const Simulated& run) {
  std::vector<std::string> doubts;
  const double overlap = 2 * (1 - run.least_axis_share);
  if (overlap > kDeepestTrusted) {
    doubts.push_back("bodies overlap by " + ShortNumber(100 * overlap) + " % of a radius");
  }
  if (run.longest_stick > kLongestStickTrusted) {
    doubts.push_back("what sticks gives by " + ShortNumber(100 * run.longest_stick) +
                     " % of the radii's sum");
  }
  if (run.nothing_passed && !*run.nothing_passed) doubts.push_back("a body may have passed through another");
  if (run.diverged) doubts.push_back("it diverged");
  return doubts;
}

// After the first kick: what starts inside each other so deep that nothing comes of it; what is shallower is
// told.
std::optional<Divergence> OverlapAtStart(const Scene& scene, const Stepper& stepper,
                                         const SimulateHooks& hooks) {
  if (stepper.contacts() == nullptr) return std::nullopt;
  const double overlap = 2 * (1 - stepper.contacts()->least_share());
  // Nobody may be there to be told; looking takes all pairs of elements.
  if (!(overlap > (hooks.warn ? kOverlapToTell : kDeepestTrusted))) return std::nullopt;
  Divergence found = FindDeepest(scene, stepper.rods(), stepper.At(stepper.time_step()),
                                 stepper.PosesAt(stepper.time_step()));
  found.why += ": they start inside each other";
  if (overlap > kDeepestTrusted) {
    found.at_start = true;
    return found;
  }
  if (hooks.warn) {
    hooks.warn(found.rod + ", element " + std::to_string(found.element) + ": " + found.why +
               ", which pushes them apart; move them apart");
  }
  return std::nullopt;
}

Result<Simulated> Statics(const Scene& scene, std::vector<Driven> rods, const std::vector<double>& times,
                          const SimulateHooks& hooks) {
  Record record(scene, rods, {});
  Result<StaticSolver> made = StaticSolver::Make(scene, std::move(rods));
  if (!made.ok()) return made.error();
  StaticSolver& solver = made.value();
  Simulated result;
  for (const double time : times) {
    Result<std::vector<Rod>> at = solver.At(time);
    if (!at.ok()) return at.error();
    record.Add(time, at.value());
    std::vector<Eigen::Isometry3d> poses;
    for (const SceneObject& object : scene.objects) poses.push_back(object.pose);
    record.AddObjects(poses, std::vector<Eigen::Vector3d>(poses.size(), Eigen::Vector3d::Zero()));
    result.stopped = hooks.progress && !hooks.progress(scene.duration > 0 ? time / scene.duration : 1);
    if (result.stopped) break;
  }
  result.steps = solver.solved();
  result.curves = record.Curves();
  result.objects = record.objects();
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
  Record record(scene, stepper.rods(), resumes ? hooks.resume_from->curves : std::vector<CurveSeries>());
  std::vector<double> numbers = resumes ? hooks.resume_from->numbers : std::vector<double>();
  if (resumes && !(FramesAreThose(*hooks.resume_from, stepper.rods(), times) && record.TakeObjects(numbers) &&
                   stepper.Restore(numbers) && static_cast<double>(stepper.kicks()) <= whole &&
                   (record.frames() == times.size() ||
                    std::llround(times[record.frames()] / step) >= stepper.kicks()))) {
    return Error{
        ErrorKind::kBadInput,
        "the state to go on from is of another scene, level, plan or program: start anew without it"};
  }
  Simulated result;
  result.resumed_at = static_cast<double>(stepper.kicks()) * step;
  bool stopping = false;  // at the end of the block, so that it can be kept
  const auto advance = [&](std::int64_t to) {
    while (stepper.kicks() < to && !result.diverged && !result.stopped) {
      const std::int64_t block = (stepper.kicks() / kBlock + 1) * kBlock;
      // The first kick alone: it tells how things lie at the start.
      const std::int64_t look = stepper.kicks() == 0 ? 1 : kLook;
      result.diverged = stepper.AdvanceTo(std::min({to, block, stepper.kicks() + look}));
      if (!result.diverged && stepper.kicks() == 1) result.diverged = OverlapAtStart(scene, stepper, hooks);
      if (result.diverged) return;
      const double done = static_cast<double>(stepper.kicks()) * step / scene.duration;
      if (!stopping) stopping = hooks.progress && !hooks.progress(done);
      if (stepper.kicks() == block) {
        stepper.ForgetHistory();
        result.diverged = stepper.CheckEnergy();
        if (!result.diverged && hooks.keep) {
          hooks.keep([&] {
            SimulationState state{stepper.Save(), record.Curves()};
            record.SaveObjects(state.numbers);
            return state;
          });
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
    std::vector<Eigen::Vector3d> forces;
    for (std::size_t o = 0; o < scene.objects.size(); ++o) forces.push_back(stepper.ForceOn(o));
    record.AddObjects(stepper.PosesAt(times[k]), forces);
  }
  result.steps = stepper.kicks();
  result.time_step = step;
  if (const ContactList* contacts = stepper.contacts()) {
    result.least_axis_distance = contacts->least_distance();
    result.least_axis_share = contacts->least_share();
    result.longest_move = contacts->longest_move();
    result.nothing_passed = contacts->NothingPassed();
    if (result.diverged && result.nothing_passed) result.nothing_passed = false;
    result.longest_stick = contacts->longest_stick();
  }
  result.doubts = DoubtsOf(result);
  result.curves = record.Curves();
  result.objects = record.objects();
  return result;
}

}  // namespace tendril
