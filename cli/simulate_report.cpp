#include "cli/simulate_report.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "analysis/link/seen_from.h"
#include "cli/command.h"
#include "db/files/scene_toml.h"
#include "model/fold/rising_fold.h"
#include "model/scene/holding.h"

namespace tendril::cli {
namespace {

using Json = nlohmann::ordered_json;

Json JsonOf(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

// To a tenth of a millimetre, m.
std::string PlaceText(const Eigen::Vector3d& v) {
  const auto rounded = [](double x) { return std::round(1e4 * x) / 1e4 + 0.0; };
  return fmt::format("({}, {}, {})", rounded(v.x()), rounded(v.y()), rounded(v.z()));
}

std::string NameOf(ObjectMotion motion) {
  return motion == ObjectMotion::kFixed ? "fixed" : motion == ObjectMotion::kFree ? "free" : "hanging";
}

// A design that a calibration wrote folds otherwise than the published law has it.
void TellFold(const Scene& scene, Output& out) {
  if (!scene.gripper) return;
  const TentacleDesign& design = scene.gripper->design;
  if (!design.law && design.pull_scale == 1) return;
  const std::string law =
      design.law ? fmt::format("law {}, as the design states it", NameOf(*design.law)) : "as published";
  std::vector<std::string> values = {fmt::format("pull_scale {:.4g}", design.pull_scale),
                                     fmt::format("stiffness_ratio {:.4g}", design.stiffness_ratio),
                                     fmt::format("stiffness_exponent {:.4g}", design.stiffness_exponent)};
  if (design.law) {
    values.push_back(fmt::format("rest angle {:.3g} deg", design.rest_angle * 180 / std::numbers::pi));
    values.push_back(fmt::format("friction {:.3g}", design.tendon_friction));
  }
  out.Print("folds by {} (design {}): {}", law, scene.gripper->design_name, fmt::join(values, ", "));
  out.fields()["fold_law"] = {{"law", design.law ? nlohmann::ordered_json(NameOf(*design.law)) : nullptr},
                              {"pull_scale", design.pull_scale},
                              {"stiffness_ratio", design.stiffness_ratio},
                              {"stiffness_exponent", design.stiffness_exponent},
                              {"rest_angle_deg", design.rest_angle * 180 / std::numbers::pi},
                              {"friction", design.tendon_friction}};
}

}  // namespace

nlohmann::ordered_json TermsOf(const SimulationPlan& plan) {
  auto terms = nlohmann::ordered_json::array();
  for (const PlanTerm& term : plan.terms) {
    terms.push_back({{"name", term.name}, {"on", term.on}, {"why", term.why}});
  }
  return terms;
}

void TellPlan(const Scene& scene, const SimulationPlan& plan, bool reasons, Output& out) {
  auto& fields = out.fields();
  const std::string level = NameOf(scene.level);
  fields["level"] = level;
  if (scene.level == SimulationLevel::kStatic) {
    out.Print("level static: equilibria, without contact and inertia");
  } else {
    fields["time_step_s"] = plan.time_step;
    out.Print("level {}, steps of {:.3g} s: {}", level, plan.time_step, plan.step_why);
  }
  TellFold(scene, out);
  fields["terms"] = TermsOf(plan);
  std::vector<std::string> on, off;
  for (const PlanTerm& term : plan.terms) {
    (term.on ? on : off).push_back(term.name);
    if (reasons) out.Print("  {:<3} {}: {}", term.on ? "on" : "off", term.name, term.why);
  }
  if (reasons) return;
  if (!on.empty()) out.Print("  on:  {}", fmt::join(on, ", "));
  if (!off.empty()) out.Print("  off: {}", fmt::join(off, ", "));
  if (!plan.terms.empty()) out.Print("  (--plan says why)");
}

void TellRun(const Scene& scene, const Simulated& done, double wall_s, Output& out) {
  auto& fields = out.fields();
  const double reached = done.curves[0].time.size() > 0 ? done.curves[0].time.tail<1>()[0] : 0;
  fields["wall_s"] = wall_s;
  fields["steps"] = done.steps;
  fields["diverged"] = done.diverged.has_value();
  if (done.diverged) {
    fields["divergence"] = {{"time_s", done.diverged->time},
                            {"rod", done.diverged->rod},
                            {"element", done.diverged->element},
                            {"why", done.diverged->why},
                            {"suggested_step_s", done.diverged->suggested_step}};
  }
  const double speed = std::max(0.0, reached - done.resumed_at) / wall_s;
  fields["times_real_time"] = speed;
  out.Print("{:.4g} s of {:.4g} in {:.3g} s: {:.3g} times real time, {} {}", reached, scene.duration, wall_s,
            speed, done.steps, scene.level == SimulationLevel::kStatic ? "equilibria" : "steps");
}

void TellObjects(const Scene& scene, const Simulated& done, Output& out) {
  auto& list = out.fields()["objects"] = Json::array();
  // The published laws do not add up what they do to objects.
  const bool contact =
      scene.level != SimulationLevel::kStatic && scene.contact.law == ContactLaw::kHertzSegments;
  for (std::size_t o = 0; o < done.objects.size(); ++o) {
    const ObjectSeries& series = done.objects[o];
    const SceneObject& object = scene.objects[o];
    const Eigen::Isometry3d& pose = series.poses.back();
    const Eigen::Vector3d start = object.pose.translation(), end = pose.translation();
    const double moved = (end - start).norm();
    const double turned =
        Eigen::AngleAxisd(object.pose.linear().transpose() * pose.linear()).angle() * 180 / M_PI;
    const double force = series.forces.back().norm();
    const bool touched = force > 0;
    list.push_back({{"name", series.name},
                    {"kind", object.kind},
                    {"motion", NameOf(object.motion)},
                    {"start_m", JsonOf(start)},
                    {"end_m", JsonOf(end)},
                    {"moved_m", moved},
                    {"turned_deg", turned},
                    {"touched_at_end", contact ? Json(touched) : Json(nullptr)},
                    {"force_N", contact ? JsonOf(series.forces.back()) : Json(nullptr)}});
    const std::string touch = !contact  ? ""
                              : touched ? fmt::format("; at the end rods press on it with {:.3g} N", force)
                                        : "; at the end no rod touches it";
    if (object.motion == ObjectMotion::kFixed) {
      out.Print("object {}: fixed at {} m{}", series.name, PlaceText(start), touch);
      continue;
    }
    out.Print("object {}: {}, from {} to {} m, {:.1f} mm away, turned by {:.1f} deg{}", series.name,
              NameOf(object.motion), PlaceText(start), PlaceText(end), 1e3 * moved, turned, touch);
  }
}

std::optional<Axis> AxisOf(const SceneObject& object) {
  if (object.kind != "cylinder" && object.kind != "capsule") return std::nullopt;
  return Axis{object.pose.translation(),
              (object.pose * object.shape.at(0).object_from_primitive).linear().col(2)};
}

Result<LinkSeries> TellLink(const Scene& scene, const Simulated& done, std::optional<double> grasped_until,
                            Output& out) {
  LinkOptions options;
  const std::optional<std::size_t> grasped = GraspedObject(scene);
  if (grasped) options.axis = AxisOf(scene.objects[*grasped]);
  // The axis is where it was at the start; curves go with an object that moved.
  const bool moves = options.axis && scene.objects[*grasped].motion != ObjectMotion::kFixed;
  Result<LinkSeries> links =
      MeasureLinkSeries(moves ? SeenFrom(done.objects[*grasped].poses, done.curves) : done.curves, options);
  if (!links.ok()) return links;
  if (grasped_until) links.value().EndBy(*grasped_until);
  auto& list = out.fields()["link"] = Json::array();
  int jumps = 0;
  for (const LinkEvent& event : links.value().events)
    jumps += event.kind == LinkEvent::Kind::kBodyPassed ? 1 : 0;
  for (size_t f = 0; f < links.value().frames.size(); ++f) {
    const LinkReport& report = links.value().frames[f];
    list.push_back({{"time", links.value().time[static_cast<Eigen::Index>(f)]},
                    {"mutual_link", NumberOrNull(report.mutual_link)},
                    {"object_link", NumberOrNull(report.object_link)}});
  }
  const bool certain = done.nothing_passed.value_or(false);
  out.fields()["bodies_passed"] = certain ? 0 : jumps;
  out.fields()["link_jumps"] = jumps;
  const LinkReport& end = links.value().AtEnd();
  out.fields()["mutual_link"] = NumberOrNull(end.mutual_link);
  out.fields()["object_link"] = NumberOrNull(end.object_link);
  out.fields()["link_time_s"] = links.value().EndTime();
  const std::string when =
      grasped_until ? fmt::format(" at {:.4g} s, before the test", links.value().EndTime()) : "";
  if (done.curves.size() > 1) out.Print("mutual link {:.4f} turns{}", end.mutual_link, when);
  if (options.axis) out.Print("object link {:.4f} turns{}", end.object_link, when);
  if (grasped && !options.axis) out.Print("no object link: a {} has no axis", scene.objects[*grasped].kind);
  if (jumps > 0 && certain) {
    out.Print(
        "{} jumps of a link between frames, though no body passed through another: to links the object's "
        "axis is "
        "a line without ends, and rods went around the object's",
        jumps);
  } else if (jumps > 0) {
    out.Warn(fmt::format(
        "{} jumps of a link by a whole turn between frames: a body passed through another, or around "
        "an end of the object, whose axis is a line without ends to links",
        jumps));
  }
  return links;
}

void TellPassages(const Simulated& done, Output& out) {
  auto& fields = out.fields();
  fields["nothing_passed"] = nullptr;
  if (!done.nothing_passed) return;
  const bool touched = std::isfinite(done.least_axis_distance);
  fields["nothing_passed"] = *done.nothing_passed;
  fields["least_axis_distance_m"] = NumberOrNull(done.least_axis_distance);
  fields["least_axis_share"] = NumberOrNull(done.least_axis_share);
  fields["longest_move_m"] = done.longest_move;
  fields["longest_stick_share"] = done.longest_stick;
  if (touched) {
    out.Print("contact: axes never nearer than {:.3g} mm ({:.2f} of the radii's sum)",
              1e3 * done.least_axis_distance, done.least_axis_share);
  }
  out.Print(
      "nodes never moved farther than {:.3g} mm in a step: {}", 1e3 * done.longest_move,
      *done.nothing_passed ? "no body passed through another" : "a body may have passed through another");
}

void TellDoubts(const Simulated& done, Output& out) {
  out.fields()["trusted"] = done.doubts.empty();
  out.fields()["doubts"] = done.doubts;
  if (done.doubts.empty()) return;
  out.Warn(fmt::format(
      "the run cannot be trusted: {} (stiffer contact, slower motions or a shorter step may help)",
      fmt::join(done.doubts, "; ")));
}

}  // namespace tendril::cli
