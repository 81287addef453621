#include "model/scene/plan.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include "model/rods/press.h"
#include "model/rods/solid_contact.h"
#include "model/rods/start_shape.h"
#include "model/scene/scene_check.h"

namespace tendril {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

// Of the stable step: what coiling, contact and stretching take of it is measured (docs/rods.md, "Step").
constexpr double kStandardShare = 0.8, kFastShare = 0.85;
// What sticks is reckoned with the bending waves, and from below.
constexpr double kStickingShare = 0.95;
constexpr double kPaperStep = 2e-5;
constexpr double kFastSlowing = 0.02;

// The strongest rest curvature that an inner node is driven to, 1/m.
double RestCurvatureAt(const Driven& d, Index inner_node) {
  if (!d.actuation)
    return std::max(d.plain->rest_curvature.norm(), StrongestStartCurvature(d.plain->design).norm());
  return d.actuation->strongest()[inner_node + 1];
}

// Of stretch and shear, the most that a rod's length changes by anywhere: by weight and loads, and, where it
// touches something, by what its bending can press with, B kappa0^2.
struct ReckonedStrains {
  double stretch = 0, shear = 0;
};
ReckonedStrains StrainsOf(const Scene& scene, const Driven& d, bool touches) {
  const Rod& rod = d.rod;
  const double length = rod.rest_length.sum();
  double beyond = d.tip_force.norm();
  double turned = 0;  // of one end against the other, rad
  if (d.plain != nullptr) {
    turned = StrongestStartCurvature(d.plain->design).z() * length;
    for (const EndMotion* motion : {&d.plain->base_motion, &d.plain->tip_motion}) {
      turned += motion->spin.norm() * std::max(0.0, motion->until - motion->from);
    }
    // What flies, spins or is led is stopped within its length.
    double speed = std::max(d.plain->velocity.norm(), length * d.plain->spin.norm());
    for (const EndMotion* motion : {&d.plain->base_motion, &d.plain->tip_motion}) {
      speed = std::max({speed, motion->velocity.norm(), length * motion->spin.norm()});
    }
    beyond += rod.mass.sum() * speed * speed / length;
  }
  ReckonedStrains strains;
  for (Index i = rod.elements(); i-- > 0;) {
    beyond += rod.mass[i + 1] * scene.gravity.norm();
    const Index inner = std::min<Index>(i, rod.bend_stiffness.cols() - 1);
    const double bending = rod.bend_stiffness.col(inner).head<2>().maxCoeff();
    double force = beyond;
    if (touches) force += bending * RestCurvatureAt(d, inner) * RestCurvatureAt(d, inner);
    // Both ends are led: what buckles the rod between them, and what it pulls with when its twist coils it,
    // M^2 / 2B at most (docs/validation.md, localised_helix).
    if (rod.tip.hold != EndHold::kFree) {
      const double moment = rod.bend_stiffness(2, inner) * turned / length;
      force += 4 * std::numbers::pi * std::numbers::pi * bending / (length * length) +
               0.5 * moment * moment / bending;
    }
    strains.stretch = std::max(strains.stretch, force / rod.shear_stiffness(2, i));
    strains.shear = std::max(strains.shear, force / rod.shear_stiffness(0, i));
  }
  // Between ends that are led a change of length shows as sag: by its root.
  if (rod.tip.hold != EndHold::kFree) strains.stretch = std::sqrt(strains.stretch);
  return strains;
}

// Something moves one of its ends, or it starts moving.
bool IsLed(const Driven& d) {
  if (d.carrier != nullptr && d.carrier->moves()) return true;
  if (d.plain == nullptr) return false;
  const auto moves = [](const EndMotion& motion) {
    return motion.until > motion.from && !(motion.velocity.isZero(0) && motion.spin.isZero(0));
  };
  return moves(d.plain->base_motion) || moves(d.plain->tip_motion);
}
bool Moves(const Driven& d) {
  return IsLed(d) || (d.plain != nullptr && !(d.plain->velocity.isZero(0) && d.plain->spin.isZero(0)));
}

// What a rod can turn by from end to end, rad: its rest curvature, and what weight and loads bend; infinite
// where it is driven or moves.
double TurningAtMost(const Scene& scene, const Driven& d) {
  if (d.actuation || d.rod.tip.hold != EndHold::kFree || Moves(d)) return HUGE_VAL;
  const double length = d.rod.rest_length.sum(), bending = d.rod.bend_stiffness.topRows<2>().minCoeff();
  // A force cannot bend a straight rod farther than into its own direction.
  const double force = d.rod.mass.sum() * scene.gravity.norm() + d.tip_force.norm();
  const double bent = std::min(0.5 * force * length * length / bending, std::numbers::pi);
  const double coiled = RestCurvatureAt(d, 0) * length + d.rod.tip_couple.norm() * length / bending;
  return coiled > 0 ? coiled + bent : 0.5 * bent;
}

// Nothing pushes the rod out of the plane across `axis`, about which it bends.
bool StaysInAPlane(const Scene& scene, const Driven& d) {
  if (d.actuation || scene.rods.size() != 1 || scene.gripper || !scene.objects.empty()) return false;
  const SceneRod& rod = *d.plain;
  const Eigen::Matrix3d& frame = d.rod.directors.front();
  for (const Index k : {0, 1}) {
    const Vector3d axis = frame.row(k).transpose();
    const auto about_axis = [&](const Vector3d& body) { return body[1 - k] == 0 && body.z() == 0; };
    const auto across = [&](const Vector3d& lab) { return std::abs(lab.dot(axis)) <= 1e-12 * lab.norm(); };
    const auto along = [&](const Vector3d& lab) { return lab.cross(axis).norm() <= 1e-12 * lab.norm(); };
    if (about_axis(rod.rest_curvature) && about_axis(StrongestStartCurvature(rod.design)) &&
        about_axis(rod.tip_couple) && across(scene.gravity) && across(rod.tip_force) &&
        across(rod.velocity) && along(rod.spin) && across(rod.base_motion.velocity) &&
        along(rod.base_motion.spin) && across(rod.tip_motion.velocity) && along(rod.tip_motion.spin)) {
      return true;
    }
  }
  return false;
}

struct Planner {
  const Scene& scene;
  const std::vector<Driven>& rods;
  bool full;
  SimulationPlan plan;

