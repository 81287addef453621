#include "model/rods/roughness.h"

#include <algorithm>

namespace tendril {

Roughness RoughnessOf(const Contact& contact) {
  return {contact.friction, std::max(contact.friction, contact.static_friction)};
}

Roughness RoughnessOf(const Contact& contact, const Solid& solid) {
  if (solid.friction < 0) return RoughnessOf(contact);
  return {solid.friction, std::max(solid.friction, solid.static_friction)};
}

Roughness RoughnessOf(const Contact& contact, const Solid& a, const Solid& b) {
  const Roughness of_a = RoughnessOf(contact, a), of_b = RoughnessOf(contact, b);
  return {std::max(of_a.kinetic, of_b.kinetic), std::max(of_a.at_rest, of_b.at_rest)};
}

}  // namespace tendril
