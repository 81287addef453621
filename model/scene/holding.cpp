#include "model/scene/holding.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/scene/plan.h"
#include "model/scene/schedule.h"

namespace tendril {
namespace {

using Eigen::Vector3d;

Vector3d Up(const Scene& scene) {
  return scene.gravity.norm() > 0 ? Vector3d(-scene.gravity.normalized()) : Vector3d(Vector3d::UnitZ());
}

void Strike(Scene& scene, const HoldingOptions& options, double from) {
  const Vector3d up = Up(scene);
  const Vector3d side = up.unitOrthogonal(), other = up.cross(side);
  // Half a sine of that length and this height has the impulse.
  const double peak = 0.5 * std::numbers::pi * options.strike / options.strike_time;
  for (const Vector3d& direction : {side, other, Vector3d(-side), Vector3d(-other)}) {
    for (int k = 0; k < options.strikes_a_side; ++k) {
      scene.pushes.push_back(
          {options.object, from, from + options.strike_time, peak * direction, PushShape::kPulse});
      from += options.strike_every;
    }
  }
}

}  // namespace

std::optional<std::size_t> GraspedObject(const Scene& scene) {
  std::optional<std::size_t> stays;
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    if (scene.objects[o].motion != ObjectMotion::kFixed) return o;
    if (!stays && scene.objects[o].kind != "table") stays = o;
  }
  return stays;
}

std::string NameOf(HoldingTest test) {
  return test == HoldingTest::kLift     ? "lift"
         : test == HoldingTest::kLoad   ? "load"
         : test == HoldingTest::kStrike ? "strike"
                                        : "release";
}

Result<HoldingTimes> AddHoldingTest(Scene& scene, HoldingTest test, const HoldingOptions& options) {
  const auto bad = [&](const std::string& what) {
    return Error{ErrorKind::kBadInput, "test of holding, " + NameOf(test) + ": " + what};
  };
  if (options.object >= scene.objects.size())
    return bad("the scene has no object " + std::to_string(options.object));
  const SceneObject& object = scene.objects[options.object];
  if (object.motion == ObjectMotion::kFixed) {
    return bad("the object is fixed; expected motion = \"free\" or \"hanging\"");
  }
  if (scene.level == SimulationLevel::kStatic) return bad("level static lifts nothing; expected standard");
  if (scene.contact.stiffness == 0)
    return bad("nothing touches with a contact stiffness of 0; expected above 0");
  if (!scene.gripper) return bad("expected a [gripper]: nothing else lifts");
  HoldingTimes times;
  times.lift = scene.duration;
  AddPhase(scene, {.name = "lift", .duration = options.lift_time, .move = options.height * Up(scene)});
  times.watch = scene.duration;
  AddPhase(scene, {.name = "watch", .duration = options.watch_time});
  times.test = scene.duration;
  if (test == HoldingTest::kLoad) {
    const double lasts = options.largest_load / options.load_rate;
    const double weight = options.largest_load * (scene.gravity.norm() > 0 ? scene.gravity.norm() : 9.80665);
    AddPhase(scene, {.name = "load", .duration = lasts});
    scene.pushes.push_back(
        {options.object, times.test, times.test + lasts, -weight * Up(scene), PushShape::kRamp});
  } else if (test == HoldingTest::kStrike) {
    AddPhase(scene, {.name = "strikes", .duration = 4 * options.strikes_a_side * options.strike_every});
    Strike(scene, options, times.test);
  } else if (test == HoldingTest::kRelease) {
    const double pull = StrongestPull(*scene.gripper, scene.phases);
    AddPhase(scene, {.name = "release",
                     .duration = pull / options.release_rate + options.release_wait,
                     .pull = 0.0,
                     .pull_rate = options.release_rate});
  }
  times.end = scene.duration;
  return times;
}

