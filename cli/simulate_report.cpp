#include "cli/simulate_report.h"

#include <cmath>

#include "db/files/scene_toml.h"

namespace tendril::cli {

nlohmann::ordered_json TermsOf(const SimulationPlan& plan) {
  auto terms = nlohmann::ordered_json::array();
  for (const PlanTerm& term : plan.terms) {
    terms.push_back({{"name", term.name}, {"on", term.on}, {"why", term.why}});
  }
  return terms;
}

void TellPlan(const Scene& scene, const SimulationPlan& plan, Output& out) {
  auto& fields = out.fields();
  const std::string level = NameOf(scene.level);
  fields["level"] = level;
  if (scene.level == SimulationLevel::kStatic) {
    out.Print("level static: equilibria, without contact and inertia");
  } else {
    fields["time_step_s"] = plan.time_step;
    out.Print("level {}, steps of {:.3g} s: {}", level, plan.time_step, plan.step_why);
  }
  fields["terms"] = TermsOf(plan);
  for (const PlanTerm& term : plan.terms) {
    out.Print("  {:<3} {}: {}", term.on ? "on" : "off", term.name, term.why);
  }
}

std::optional<Axis> AxisOf(const Scene& scene) {
  for (const SceneObject& object : scene.objects) {
    const FixedBody& body = object.body;
    if (body.start != body.end) return Axis{body.start, body.end - body.start};
  }
  return std::nullopt;
}

Result<LinkSeries> TellLink(const Scene& scene, const std::vector<CurveSeries>& curves, Output& out) {
  LinkOptions options;
  options.axis = AxisOf(scene);
  Result<LinkSeries> links = MeasureLinkSeries(curves, options);
  if (!links.ok()) return links;
  const auto or_null = [](double value) {
    return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
  };
  auto& list = out.fields()["link"] = nlohmann::ordered_json::array();
  int passed = 0;
  for (const LinkEvent& event : links.value().events)
    passed += event.kind == LinkEvent::Kind::kBodyPassed ? 1 : 0;
  for (size_t f = 0; f < links.value().frames.size(); ++f) {
    const LinkReport& report = links.value().frames[f];
    list.push_back({{"time", links.value().time[static_cast<Eigen::Index>(f)]},
                    {"mutual_link", or_null(report.mutual_link)},
                    {"object_link", or_null(report.object_link)}});
  }
  out.fields()["bodies_passed"] = passed;
  const LinkReport& end = links.value().AtEnd();
  if (curves.size() > 1) out.Print("mutual link {:.4f} turns", end.mutual_link);
  if (options.axis) out.Print("object link {:.4f} turns", end.object_link);
  if (passed > 0) {
    out.Warn(fmt::format(
        "{} jumps of a link by a whole turn between frames: a body went through another, or through "
        "another's extension to infinity",
        passed));
  }
  return links;
}

void TellPassages(const Simulated& done, Output& out) {
  auto& fields = out.fields();
  fields["nothing_passed"] = nullptr;
  if (!done.nothing_passed) return;
  const bool touched = std::isfinite(done.least_axis_distance);
  fields["nothing_passed"] = *done.nothing_passed;
  fields["least_axis_distance_m"] =
      touched ? nlohmann::ordered_json(done.least_axis_distance) : nlohmann::ordered_json(nullptr);
  fields["longest_move_m"] = done.longest_move;
  const char* const verdict =
      *done.nothing_passed ? "no body passed through another" : "a body may have passed through another";
  if (touched) {
    out.Print("contact: axes never nearer than {:.3g} mm ({:.2f} of the radii's sum)",
              1e3 * done.least_axis_distance, done.least_axis_share);
  }
  out.Print("nodes never moved farther than {:.3g} mm in a step: {}", 1e3 * done.longest_move, verdict);
  const double overlap = 1 - done.least_axis_share;
  if (touched && overlap > 0.125) {
    out.Warn(fmt::format("bodies overlapped by {:.0f} % of a radius: the contact is too soft to be believed",
                         200 * overlap));
  }
  if (!*done.nothing_passed) {
    out.Warn(fmt::format("{}: the contact is too soft or the step too long", verdict));
  }
}

}  // namespace tendril::cli