  bool Decide(const char* name, bool needed, std::string why) {
    const bool on = needed || full;
    plan.terms.push_back({name, on, full && !needed ? "--full; else off: " + why : std::move(why)});
    return on;
  }

  void Contacts() {
    const auto reach = [&](const Driven& d) {
      return d.rod.rest_length.sum() * (1 + StrainsOf(scene, d, true).stretch) + d.rod.radius.maxCoeff();
    };
    const double moves = LargestCarrierGrowth(scene);
    // A rod that nothing holds, or whose end is moved, may go anywhere.
    const auto far = [&](const Driven& d) {
      return d.rod.base.hold != EndHold::kFree && !IsLed(d) ? reach(d) + moves : HUGE_VAL;
    };
    double room = HUGE_VAL, object_room = HUGE_VAL, turning = 0;
    std::size_t meet = 0, pairs = 0;
    for (std::size_t a = 0; a < rods.size(); ++a) {
      const Vector3d& from = rods[a].base_start;
      for (std::size_t b = 0; b < a; ++b, ++pairs) {
        const double gap = (from - rods[b].base_start).norm() - far(rods[a]) - far(rods[b]);
        room = std::min(room, gap);
        meet += gap <= 0 ? 1 : 0;
      }
      for (const SceneObject& object : scene.objects) {
        const bool stays = object.motion == ObjectMotion::kFixed;
        for (const Primitive& part : object.shape) {
          const double distance = DistanceTo(part, object.pose.inverse() * from).distance;
          object_room = std::min(object_room, stays ? distance - far(rods[a]) : -1);
        }
      }
      turning = std::max(turning, TurningAtMost(scene, rods[a]));
    }
    const auto apart = [](double gap) {
      return gap > 0 ? "nothing comes nearer than " + ShortNumber(gap) + " m" : std::string("they can meet");
    };
    if (rods.size() > 1) {
      plan.rod_contact = Decide("contact of rods", room <= 0,
                                room > 0 ? apart(room)
                                         : std::to_string(meet) + " of " + std::to_string(pairs) +
                                               " pairs are nearer to each other than they are long");
    }
    if (!scene.objects.empty()) {
      plan.object_contact = Decide("contact with the object", object_room <= 0, apart(object_room));
    }
    plan.self_contact =
        Decide("contact of a rod with itself", turning > std::numbers::pi,
               std::isfinite(turning)
                   ? "a rod turns by " + ShortNumber(turning) + " rad; less than half a turn does not close"
                   : std::string("a tentacle coils, or a rod is led, thrown or spun"));
    const char* const without = scene.level == SimulationLevel::kStatic ? "level static has no contact"
                                : scene.contact.stiffness == 0          ? "the scene's contact stiffness is 0"
                                                                        : nullptr;
    if (without == nullptr) return Press();
    plan.rod_contact = plan.self_contact = plan.object_contact = false;
    for (PlanTerm& term : plan.terms) term = {term.name, false, std::string(without) + "; else: " + term.why};
  }

