#include "capture/rig/tag_weight.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <vector>

namespace tendril {
namespace {

struct Layer {
  double thickness;  // m
  double modulus;    // Pa
};

// Bending stiffness per width of layers bonded to one another, bottom first, about their neutral plane, N m.
double StiffnessOf(const std::vector<Layer>& layers) {
  double stretch = 0;
  double moment = 0;
  double low = 0;
  for (const Layer& layer : layers) {
    stretch += layer.modulus * layer.thickness;
    moment += layer.modulus * layer.thickness * (low + 0.5 * layer.thickness);
    low += layer.thickness;
  }
  const double neutral = moment / stretch;
  double stiffness = 0;
  low = 0;
  for (const Layer& layer : layers) {
    const double off = low + 0.5 * layer.thickness - neutral;
    stiffness += layer.modulus * layer.thickness * (layer.thickness * layer.thickness / 12 + off * off);
    low += layer.thickness;
  }
  return stiffness;
}

}  // namespace

Result<TagWeight> WeighTags(const TentacleDesign& design, const TagLayout& tags,
                            const TagMaterial& material) {
  for (const auto& [name, value, unit] : {std::tuple{"label's grammage", material.label_grammage, "kg/m^2"},
                                          {"label's density", material.label_density, "kg/m^3"},
                                          {"label's modulus", material.label_modulus, "Pa"},
                                          {"film's density", material.film_density, "kg/m^3"}}) {
    if (std::isfinite(value) && value > 0) continue;
    return Error{ErrorKind::kBadInput,
                 fmt::format("the {} is {} {}; expected more than 0", name, value, unit)};
  }
  const auto layout = LayOut(design);
  if (!layout.ok()) return layout.error();

  TagWeight weight;
  const double mean_width = 0.5 * design.base_width * (1 + design.taper);
  weight.film_mass = material.film_density * design.thickness * mean_width * design.length;
  std::map<int, double> of_tentacle;
  for (const TagPlace& tag : tags.tags) {
    of_tentacle[tag.tentacle] += material.label_grammage * tag.footprint * tag.footprint;
  }
  for (const auto& [tentacle, mass] : of_tentacle) weight.tag_mass = std::max(weight.tag_mass, mass);

  const Layer film{design.thickness, design.youngs_modulus};
  const Layer label{material.label_grammage / material.label_density, material.label_modulus};
  weight.label_thickness = label.thickness;
  weight.film_stiffness = StiffnessOf({film});
  weight.label_stiffness = StiffnessOf({label});
  weight.one_side = StiffnessOf({film, label}) / weight.film_stiffness;
  weight.both_sides = StiffnessOf({label, film, label}) / weight.film_stiffness;
  const double width = layout.value().width[layout.value().width.size() / 2];
  weight.crease = weight.film_stiffness * width / design.crease_length;
  weight.facet = weight.film_stiffness * width / (0.5 * design.unit_length);
  return weight;
}

}  // namespace tendril
