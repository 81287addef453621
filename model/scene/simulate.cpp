#include "model/scene/simulate.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/geometry/segment_distance.h"
#include "model/scene/stepper.h"

namespace tendril {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

// Largest stable step of an element: its stretch and bending waves (0.9 l sqrt(rho / E), measured for one
// rod), and its turning against shear, r sqrt(rho / G).
double StableStep(const Rod& rod) {
  double step = HUGE_VAL;
  for (Index i = 0; i < rod.elements(); ++i) {
    const double l = rod.rest_length[i];
    const double mass = rod.mass[std::min<Index>(i + 1, rod.elements() - 1)];
    step = std::min(step, 0.9 * std::sqrt(mass * l / rod.shear_stiffness(2, i)));
    step = std::min(step, 2 * std::sqrt(rod.inertia(0, i) / (l * rod.shear_stiffness(0, i))));
  }
  return step;
}

FramedCurve CurveOf(const Rod& rod) {
  FramedCurve curve;
  curve.points = rod.position;
  curve.normals.resize(3, rod.position.cols());
  const Index last = rod.elements() - 1;
  for (Index i = 0; i < rod.position.cols(); ++i) {
    const auto& before = rod.directors[static_cast<std::size_t>(std::max<Index>(i - 1, 0))];
    const auto& after = rod.directors[static_cast<std::size_t>(std::min(i, last))];
    const Vector3d tangent = (before.row(2) + after.row(2)).normalized();
    const Vector3d normal = (before.row(0) + after.row(0)).transpose();
    curve.normals.col(i) = (normal - tangent.dot(normal) * tangent).normalized();
  }
  return curve;
}

}  // namespace

Result<SimulationPlan> PlanScene(const Scene& scene, bool full) {
  const Result<std::vector<Driven>> made = MakeRods(scene, 0);
  if (!made.ok()) return made.error();
  const std::vector<Driven>& rods = made.value();
  if (rods.empty()) return Error{ErrorKind::kBadInput, "a scene needs a [gripper] or a [[rod]]"};

  SimulationPlan plan;
  double stable = HUGE_VAL;
  for (const Driven& d : rods) stable = std::min(stable, StableStep(d.rod));
  const bool paper = scene.level == SimulationLevel::kPaper;
  plan.time_step = scene.time_step > 0 ? scene.time_step : paper ? 2e-5 : 0.7 * stable;
  plan.step_why = scene.time_step > 0 ? "the scene's time_step"
                  : paper             ? "the paper's"
                          : "0.7 of the stable " + ShortNumber(stable) + " s of stretch, bending and shear";

  const auto reach = [](const Driven& d) { return d.rod.rest_length.sum() + d.rod.radius.maxCoeff(); };
  const double moves = CarrierGrowth(scene, rods, HUGE_VAL);
  double room = HUGE_VAL, object_room = HUGE_VAL, turning = 0;
  for (std::size_t a = 0; a < rods.size(); ++a) {
    const Vector3d& from = rods[a].start;
    // A rod that nothing holds may go anywhere.
    const double far = rods[a].rod.clamped ? reach(rods[a]) + moves : HUGE_VAL;
    for (std::size_t b = 0; b < a; ++b) {
      const double other = rods[b].rod.clamped ? reach(rods[b]) + moves : HUGE_VAL;
      room = std::min(room, (from - rods[b].start).norm() - far - other);
    }
    for (const SceneObject& object : scene.objects) {
      const double distance = ClosestOfSegments(from, from, object.body.start, object.body.end).apart.norm();
      object_room = std::min(object_room, distance - object.body.radius - far);
    }
    const double curvature = rods[a].plain != nullptr
                                 ? rods[a].plain->rest_curvature.norm() * rods[a].rod.rest_length.sum()
                                 : HUGE_VAL;
    turning = std::max(turning, curvature);
  }
  const auto decide = [&](bool& on, const char* name, bool needed, std::string why) {
    on = needed || full;
    plan.terms.push_back({name, on, full && !needed ? "--full; else off: " + why : std::move(why)});
  };
  const auto apart = [](double gap) {
    return gap > 0 ? "nothing comes nearer than " + ShortNumber(gap) + " m" : std::string("they can meet");
  };
  if (rods.size() > 1) decide(plan.rod_contact, "contact of rods", room <= 0, apart(room));
  if (!scene.objects.empty()) {
    decide(plan.object_contact, "contact with the object", object_room <= 0, apart(object_room));
  }
  decide(plan.self_contact, "contact of a rod with itself", turning > std::numbers::pi,
         std::isfinite(turning)
             ? "a rod turns by " + ShortNumber(turning) + " rad; less than half a turn does not close"
             : std::string("a tentacle coils"));
  plan.terms.push_back({"gravity", scene.gravity.norm() > 0, ShortNumber(scene.gravity.norm()) + " m/s^2"});
  return plan;
}

Result<Simulated> Simulate(const Scene& scene, const SimulationPlan& plan, const std::vector<double>& times,
                           std::uint64_t trial, const Progress& progress) {
  if (times.empty() || times.front() < 0 || !std::is_sorted(times.begin(), times.end())) {
    return Error{ErrorKind::kBadInput, "times: expected seconds from 0 on, in ascending order"};
  }
  Result<std::vector<Driven>> made = MakeRods(scene, trial);
  if (!made.ok()) return made.error();
  std::vector<Driven> rods = std::move(made).value();
  Stepper stepper(scene,
                  {.rods = plan.rod_contact, .selves = plan.self_contact, .bodies = plan.object_contact},
                  plan.plain, rods);
  Simulated result;
  std::vector<std::vector<FramedCurve>> curves(rods.size());
  std::vector<double> reached;
  double now = 0;
  for (const double time : times) {
    while (now < time && result.diverged.empty() && !result.stopped) {
      // At most a thousand steps between two looks at the progress.
      const double left = time - now;
      const double whole = std::max(1.0, std::ceil(left / plan.time_step * (1 - 1e-12)));
      const int steps = static_cast<int>(std::min(whole, 1000.0));
      const double step = left / whole;
      result.diverged = stepper.Advance(now, steps, step);
      result.steps += steps;
      now = steps == whole ? time : now + steps * step;
      result.stopped = progress && !progress(times.back() > 0 ? now / times.back() : 1);
    }
    if (!result.diverged.empty() || result.stopped) break;
    reached.push_back(time);
    for (std::size_t r = 0; r < rods.size(); ++r) curves[r].push_back(CurveOf(rods[r].rod));
  }
  if (const ContactList* contacts = stepper.contacts()) {
    result.least_axis_distance = contacts->least_distance();
    result.least_axis_share = contacts->least_share();
    result.longest_move = contacts->longest_move();
    result.nothing_passed = contacts->NothingPassed();
  }
  if (!result.diverged.empty()) {
    result.diverged += "; try time_step = " + ShortNumber(0.5 * plan.time_step);
  }
  for (std::size_t r = 0; r < rods.size(); ++r) {
    result.curves.push_back(
        {.name = rods[r].name,
         .time = Eigen::Map<const Eigen::VectorXd>(reached.data(), static_cast<Index>(reached.size())),
         .curves = std::move(curves[r]),
         .sigma = {},
         .interpolated = {},
         .covariance_factor = {}});
  }
  return result;
}

}  // namespace tendril
