#include "cli/simulate_verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cli/command.h"
#include "model/scene/driven.h"

namespace tendril::cli {
namespace {

using Json = nlohmann::ordered_json;
using Eigen::Vector3d;

// What a run whose contacts speak against it says is not to be read without that.
std::string Caution(const Simulated& run) {
  return run.doubts.empty() ? "" : " (the run cannot be trusted, see the warning)";
}

}  // namespace

HoldingTest HoldingTestNamed(const std::string& name) {
  for (const HoldingTest test : {HoldingTest::kLift, HoldingTest::kLoad, HoldingTest::kStrike}) {
    if (NameOf(test) == name) return test;
  }
  return HoldingTest::kRelease;
}

Result<HoldingVerdict> TellHolding(const Scene& scene, const HoldingPlan& plan, const Simulated& done,
                                   Output& out) {
  const Result<std::vector<Driven>> rods = MakeRods(scene, 0);
  if (!rods.ok()) return rods.error();
  double mass = 0;
  for (const Driven& d : rods.value()) mass += d.rod.mass.sum();
  const Result<HoldingResult> judged = JudgeHolding(scene, plan.test, plan.times, plan.options, done, mass);
  if (!judged.ok()) return judged.error();
  const HoldingResult& result = judged.value();
  const HoldingVerdict verdict{result, RuleOf(plan.test, plan.options),
                               scene.objects[plan.options.object].mass, plan.times.lift};
  out.fields()["holding"] = {{"test", NameOf(result.test)},
                             {"lifted", result.lifted},
                             {"held", result.held},
                             {"grasped", result.Grasped()},
                             {"rise_m", NumberOrNull(result.rise)},
                             {"shift_m", NumberOrNull(result.shift)},
                             {"payload_kg", NumberOrNull(result.payload)},
                             {"payload_is_least", result.payload_is_least},
                             {"payload_by_rods_mass", NumberOrNull(result.payload_ratio)},
                             {"strikes", result.strikes},
                             {"release_s", NumberOrNull(result.release_time)},
                             {"rule", verdict.rule}};
  out.Print("{}: {}{}", NameOf(result.test), result.Sentence(), Caution(done));
  return verdict;
}

std::string FateOf(const Scene& scene, const Simulated& run, std::size_t index) {
  constexpr double kLookedAt = 0.5;  // s
  constexpr double kBorne = 0.5;     // of its weight: else it hangs from its string
  constexpr double kSunk = 0.01;     // m: what sank by less did not fall
  const SceneObject& object = scene.objects[index];
  const ObjectSeries& series = run.objects[index];
  const Eigen::VectorXd& time = run.curves[0].time;
  const auto last = static_cast<std::size_t>(time.size()) - 1;
  Vector3d force = Vector3d::Zero();
  std::size_t from = last;
  bool touched = false;
  for (std::size_t f = last + 1;
       f-- > 0 && time[static_cast<Eigen::Index>(f)] >= time.tail<1>()[0] - kLookedAt;) {
    force += series.forces[f];
    touched = touched || series.forces[f].norm() > 0;
    from = f;
  }
  force /= static_cast<double>(last - from + 1);
  const std::string motion = object.motion == ObjectMotion::kFree ? "free" : "hanging";
  const Vector3d moved = series.poses[last].translation() - series.poses[0].translation();
  if (!(scene.gravity.norm() > 0)) {
    const double lasted = time[static_cast<Eigen::Index>(last)] - time[static_cast<Eigen::Index>(from)];
    const Vector3d way = series.poses[last].translation() - series.poses[from].translation();
    const std::string speed =
        lasted > 0 ? fmt::format(", moves at {:.3g} mm/s", 1e3 * way.norm() / lasted) : "";
    return fmt::format("{}, without weight: at the end {}{}", motion,
                       touched ? "rods touch it" : "no rod touches it", speed);
  }
  const Vector3d up = -scene.gravity.normalized();
  const Result<MassProperties> filled = MassOf(object.shape);
  const double displaced = filled.ok() ? scene.medium.density * filled.value().volume : 0;
  const double weight = (object.mass - displaced) * scene.gravity.norm();
  const std::string share =
      weight > 0 ? fmt::format("rods bear {:.0f} % of its weight", 100 * up.dot(force) / weight + 0.0)
                 : fmt::format("it floats, rods push it by {:.3g} N", force.norm());
  const double sunk = -up.dot(moved);
  if (!touched) {
    if (object.motion == ObjectMotion::kHanging) return "hanging: from its string alone, no rod touches it";
    return sunk > kSunk ? fmt::format("free: it fell by {:.0f} mm, no rod touches it", 1e3 * sunk)
                        : "free: no rod touches it";
  }
  if (object.motion == ObjectMotion::kHanging) {
    const bool borne = weight > 0 && up.dot(force) >= kBorne * weight;
    return fmt::format("hanging: {}{}", borne ? "" : "from its string, ", share);
  }
  return fmt::format("free: {}{}", share,
                     sunk > kSunk ? fmt::format(", {:.0f} mm below its start", 1e3 * sunk) : "");
}

void TellWithoutTest(const Scene& scene, const Simulated& run, Output& out) {
  // The published laws do not add up what they do to objects, and equilibria have no contact.
  if (scene.level == SimulationLevel::kStatic || scene.contact.law != ContactLaw::kHertzSegments) return;
  auto fates = Json::array();
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    if (scene.objects[o].motion == ObjectMotion::kFixed) continue;
    const std::string fate = FateOf(scene, run, o);
    fates.push_back({{"object", run.objects[o].name}, {"fate", fate}});
    out.Print("{}: {}{}", run.objects[o].name, fate, Caution(run));
  }
  out.fields()["without_test"] = std::move(fates);
}

}  // namespace tendril::cli
