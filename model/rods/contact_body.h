// The body of the contact kernels, compiled once per instruction set by the contact_*.cpp that define
// TENDRIL_CONTACT_KERNELS and include this; C alone, as registers_body.h says.
//
// Forces of the published laws for chosen pairs, a pair to a lane; the equations are contact.cpp's.
#include "model/rods/contact_kernel.h"
#include "model/rods/contact_solid_body.h"

namespace tendril::contact_kernel {
namespace {

template <int kLaw, bool kBody>
void TouchPairs(Touch& touch) {
  const Real none = Real{};
  Real least = All(touch.least_distance), least_share = All(touch.least_share);
  for (int p = 0; p < touch.pairs; p += kDoubles) {
    const int *ones = touch.one + p, *others = touch.other + p;
    const double* const constants = touch.constants + p / 8 * (8 * kConstants) + p % 8;
    const auto constant = [&](Constant which) { return Get(constants + 8 * which); };
    const Segment a = SegmentOf(touch.at, ones), b = SegmentOf(touch.at, others);
    const Closest closest = ClosestOf<kLaw, kBody>(a, b);
    const Vector& apart = closest.apart;
    const Real a_radius =
        kBody ? constant(kOneRadius) : constant(kOneRadius) * Sqrt(constant(kOneLength) / Sqrt(a.square));
    const Real reach = a_radius + constant(kOtherRadius) * Sqrt(constant(kOtherLength) / Sqrt(b.square));
    const Real square = Dot(apart, apart);
    // Padding's reach is NaN.
    const Mask touches = (square < reach * reach) & (square > 0);
    if (!Any(touches)) continue;
    const Real distance = Sqrt(square), inverse_distance = 1 / distance;
    least = touches ? Smaller(least, distance) : least;
    least_share = touches ? Smaller(least_share, distance / reach) : least_share;
    const Real depth = touches ? reach - distance : none;
    Real size = touch.stiffness * depth * Sqrt(depth);
    if (touch.velocity != nullptr) {
      const Segment a_moves = SegmentOf(touch.velocity, ones), b_moves = SegmentOf(touch.velocity, others);
      const Vector approach = Sub(PlusTimes(a_moves.start, All(0.5), a_moves.edge),
                                  PlusTimes(b_moves.start, All(0.5), b_moves.edge));
      size += touch.damping * Dot(approach, apart) * inverse_distance;
    }
    const Real scale = size * inverse_distance;
    const Real s = constant(kOneRule), t = constant(kOtherRule);
    // On the nodes of both elements: [start and end][component].
    const Vector force = {scale * apart.x, scale * apart.y, scale * apart.z};
    const Real on_one[6] = {(s - 1) * force.x, (s - 1) * force.y, (s - 1) * force.z,
                            -s * force.x,      -s * force.y,      -s * force.z};
    const Real on_other[6] = {(1 - t) * force.x, (1 - t) * force.y, (1 - t) * force.z,
                              t * force.x,       t * force.y,       t * force.z};
    Scatter<6>(touch.force, ones, Bits(touches), on_one);
    Scatter<6>(touch.force, others, Bits(touches), on_other);
  }
  for (int k = 0; k < kDoubles; ++k) {
    if (least[k] < touch.least_distance) touch.least_distance = least[k];
    if (least_share[k] < touch.least_share) touch.least_share = least_share[k];
  }
}

template <int kLaw>
void TouchAll(Touch& touch) {
  touch.bodies ? TouchPairs<kLaw, true>(touch) : TouchPairs<kLaw, false>(touch);
}

void TouchByLaw(Touch& touch) {
  if (touch.law == kEqual) return TouchAll<kEqual>(touch);
  TouchAll<kCenters>(touch);
}

void Clear(double* to, int eights) {
  for (int i = 0; i < 8 * eights; i += kDoubles) Put(to + i, Real{});
}

}  // namespace

Kernels TENDRIL_CONTACT_KERNELS() {
  return {&MoveRods, &Measure, &Choose, &TouchByLaw, &NarrowPairs, &PressAll, &PressOnAny, &Clear};
}

}  // namespace tendril::contact_kernel
