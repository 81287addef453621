#include "model/scene/simulate.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <span>

#include "model/geometry/segment_distance.h"
#include "model/rods/rod_lanes.h"
#include "model/rods/rod_plain.h"
#include "model/scene/actuation.h"

namespace tendril {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

std::string Number(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::general, 4);
  return {text, end.ptr};
}

// A rod of the scene and what drives it.
struct Driven {
  std::string name;
  Rod rod;
  double damping = 0;
  Vector3d tip_force = Vector3d::Zero();
  Vector3d start = Vector3d::Zero();    // of node 0
  Vector3d outward = Vector3d::Zero();  // by which node 0 moves per metre of the carrier's radius
  const SceneRod* plain = nullptr;
  std::optional<TentacleActuation> actuation;
};

Result<std::vector<Driven>> MakeRods(const Scene& scene, std::uint64_t trial) {
  std::vector<Driven> all;
  if (scene.gripper) {
    const SceneGripper& g = *scene.gripper;
    for (int i = 0; i < g.gripper.tentacles; ++i) {
      const Result<TentacleLayout> layout = LayOut(DesignOfTentacle(g.gripper, g.design, i));
      if (!layout.ok()) return layout.error();
      const Eigen::Isometry3d pose = LabFromTentacle(g.gripper, i);
      RodDesign design = g.rod;
      design.length = g.design.length;
      design.taper = g.design.taper;
      design.start = pose * Vector3d(0, 0, layout.value().base_z);
      design.direction = pose.linear().col(2);
      design.normal = pose.linear().col(0);
      design.clamped = true;
      Result<Rod> rod = MakeRod(design);
      if (!rod.ok()) return rod.error();
      Result<TentacleActuation> actuation = TentacleActuation::Make(g, scene.seed, trial, i);
      if (!actuation.ok()) return actuation.error();
      const double azimuth = g.gripper.first_azimuth + 2 * std::numbers::pi * i / g.gripper.tentacles;
      all.push_back({"tentacle" + std::to_string(i), std::move(rod).value(), g.damping, Vector3d::Zero(),
                     design.start, Vector3d(std::cos(azimuth), std::sin(azimuth), 0), nullptr,
                     std::move(actuation).value()});
    }
  }
  for (const SceneRod& plain : scene.rods) {
    Result<Rod> made = MakeRod(plain.design);
    if (!made.ok()) return made.error();
    Rod rod = std::move(made).value();
    const Vector3d centre = (rod.position * rod.mass) / rod.mass.sum();
    for (Index i = 0; i < rod.mass.size(); ++i) {
      if (rod.clamped && i == 0) continue;
      rod.velocity.col(i) = plain.velocity + plain.spin.cross(Vector3d(rod.position.col(i) - centre));
    }
    for (Index i = rod.clamped ? 1 : 0; i < rod.elements(); ++i) {
      rod.spin.col(i) = rod.directors[static_cast<std::size_t>(i)] * plain.spin;
    }
    all.push_back({plain.name, std::move(rod), plain.damping, plain.tip_force, plain.design.start,
                   Vector3d::Zero(), &plain, std::nullopt});
  }
  return all;
}

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

// The carrier's growth at a time, m.
double CarrierGrowth(const Scene& scene, const std::vector<Driven>& rods, double time) {
  if (!scene.gripper || scene.gripper->shortening != Shortening::kCarrier) return 0;
  double pull = 0;
  for (const Driven& d : rods) {
    if (d.actuation) pull += d.actuation->PullAt(time) / scene.gripper->gripper.tentacles;
  }
  return scene.gripper->gripper.carrier_radius * pull / (1 - pull);
}

