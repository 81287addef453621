#pragma once
// What tags add to a tentacle: mass, and stiffness of the film below them.
//
// SI units. Formulae and what is assumed: docs/lab-setup.md, "What tags weigh".

#include "capture/rig/tag_layout.h"
#include "model/fold/design.h"
#include "model/result.h"

namespace tendril {

// The film's thickness and modulus are the design's; a design file says nothing of what stands here.
struct TagMaterial {
  double label_grammage = 0.100;  // label with its adhesive: 80 g/m^2 paper and 20 g/m^2 adhesive, kg/m^2
  double label_density = 900;     // of both together, kg/m^3; thickness = grammage / density
  double label_modulus =
      3e9;  // office paper, along the sheet, Pa; the adhesive counts as paper: an upper bound
  double film_density = 1390;  // PET, kg/m^3
};

struct TagWeight {
  double film_mass = 0;        // of one tentacle, without its tendon, kg
  double tag_mass = 0;         // on the tentacle that carries most, kg
  double label_thickness = 0;  // m
  double film_stiffness = 0;   // E t^3 / 12, N m (per width)
  double label_stiffness = 0;  // the label alone, N m
  double one_side = 0;         // film with a label on one side / bare film
  double both_sides = 0;       // with labels on both / bare film
  // A crease's hinge at the middle of the tentacle, N m / rad, and a bare facet's between its creases.
  double crease = 0;
  double facet = 0;
};

// errors  the design's; kBadInput: a material value <= 0 or not finite
Result<TagWeight> WeighTags(const TentacleDesign& design, const TagLayout& tags,
                            const TagMaterial& material = {});

}  // namespace tendril
