#include "bench/grasp_trends/grasp_points.h"

#include <fmt/format.h>

#include <cmath>

namespace tendril {
namespace {

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
constexpr double kLength = 0.75;  // of a tentacle, m
// Where one number at a time is varied: where the paper's rates are neither 0 nor 1.
constexpr double kSensitivityDepth = 0.25;  // m
const char* const kTube = "tube.toml";
const char* const kDistanceLabel = "distance from the carrier (% of the length)";

// The object hangs that far from the carrier, m.
GraspPoint AtDistance(const std::string& scene, int beta_deg, double depth, double paper,
                      const std::string& says) {
  GraspPoint point{.line = fmt::format("beta {} degrees", beta_deg),
                   .label = fmt::format("{:.1f} %", 100 * depth / kLength),
                   .x = 100 * depth / kLength,
                   .scene = scene,
                   .settings = {fmt::format("object.0.position.2={:.2f}", -depth)},
                   .paper = paper,
                   .paper_says = says};
  if (beta_deg == 90) point.settings.emplace_back("gripper.design=../designs/bending.toml");
  return point;
}

GraspSeries Distance() {
  return {
      "distance",
      10,
      {{"in air",
        kDistanceLabel,
        {AtDistance(kTube, 75, 0.05, 1, "consistent"), AtDistance(kTube, 75, 0.15, 1, "100 % (8 pairs)"),
         AtDistance(kTube, 75, 0.25, kNoNumber, "falls, above beta 90"),
         AtDistance(kTube, 75, 0.35, kNoNumber, "occasional"), AtDistance(kTube, 90, 0.05, 1, "consistent"),
         AtDistance(kTube, 90, 0.15, kNoNumber, "begins to fall"),
         AtDistance(kTube, 90, 0.25, kNoNumber, "falls"),
         AtDistance(kTube, 90, 0.35, 0, "fails near 50 %")}}}};
}

GraspSeries Pairs() {
  const auto with = [](int pairs, double paper, const std::string& says) {
    GraspPoint point = AtDistance(kTube, 75, 0.15, paper, says);
    point.label = std::to_string(pairs);
    point.x = pairs;
    if (pairs == 8) return point;
    point.settings.push_back(fmt::format("gripper.tentacles={}", 2 * pairs));
    point.settings.push_back(fmt::format("gripper.first_azimuth_deg={:g}", 180.0 / (2 * pairs)));
    return point;
  };
  return {"pairs",
          10,
          {{"in air, at 20 % of the length",
            "pairs of tentacles",
            {with(2, 0, "no grasp"), with(4, kNoNumber, "moderate"), with(8, 1, "100 %")}}}};
}

GraspSeries Water() {
  GraspPanel panel{"under water", kDistanceLabel, {}};
  const struct {
    double depth, twisting, bending;
  } paper[] = {{0.10, 1, 1},     {0.20, 1, 1},     {0.30, 1, 1},
               {0.40, 0.8, 0.6}, {0.50, 0.4, 0.2}, {0.60, kNoNumber, kNoNumber}};
  for (const int beta : {75, 90}) {
    for (const auto& at : paper) {
      const double rate = beta == 75 ? at.twisting : at.bending;
      panel.points.push_back(AtDistance("underwater.toml", beta, at.depth, rate,
                                        std::isnan(rate) ? "some" : fmt::format("{:g} %", 100 * rate)));
      panel.points.back().tugged = true;
    }
  }
  return {"water", 5, {panel}};
}

// One number at a time, about the scene as it is.
//   usual  the scene's: that point is one of Distance
//   keys   and what value 1 stands for
GraspPanel Varied(const std::string& title, const std::string& x_label, const std::vector<double>& values,
                  double usual, const std::vector<std::pair<std::string, double>>& keys,
                  const std::vector<int>& betas = {75}) {
  GraspPanel panel{title, x_label, {}};
  for (const int beta : betas) {
    for (const double value : values) {
      GraspPoint point = AtDistance(kTube, beta, kSensitivityDepth, kNoNumber, "");
      point.label = fmt::format("{:.3g}", value);
      point.x = value;
      if (value < usual || value > usual) {
        for (const auto& [key, unit] : keys) {
          point.settings.push_back(fmt::format("{}={:g}", key, value * unit));
        }
        if (title == "radius of the carrier, cm") {
          point.settings.push_back(fmt::format("object.1.radius={:g}", 1e-2 * (value - 1.5)));
        }
        // The scene's step of 5.2e-5 s would be too long.
        const bool stiffer = value > usual;
        if (stiffer && title == "stiffness of contact") point.settings.emplace_back("time_step=3e-5");
        if (stiffer && title == "stiffness of the rods") point.settings.emplace_back("time_step=4.9e-5");
      }
      panel.points.push_back(std::move(point));
    }
  }
  return panel;
}

// What is so or is not, with one setting.
GraspPanel Whether(const std::string& title, const std::string& no, const std::string& yes,
                   const std::string& setting) {
  GraspPanel panel{title, "0: " + no + ", 1: " + yes, {}};
  for (const bool is : {false, true}) {
    GraspPoint point = AtDistance(kTube, 75, kSensitivityDepth, kNoNumber, "");
    point.label = is ? yes : no;
    point.x = is ? 1 : 0;
    if (is) point.settings.push_back(setting);
    panel.points.push_back(std::move(point));
  }
  return panel;
}

GraspSeries Sensitivity() {
  return {
      "sensitivity",
      5,
      {Varied("friction", "coefficient of friction", {0.1, 0.3, 0.6}, 0.3, {{"contact.friction", 1}}),
       Varied("stiffness of the rods", "moduli over those of the scene", {0.3, 1, 3}, 1,
              {{"gripper.rod.youngs_modulus", 1.6e6}, {"gripper.rod.shear_modulus", 5.333333e5}}),
       Varied("stiffness of contact", "stiffness over that of the scene", {1.0 / 3, 1, 3}, 1,
              {{"contact.stiffness", 3e5}}),
       Varied("elements", "elements of a rod", {50, 75, 100}, 75, {{"gripper.rod.elements", 1}}),
       Varied("radius of the carrier, cm", "radius (cm)", {11, 12, 15}, 12,
              {{"gripper.carrier_radius", 1e-2}}, {75, 90}),
       // The paper's rod weighs 55 g, its ribbon 2 g, so that a tube of 15 g is 27.5 times too light to
       // stand up to the rods. (Lighter rods that are as much softer come to the same.)
       Varied("weight of the tube", "mass over the paper's", {1, 27.5}, 1, {{"object.0.mass", 0.015}}),
       Whether("pairs of tentacles", "mirror images", "faces in and out", "gripper.handedness=normals"),
       // As in the paper's simulation.
       Whether("shortening", "tentacles get shorter", "the carrier grows", "gripper.shortening=carrier")}};
}

}  // namespace

std::vector<GraspSeries> AllGraspSeries() { return {Distance(), Pairs(), Water(), Sensitivity()}; }

std::string JoinedSettings(const std::vector<std::string>& settings) {
  return fmt::format("{}", fmt::join(settings, " "));
}

}  // namespace tendril