  // What contact counts: friction, and how finely along the rods. Between points farther apart than
  // kPointSpacing of the radii's sum a crossing's force changes by more than a fifth as it slides
  // (docs/rods.md, "Contact").
  void Press() {
    if (!(plan.rod_contact || plan.self_contact || plan.object_contact)) return;
    constexpr double kPointSpacing = 0.4;
    double spacing = 0;
    for (const Driven& d : rods) {
      spacing = std::max(spacing, (d.rod.rest_length.array() / (2 * d.rod.radius.array())).maxCoeff());
    }
    const double points = std::ceil(spacing / kPointSpacing * (1 - 1e-9));
    plan.contact_points = static_cast<int>(std::clamp(full ? 2 * points : points, 1.0, 16.0));
    if (scene.contact.law == ContactLaw::kHertzSegments) {
      plan.terms.push_back({"contact within elements", plan.contact_points > 1,
                            std::to_string(plan.contact_points) + " points to an element, which is at most " +
                                ShortNumber(spacing) + " of the radii's sum long"});
    }
    const double friction = LargestFriction(scene);
    plan.terms.push_back({"friction", friction > 0, "mu = " + ShortNumber(friction)});
  }

  // How much softer a rod's stretch and shear, and how much larger its rotary inertia may be: each strain
  // counts where the forces that the rod is reckoned to carry change its length by more than the tolerance.
  void Strains() {
    double stretch = 0, shear = 0, rotary = HUGE_VAL;
    bool planar = true;
    const bool touches = plan.rod_contact || plan.self_contact || plan.object_contact;
    for (const Driven& d : rods) {
      const ReckonedStrains strains = StrainsOf(scene, d, touches);
      stretch = std::max(stretch, strains.stretch);
      shear = std::max(shear, strains.shear);
      // Rotary inertia slows a wave of wave number k by (k r)^2 / 8; the tenth bending mode is the last to
      // count.
      const double wave = 10 * std::numbers::pi / d.rod.rest_length.sum() * d.rod.radius.maxCoeff();
      rotary = std::min(rotary, 8 * kPlanTolerance / (wave * wave));
      planar = planar && StaysInAPlane(scene, d);
      if (scene.gripper && scene.gripper->shortening == Shortening::kTrue) stretch = HUGE_VAL;
    }
    const auto off_by = [](double strain) {
      if (!std::isfinite(strain)) return std::string("tentacles are drawn shorter");
      return "forces change lengths by at most " + ShortNumber(100 * strain) + " %";
    };
    const bool exact = scene.level == SimulationLevel::kPaper || scene.level == SimulationLevel::kStatic;
    const auto decide = [&](const char* name, double strain, double& relief) {
      const bool needed = exact || strain > 0.5 * kPlanTolerance;
      if (!Decide(name, needed, exact ? "the level takes the rods as they are" : off_by(strain))) {
        relief = std::max(1.0, kPlanTolerance / std::max(strain, 1e-12 * kPlanTolerance));
      }
    };
    decide("stretch", stretch, plan.relief.stretch);
    decide("shear", shear, plan.relief.shear);
    Decide("twist", !planar, planar ? "nothing pushes the rod out of its plane" : "rods bend in space");
    const bool rotary_needed = exact || rotary < 2;
    if (!Decide("rotary inertia", rotary_needed,
                exact ? "the level takes the rods as they are"
                      : "it slows the tenth bending mode by " + ShortNumber(100 * kPlanTolerance / rotary) +
                            " %")) {
      plan.relief.rotary_inertia = rotary;
    }
  }

