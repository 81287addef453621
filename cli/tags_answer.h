#pragma once
// What `design tags` says about a layout: facets, families, cameras, choices, weight; as lines and as JSON.

#include <optional>
#include <string>
#include <vector>

#include "capture/rig/tag_choice.h"
#include "capture/rig/tag_layout.h"
#include "capture/rig/tag_room.h"
#include "capture/rig/tag_views.h"
#include "capture/rig/tag_weight.h"
#include "cli/command.h"

namespace tendril::cli {

// Facets and sides that could have been chosen instead.
struct TagAlternative {
  int every = 1;
  TagSides sides = TagSides::kBoth;
  int tags = 0;
  double mass_share = 0;    // tags / film, of the tentacle that carries most
  double facets_seen = 0;   // share of facets that some camera decodes or follows; NaN: no cameras
  double facets_twice = 0;  // by two cameras or more
};

struct TagAnswer {
  TentacleDesign design;
  Gripper gripper;
  TagLayoutOptions options;  // with the family chosen
  TagLayout layout;
  std::vector<FacetRoom> rooms;  // of tentacle 0
  std::optional<FamilyChoice> choice;
  std::optional<TagSight> sight;
  TagMaterial material;
  TagWeight weight;
  std::vector<TagAlternative> alternatives;
};

void PrintTagAnswer(const TagAnswer& answer, Output& out);

// In words, the gravest first.
std::vector<std::string> TagWarnings(const TagAnswer& answer);

}  // namespace tendril::cli
