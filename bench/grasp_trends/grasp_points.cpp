#include "bench/grasp_trends/grasp_points.h"

#include <fmt/format.h>

namespace tendril {
namespace {

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
constexpr double kLength = 0.75;  // of a tentacle, m
// Where one number at a time is varied: where outcomes differ.
constexpr double kSensitivityDepth = 0.25;  // m
const char* const kBending = "gripper.design=../designs/bending.toml";

// The object hangs that far below the carrier, m.
std::string Depth(double depth) { return fmt::format("object.0.position.2={:.2f}", -depth); }

GraspPoint AtDistance(const std::string& scene, int beta_deg, double depth, double paper,
                      const std::string& says) {
  GraspPoint point{.line = fmt::format("beta {} degrees", beta_deg),
                   .label = fmt::format("{:.1f} %", 100 * depth / kLength),
                   .x = 100 * depth / kLength,
                   .scene = scene,
                   .settings = {Depth(depth)},
                   .paper = paper,
                   .paper_says = says};
  if (beta_deg == 90) point.settings.emplace_back(kBending);
  return point;
}

GraspSeries Distance() {
  const std::string tube = "tube.toml";
  return {
      "distance",
      {{"in air",
        "distance from the carrier (% of the length)",
        {AtDistance(tube, 75, 0.05, 1, "consistent"), AtDistance(tube, 75, 0.15, 1, "100 % (8 pairs)"),
         AtDistance(tube, 75, 0.25, kNoNumber, "falls, above beta 90"),
         AtDistance(tube, 75, 0.35, kNoNumber, "occasional"), AtDistance(tube, 90, 0.05, 1, "consistent"),
         AtDistance(tube, 90, 0.15, kNoNumber, "begins to fall"),
         AtDistance(tube, 90, 0.25, kNoNumber, "falls"), AtDistance(tube, 90, 0.35, 0, "fails near 50 %")}}}};
}

// The same where tentacles get shorter and the carrier stays as it is, as in the experiment.
GraspSeries Shorter() {
  GraspSeries shorter = Distance();
  shorter.name = "shorter";
  shorter.panels[0].title = "in air, the carrier stays, tentacles get shorter";
  for (GraspPoint& point : shorter.panels[0].points) {
    point.settings.emplace_back("gripper.shortening='true'");
  }
  return shorter;
}

// As Distance, with the string that the paper's Methods describe, from the carrier's centre to the object:
// short, so that the object cannot be pushed far aside. A lift would pull on that string, and is left out.
GraspSeries Tied() {
  constexpr double kTubeRadius = 0.0225;  // m
  GraspSeries tied = Distance();
  tied.name = "tied";
  tied.panels[0].title = "in air, tied to the carrier's centre";
  for (GraspPoint& point : tied.panels[0].points) {
    const double length = point.x / 100 * kLength - kTubeRadius;
    point.lift = false;
    point.settings.push_back(fmt::format("object.0.string_length={:.4f}", length));
  }
  return tied;
}

// Tied, and as heavy beside the rods as in the experiment: the paper's rod weighs 55 g, its ribbon 2 g, so
// that a tube of 15 g is 27.5 times too light to stand up to the rods. (Lighter rods that are as much softer
// come to the same.)
GraspSeries Weight() {
  GraspSeries weight = Tied();
  weight.name = "weight";
  weight.panels[0].title = "in air, tied, 27.5 times as heavy";
  for (GraspPoint& point : weight.panels[0].points) point.settings.emplace_back("object.0.mass=0.4125");
  return weight;
}

GraspSeries Pairs() {
  const auto with = [](int pairs, double paper, const std::string& says) {
    GraspPoint point = AtDistance("tube.toml", 75, 0.15, paper, says);
    point.label = std::to_string(pairs);
    point.x = pairs;
    if (pairs == 8) return point;
    point.settings.push_back(fmt::format("gripper.tentacles={}", 2 * pairs));
    point.settings.push_back(fmt::format("gripper.first_azimuth_deg={:g}", 180.0 / (2 * pairs)));
    return point;
  };
  return {"pairs",
          {{"at 20 % of the length",
            "pairs of tentacles",
            {with(2, 0, "no grasp"), with(4, kNoNumber, "more than 2 pairs"), with(8, 1, "100 %")}}}};
}

// Four pairs, for which a tube fits between the tentacles of smaller carriers, too. The carrier grows with
// the pull in place of the tentacles' shortening, as in the paper's simulation, or the tentacles get shorter.
GraspSeries Carrier() {
  GraspPanel panel{"four pairs, at 20 % of the length", "radius of the carrier (mm)", {}};
  for (const int beta : {75, 90}) {
    for (const bool shorter : {false, true}) {
      for (const double radius : {0.10, 0.12, 0.15}) {
        GraspPoint point = AtDistance("tube.toml", beta, 0.15, kNoNumber, "");
        if (shorter) point.line += ", shorter";
        point.label = fmt::format("{:g} mm", 1e3 * radius);
        point.x = 1e3 * radius;
        // The same words as in the series of pairs, where it is the same grasp.
        point.settings.emplace_back("gripper.tentacles=8");
        point.settings.emplace_back("gripper.first_azimuth_deg=22.5");
        if (radius < 0.15) point.settings.push_back(fmt::format("gripper.carrier_radius={:g}", radius));
        if (shorter) point.settings.emplace_back("gripper.shortening='true'");
        panel.points.push_back(std::move(point));
      }
    }
  }
  return {"carrier", {panel}};
}

GraspSeries Water() {
  const std::string tube = "underwater.toml";
  GraspPanel panel{"under water", "distance from the carrier (% of the length)", {}};
  const struct {
    double depth, twisting, bending;
  } paper[] = {{0.10, 1, 1}, {0.30, 1, 1}, {0.40, 0.8, 0.6}, {0.50, 0.4, 0.2}, {0.60, kNoNumber, kNoNumber}};
  for (const int beta : {75, 90}) {
    for (const auto& at : paper) {
      const double rate = beta == 75 ? at.twisting : at.bending;
      panel.points.push_back(AtDistance(tube, beta, at.depth, rate,
                                        rate >= 0 ? fmt::format("{:g} %", 100 * rate) : "both succeed"));
    }
  }
  return {"water", {panel}};
}

// One number at a time, about the scene as it is.
GraspPanel Varied(const std::string& title, const std::string& x_label, const std::vector<double>& values,
                  double usual, const std::vector<std::pair<std::string, double>>& keys) {
  GraspPanel panel{title, x_label, {}};
  for (const double value : values) {
    GraspPoint point = AtDistance("tube.toml", 75, kSensitivityDepth, kNoNumber, "");
    point.label = fmt::format("{:g}", value);
    point.x = value;
    if (value < usual || value > usual) {
      for (const auto& [key, unit] : keys) {
        point.settings.push_back(fmt::format("{}={:g}", key, value * unit));
      }
    }
    panel.points.push_back(std::move(point));
  }
  return panel;
}

// How the pairs are made: as mirror images, or of one design with its face in and out in turn, as in the
// paper's simulation.
GraspPanel Faces() {
  GraspPanel panel{"pairs of tentacles", "0: mirror images, 1: faces in and out in turn", {}};
  for (const int beta : {75, 90}) {
    for (const bool turned : {false, true}) {
      GraspPoint point = AtDistance("tube.toml", beta, kSensitivityDepth, kNoNumber, "");
      point.label = turned ? "faces in and out" : "mirror images";
      point.x = turned ? 1 : 0;
      if (turned) point.settings.emplace_back("gripper.handedness=normals");
      panel.points.push_back(std::move(point));
    }
  }
  return panel;
}

GraspSeries Sensitivity() {
  return {
      "sensitivity",
      {Varied("friction", "coefficient of friction", {0.1, 0.3, 0.6}, 0.3, {{"contact.friction", 1}}),
       Varied("stiffness of the rods", "moduli over those of the scene", {0.3, 1, 3}, 1,
              {{"gripper.rod.youngs_modulus", 1.6e6}, {"gripper.rod.shear_modulus", 5.333333e5}}),
       Varied("stiffness of contact", "stiffness over that of the scene", {0.3, 1, 3}, 1,
              {{"contact.stiffness", 1e5}}),
       Varied("elements", "elements of a rod", {50, 75, 100}, 75, {{"gripper.rod.elements", 1}}), Faces()}};
}

}  // namespace

std::vector<GraspSeries> AllGraspSeries() {
  return {Distance(), Shorter(), Tied(), Weight(), Pairs(), Carrier(), Water(), Sensitivity()};
}

std::string JoinedSettings(const std::vector<std::string>& settings) {
  return fmt::format("{}", fmt::join(settings, " "));
}

}  // namespace tendril