  // The largest stable step of objects that rods lie on: each rod along half of what the object reaches to,
  // and turning it too, as a ball.
  double StepOfObjects() const {
    double least = HUGE_VAL;
    if (!plan.object_contact || scene.contact.law != ContactLaw::kHertzSegments) return least;
    for (const SceneObject& object : scene.objects) {
      if (object.motion == ObjectMotion::kFixed) continue;
      double stiffness = 0;
      const double along = 0.5 * ReachOf(object.shape);
      for (const Driven& d : rods) {
        const double length = std::min(along, d.rod.rest_length.sum());
        stiffness += length * SurfaceStiffness(scene.contact.stiffness, d.rod.radius.maxCoeff());
      }
      const double turning = 2.5 * scene.contact.tangential_ratio;
      if (stiffness > 0) least = std::min(least, 2 / std::sqrt(stiffness * (1 + turning) / object.mass));
      if (scene.contact.damping > 0) {
        const double reference =
            ReferenceStiffness(scene.contact.stiffness, 2 * rods[0].rod.radius.maxCoeff());
        least =
            std::min(least, object.mass * reference / (scene.contact.damping * stiffness * (1 + turning)));
      }
    }
    return least;
  }

  // Likewise of objects that stand on others by the most spheres that one of them can stand on: what lies in
  // one plane.
  double StepOfStanding() const {
    double least = HUGE_VAL;
    if (scene.objects.size() < 2 || scene.contact.law != ContactLaw::kHertzSegments) return least;
    const double stiffness = SolidContact::StiffnessOf(scene.contact);
    for (const SceneObject& object : scene.objects) {
      if (object.motion == ObjectMotion::kFixed) continue;
      const std::vector<SurfaceSphere> spheres = SurfaceSpheres(object.shape);
      double most = 0;
      for (Index axis = 0; axis < 3; ++axis) {
        for (const SurfaceSphere& one : spheres) {
          most = std::max(most, static_cast<double>(std::count_if(
                                    spheres.begin(), spheres.end(), [&](const SurfaceSphere& other) {
                                      return std::abs(other.centre[axis] - one.centre[axis]) <= 1e-9;
                                    })));
        }
      }
      // (omega h)^2 + 2 gamma h = 4, as of what sticks; turning about an edge gives three times as much.
      const double give = 4 / object.mass;
      const double gamma = most * SolidContact::DampingOf(scene.contact, object.mass) * give;
      const double square = most * stiffness * give;
      least = std::min(least, 4 / (gamma + std::sqrt(gamma * gamma + 4 * square)));
    }
    return least;
  }