// Base, rest curvature and rest strain of that moment.
void Drive(const Scene& scene, Driven& d, double growth, double time) {
  Rod& rod = d.rod;
  if (d.actuation) {
    const double pull = d.actuation->PullAt(time);
    d.actuation->RestCurvature(pull, rod.rest_curvature);
    if (scene.gripper->shortening == Shortening::kTrue) rod.rest_strain.row(2).setConstant(-pull);
    rod.position.col(0) = d.start + growth * d.outward;
  } else if (d.plain != nullptr) {
    const double length = d.plain->ramp_end - d.plain->ramp_start;
    const double share = length > 0 ? std::clamp((time - d.plain->ramp_start) / length, 0.0, 1.0)
                                    : (time >= d.plain->ramp_start ? 1.0 : 0.0);
    rod.rest_curvature.colwise() = share * d.plain->rest_curvature;
  }
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

// Rods that touch nothing, eight at a time.
struct Batch {
  std::vector<std::size_t> members;
  std::optional<LaneRods<double>> lanes;
};

class Stepper {
 public:
  Stepper(const Scene& scene, const SimulationPlan& plan, std::vector<Driven>& rods)
      : scene_(scene),
        rods_(rods),
        touching_(plan.rod_contact || plan.self_contact || plan.object_contact),
        plan_(plan) {
    options_.form = scene.level == SimulationLevel::kPaper ? RodForm::kPaper : RodForm::kEnergy;
    options_.gravity = scene.gravity;
  }

  // Empty: all went well.
  std::string Advance(double time, int steps, double step) {
    options_.time_step = step;
    return touching_ ? AdvanceTouching(time, steps) : AdvanceApart(time, steps);
  }

 private:
  // All in the plain form, as contact has no fast form yet. Rods damped differently lose speed at a step's
  // end.
  std::string AdvanceTouching(double time, int steps) {
    std::vector<Rod> rods;
    for (Driven& d : rods_) rods.push_back(std::move(d.rod));
    const bool one_damping = std::all_of(rods_.begin(), rods_.end(),
                                         [&](const Driven& d) { return d.damping == rods_[0].damping; });
    options_.damping = one_damping ? rods_[0].damping : 0;
    std::string trouble;
    for (int i = 0; i < steps && trouble.empty(); ++i) {
      const double now = time + i * options_.time_step;
      StepPlain(rods, now, options_, [&](double middle, std::span<Rod> at, std::span<Matrix3Xd> forces) {
        const double growth = CarrierGrowth(scene_, rods_, middle);
        for (std::size_t r = 0; r < at.size(); ++r) {
          rods_[r].rod = std::move(at[r]);
          Drive(scene_, rods_[r], growth, middle);
          at[r] = std::move(rods_[r].rod);
          forces[r].rightCols<1>() += rods_[r].tip_force;
          if (plan_.self_contact) AddSelfContact(scene_.contact, at[r], forces[r]);
          for (const SceneObject& object : scene_.objects) {
            if (plan_.object_contact) AddBodyContact(scene_.contact, at[r], object.body, forces[r]);
          }
          for (std::size_t other = 0; plan_.rod_contact && other < r; ++other) {
            AddRodContact(scene_.contact, at[r], at[other], forces[r], forces[other]);
          }
        }
      });
      for (std::size_t r = 0; r < rods.size(); ++r) {
        const double keep = one_damping ? 1 : std::exp(-rods_[r].damping * options_.time_step);
        rods[r].velocity *= keep;
        rods[r].spin *= keep;
        if (!std::isfinite(rods[r].position.sum() + rods[r].velocity.sum() + rods[r].spin.sum())) {
          trouble = "at " + Number(now) + " s " + rods_[r].name + " has positions that are not finite";
        }
      }
    }
    for (std::size_t r = 0; r < rods.size(); ++r) rods_[r].rod = std::move(rods[r]);
    return trouble;
  }

  std::string AdvanceApart(double time, int steps) {
    if (batches_.empty()) MakeBatches();
    for (Batch& batch : batches_) {
      const Driven& first = rods_[batch.members[0]];
      PlainOptions options = options_;
      options.damping = first.damping;
      const int made =
          batch.lanes->Advance(steps, time, options, [&](double middle, LaneRods<double>& lanes) {
            const double growth = CarrierGrowth(scene_, rods_, middle);
            for (std::size_t lane = 0; lane < batch.members.size(); ++lane) {
              Driven& d = rods_[batch.members[lane]];
              Drive(scene_, d, growth, middle);
              const auto put = [&](std::span<double> to, const auto& from) {
                for (Index i = 0; i < from.size(); ++i) {
                  to[static_cast<std::size_t>(i) * kRodLanes + lane] = from.data()[i];
                }
              };
              put(lanes.rest_curvatures(), d.rod.rest_curvature);
              if (d.actuation) {
                put(lanes.rest_strains(), d.rod.rest_strain);
                put(lanes.positions(), d.rod.position.col(0).eval());
              }
              put(lanes.forces().subspan(static_cast<std::size_t>(3 * d.rod.elements()) * kRodLanes),
                  d.tip_force);
            }
          });
      std::vector<Rod> state;
      for (const std::size_t r : batch.members) state.push_back(std::move(rods_[r].rod));
      batch.lanes->Store(state);
      for (std::size_t k = 0; k < state.size(); ++k) rods_[batch.members[k]].rod = std::move(state[k]);
      if (!batch.lanes->trouble().any()) continue;
      const char* what = batch.lanes->trouble().not_finite
                             ? " have positions that are not finite"
                             : " turn too far, in a step or from element to element";
      return "at " + Number(time + made * options_.time_step) + " s " + first.name + " or a rod beside it" +
             what;
    }
    return "";
  }

  void MakeBatches() {
    for (std::size_t r = 0; r < rods_.size(); ++r) {
      const auto fits = [&](const Batch& batch) {
        const Driven& first = rods_[batch.members[0]];
        return batch.members.size() < kRodLanes && first.rod.elements() == rods_[r].rod.elements() &&
               first.damping == rods_[r].damping;
      };
      const auto batch = std::find_if(batches_.begin(), batches_.end(), fits);
      if (batch == batches_.end()) {
        batches_.push_back({{r}, {}});
      } else {
        batch->members.push_back(r);
      }
    }
    for (Batch& batch : batches_) {
      std::vector<Rod> state;
      for (const std::size_t r : batch.members) state.push_back(rods_[r].rod);
      batch.lanes = LaneRods<double>::Make(state, options_.form).value();
    }
  }

  const Scene& scene_;
  std::vector<Driven>& rods_;
  bool touching_;
  SimulationPlan plan_;
  PlainOptions options_;
  std::vector<Batch> batches_;
};

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
  plan.time_step = scene.time_step > 0 ? scene.time_step : paper ? 2e-5 : 0.5 * stable;
  plan.step_why = scene.time_step > 0 ? "the scene's time_step"
                  : paper             ? "the paper's"
                          : "half of the stable " + Number(stable) + " s of stretch, bending and shear";

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
    return gap > 0 ? "nothing comes nearer than " + Number(gap) + " m" : std::string("they can meet");
  };
  if (rods.size() > 1) decide(plan.rod_contact, "contact of rods", room <= 0, apart(room));
  if (!scene.objects.empty()) {
    decide(plan.object_contact, "contact with the object", object_room <= 0, apart(object_room));
  }
  decide(plan.self_contact, "contact of a rod with itself", turning > std::numbers::pi,
         std::isfinite(turning)
             ? "a rod turns by " + Number(turning) + " rad; less than half a turn does not close"
             : std::string("a tentacle coils"));
  plan.terms.push_back({"gravity", scene.gravity.norm() > 0, Number(scene.gravity.norm()) + " m/s^2"});
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
  Stepper stepper(scene, plan, rods);
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
  if (!result.diverged.empty()) {
    result.diverged += "; try time_step = " + Number(0.5 * plan.time_step);
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
