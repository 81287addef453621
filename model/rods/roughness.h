#pragma once
// How rough two things are on each other: Coulomb's coefficients.

#include "model/rods/contact.h"
#include "model/rods/solid.h"

namespace tendril {

struct Roughness {
  double kinetic = 0, at_rest = 0;  // mu; at_rest >= kinetic
};

// Of rods on rods.
Roughness RoughnessOf(const Contact& contact);
// Of a rod on a solid: the solid's own, or where it has none the contact's.
Roughness RoughnessOf(const Contact& contact, const Solid& solid);
// Of two solids: that of the rougher.
Roughness RoughnessOf(const Contact& contact, const Solid& a, const Solid& b);

}  // namespace tendril