  // Each relief only as large as it makes the step longer: all limits meet at that of the strongest term.
  void Step() {
    const bool paper = scene.level == SimulationLevel::kPaper;
    const bool contact = plan.rod_contact || plan.self_contact || plan.object_contact;
    const double stiffness = contact ? scene.contact.stiffness : 0;
    const RodRelief most = plan.relief;
    plan.relief = {};
    const auto steps_with = [&](const RodRelief& relief) {
      StableSteps least{HUGE_VAL, HUGE_VAL, HUGE_VAL, HUGE_VAL, HUGE_VAL};
      for (const Driven& d : rods) {
        Rod rod = d.rod;
        ApplyRelief(relief, rod);
        const StableSteps steps = StableStepsOf(rod, stiffness, contact ? scene.contact.damping : 0);
        least = {std::min(least.stretch, steps.stretch), std::min(least.bend, steps.bend),
                 std::min(least.twist, steps.twist), std::min(least.shear, steps.shear),
                 std::min(least.contact, steps.contact)};
      }
      return least;
    };
    for (int round = 0; round < 200; ++round) {
      const StableSteps steps = steps_with(plan.relief);
      const double least = steps.Least();
      RodRelief next = plan.relief;
      if (steps.stretch <= least * 1.0001) next.stretch = std::min(most.stretch, 1.1 * next.stretch);
      if (std::min(steps.bend, steps.shear) <= least * 1.0001) {
        next.rotary_inertia = std::min(most.rotary_inertia, 1.1 * next.rotary_inertia);
      }
      if (steps.shear <= least * 1.0001) next.shear = std::min(most.shear, 1.1 * next.shear);
      if (!(steps_with(next).Least() > least * 1.0001)) break;
      plan.relief = next;
    }
    if (scene.level == SimulationLevel::kFast) {
      plan.relief.mass = full ? 1 : FastMass();
      const bool light = plan.relief.mass == 1;
      plan.terms.push_back({"inertia as it is", light,
                            light ? "damping is too weak to hide more"
                                  : "damping hides " + ShortNumber(plan.relief.mass) +
                                        " times as much: slow motions are late by at most " +
                                        ShortNumber(100 * kFastSlowing) + " %"});
    }
    StableSteps steps = steps_with(plan.relief);
    steps.contact = std::min({steps.contact, StepOfObjects(), StepOfStanding()});
    double sticking = HUGE_VAL;
    for (const Driven& d : rods) {
      if (!(stiffness > 0 && LargestFriction(scene) > 0) || scene.contact.law != ContactLaw::kHertzSegments)
        break;
      Rod rod = d.rod;
      ApplyRelief(plan.relief, rod);
      sticking = std::min(sticking, kStickingShare / kStandardShare * StickingStep(rod, scene.contact));
    }
    const double least = std::min(steps.Least(), sticking);
    const double share = scene.level == SimulationLevel::kFast ? kFastShare : kStandardShare;
    plan.stable_step = least;
    plan.time_step = scene.time_step > 0 ? scene.time_step : paper ? kPaperStep : share * least;
    const char* const what = least == steps.stretch ? "stretch"
                             : least == steps.bend  ? "bending"
                             : least == steps.twist ? "twist"
                             : least == steps.shear ? "shear"
                             : least == sticking    ? "what sticks"
                                                    : "contact";
    plan.step_why = scene.time_step > 0 ? "the scene's time_step"
                    : paper ? "the paper's; " + ShortNumber(least) + " s are stable, as " + what + " has it"
                            : ShortNumber(share) + " of the stable " + ShortNumber(least) + " s of " + what;
  }

  // Where damping c is strong, rods creep, and a slow motion of frequency omega decays at omega^2 / c (1 + m
  // omega^2 / c^2 + ...) where all is m times as heavy against acceleration: m is chosen so that the second
  // term is kFastSlowing. Slow is the first bending of a clamped rod that also hangs by its weight.
  double FastMass() const {
    double least = HUGE_VAL;
    for (const Driven& d : rods) {
      // What flies coasts farther the heavier it is.
      if (Moves(d) || d.rod.base.hold == EndHold::kFree) return 1;
      const double length = d.rod.rest_length.sum();
      const double bending = 3.516 * 3.516 * d.rod.bend_stiffness.row(0).minCoeff() /
                             (d.rod.mass.sum() * length * length * length);
      const double square = bending + 1.446 * scene.gravity.norm() / length;
      least = std::min(least, std::clamp(kFastSlowing * d.damping * d.damping / square, 1.0, 16.0));
    }
    return least;
  }
};

}  // namespace

std::string ShortNumber(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::general, 6);
  return {text, end.ptr};
}

Result<SimulationPlan> PlanScene(const Scene& scene, bool full) {
  const Result<std::vector<Driven>> made = MakeRods(scene, 0);
  if (!made.ok()) return made.error();
  if (made.value().empty()) return Error{ErrorKind::kBadInput, "a scene needs a [gripper] or a [[rod]]"};
  Planner planner{scene, made.value(), full, {}};
  planner.Contacts();
  planner.Strains();
  planner.Step();
  planner.plan.terms.push_back(
      {"gravity", scene.gravity.norm() > 0, ShortNumber(scene.gravity.norm()) + " m/s^2"});
  return planner.plan;
}

}  // namespace tendril