Result<HoldingResult> JudgeHolding(const Scene& scene, HoldingTest test, const HoldingTimes& times,
                                   const HoldingOptions& options, const Simulated& run, double rods_mass) {
  const Eigen::VectorXd& time = run.curves.at(0).time;
  if (time.size() == 0 || time.tail<1>()[0] < times.end * (1 - 1e-9)) {
    return Error{ErrorKind::kBadInput,
                 "test of holding, " + NameOf(test) + ": the run ended before it was over"};
  }
  const ObjectSeries& object = run.objects.at(options.object);
  const Vector3d up = Up(scene), start = scene.objects[options.object].pose.translation();
  const auto place = [&](Eigen::Index f) -> Vector3d {
    return object.poses[static_cast<std::size_t>(f)].translation();
  };
  HoldingResult result;
  result.test = test;
  result.rise = HUGE_VAL;
  Eigen::Index hangs = time.size() - 1;  // the first frame after the watch
  double settled = 0;                    // height when the watch begins
  double borne = 0;                      // by the rods while it is watched, upward, N
  int watched = 0;
  double before = 0;  // height when the lift begins
  for (Eigen::Index f = time.size(); f-- > 0;) {
    if (time[f] >= times.test) hangs = f;
    if (time[f] >= times.lift) before = up.dot(place(f) - start);
    if (time[f] < times.watch || time[f] > times.test) continue;
    settled = up.dot(place(f) - start);
    result.rise = std::min(result.rise, settled);
    borne += up.dot(object.forces[static_cast<std::size_t>(f)]);
    ++watched;
  }
  if (watched == 0) {
    return Error{ErrorKind::kBadInput, "test of holding, " + NameOf(test) +
                                           ": no frame while it is watched; expected some ten a second"};
  }
  const Vector3d hung = place(hangs);
  // What floats may have been pushed up before, and stay behind.
  const bool came_along = result.rise - before >= 0.5 * options.height;
  // What is pushed aside on its string rises too.
  const Result<MassProperties> properties = MassOf(scene.objects[options.object].shape);
  const double displaced = properties.ok() ? scene.medium.density * properties.value().volume : 0;
  const double weight = std::max(0.0, scene.objects[options.object].mass - displaced) * scene.gravity.norm();
  const bool by_rods = scene.objects[options.object].motion != ObjectMotion::kHanging ||
                       borne >= options.least_borne * weight * watched;
  const bool lifted = result.rise > options.least_rise && came_along && by_rods &&
                      up.dot(hung - start) > settled - 0.1 * options.height;
  const double lost_depth = options.lost_share * options.height;
  double lost_at = std::numeric_limits<double>::quiet_NaN(), touched_last = times.test;
  for (Eigen::Index f = hangs; f < time.size(); ++f) {
    result.shift = std::max(result.shift, (place(f) - hung).norm());
    const bool lost = up.dot(hung - place(f)) > lost_depth;
    if (lost && std::isnan(lost_at)) lost_at = time[f];
    if (object.forces[static_cast<std::size_t>(f)].norm() > 0) touched_last = time[f];
  }
  result.lifted = lifted;
  result.held = lifted && std::isnan(lost_at);
  if (!lifted) return result;
  const double lasted = std::isnan(lost_at) ? times.end - times.test : lost_at - times.test;
  if (test == HoldingTest::kLoad) {
    result.payload_is_least = std::isnan(lost_at);
    result.payload =
        scene.objects[options.object].mass + std::min(options.load_rate * lasted, options.largest_load);
    result.payload_ratio = result.payload / rods_mass;
  } else if (test == HoldingTest::kStrike) {
    const int all = 4 * options.strikes_a_side;
    result.strikes =
        std::isnan(lost_at) ? all : std::min(all, static_cast<int>(lasted / options.strike_every));
  } else if (test == HoldingTest::kRelease) {
    const bool free = touched_last < times.end - 0.1;
    result.held = free || !std::isnan(lost_at);
    if (result.held)
      result.release_time =
          (std::isnan(lost_at) ? touched_last : std::min(lost_at, touched_last)) - times.test;
  }
  return result;
}

bool HoldingResult::Grasped() const {
  return test == HoldingTest::kLift || test == HoldingTest::kStrike ? held : lifted;
}

std::string RuleOf(HoldingTest test, const HoldingOptions& options) {
  const auto mm = [](double length) { return ShortNumber(std::round(1e4 * length) / 10) + " mm"; };
  const std::string lifted =
      "lifted by " + mm(options.height) + ", the object's centre stayed more than " + mm(options.least_rise) +
      " above its start, and half of the lift above where that began, for " +
      ShortNumber(options.watch_time) + " s, with half of its weight or more off its string";
  switch (test) {
    case HoldingTest::kLift:
      return lifted;
    case HoldingTest::kLoad:
      return lifted + ", before the load grew";
    case HoldingTest::kStrike:
      return lifted + ", and sank by less than " + mm(options.lost_share * options.height) + " in " +
             std::to_string(4 * options.strikes_a_side) + " strikes";
    case HoldingTest::kRelease:
      return lifted + ", before the tendons unwound";
  }
  return {};
}

std::string HoldingResult::Sentence() const {
  const std::string height =
      "its centre stayed " + ShortNumber(std::round(1e4 * rise) / 10 + 0.0) + " mm above its start";
  if (!lifted) return "not lifted: " + height;
  switch (test) {
    case HoldingTest::kLift:
      return (held ? "lifted: " : "not lifted: ") + height;
    case HoldingTest::kLoad:
      return std::string(payload_is_least ? "holds " : "slips at ") + ShortNumber(std::round(1e3 * payload)) +
             " g with its own, " + ShortNumber(std::round(10 * payload_ratio) / 10) +
             " times the rods' mass" + (payload_is_least ? " and more" : "");
    case HoldingTest::kStrike:
      return std::string(held ? "holds" : "lost") + " after " + std::to_string(strikes) +
             " strikes, moved by up to " + ShortNumber(std::round(1e3 * shift)) + " mm";
    case HoldingTest::kRelease:
      if (std::isnan(release_time)) return held ? "let go" : "not let go";
      return "let go after " + ShortNumber(std::round(100 * release_time) / 100) + " s";
  }
  return {};
}

}  // namespace tendril
