// The body of the contact kernels, compiled once per instruction set by the contact_*.cpp that define
// TENDRIL_CONTACT_KERNELS and include this; C alone, as registers_body.h says.
//
// Forces of chosen pairs, a pair to a lane; the equations are contact.cpp's.
#include "model/rods/contact_kernel.h"
#include "model/rods/contact_near_body.h"

namespace tendril::contact_kernel {
namespace {

// Elements of pairs, one in each lane, side by side: the next component is 8 behind, the next node 24.
TENDRIL_INLINE Vector NodeOf(const double* nodes, const int* places) {
  return {Gather(nodes, places), Gather(nodes + 8, places), Gather(nodes + 16, places)};
}
TENDRIL_INLINE Segment SegmentOf(const double* nodes, const int* places) {
  Segment s;
  s.start = NodeOf(nodes, places);
  s.edge = Sub(NodeOf(nodes + 24, places), s.start);
  s.square = Dot(s.edge, s.edge);
  s.inverse_square = s.square > 0 ? 1 / s.square : Real{};
  return s;
}

// The part of a contact at share s of an element that is this element's: where a neighbour goes on toward the
// other, the contact is the neighbour's. `apart`: toward the other.
TENDRIL_INLINE Real PartOf(const double* nodes, const int* places, const Segment& it, Real s,
                           const Vector& apart, Real start_part, Real end_part) {
  const Vector before = Sub(it.start, NodeOf(nodes - 24, places));
  const Vector end = {it.start.x + it.edge.x, it.start.y + it.edge.y, it.start.z + it.edge.z};
  const Vector behind = Sub(NodeOf(nodes + 48, places), end);
  const Real tolerance = 1e-9 * it.square, none = Real{};
  const Real at_end = Dot(apart, behind) > tolerance ? none : end_part;
  const Real at_start = -Dot(apart, before) > tolerance ? none : start_part;
  return s > 1 - 1e-9 ? at_end : (s < 1e-9 ? at_start : All(1));
}

template <int kLaw, bool kBody>
TENDRIL_INLINE void TouchPairs(Touch& touch, int first, int last) {
  const Real none = Real{}, one = All(1);
  Real least = All(touch.least_distance), least_share = All(touch.least_share);
  for (int p = first; p < last; p += kDoubles) {
    const int *ones = touch.one + p, *others = touch.other + p;
    const double* const constants = touch.constants + p / 8 * (8 * kConstants) + p % 8;
    const auto constant = [&](Constant which) { return Get(constants + 8 * which); };
    const Segment a = SegmentOf(touch.at, ones), b = SegmentOf(touch.at, others);
    const Closest closest = ClosestOf<kLaw, kBody>(a, b);
    const Vector& apart = closest.apart;
    Real s = closest.s, t = closest.t;
    const Real a_radius =
        kBody ? constant(kOneRadius) : constant(kOneRadius) * Sqrt(constant(kOneLength) / Sqrt(a.square));
    const Real reach = a_radius + constant(kOtherRadius) * Sqrt(constant(kOtherLength) / Sqrt(b.square));
    const Real square = Dot(apart, apart);
    // Padding's reach is NaN.
    Mask touches = (square < reach * reach) & (square > 0);
    if (!Any(touches)) continue;
    Real weight = one;
    if (kLaw == kSegments) {
      const Vector back = {-apart.x, -apart.y, -apart.z};
      weight = PartOf(touch.at, ones, a, s, apart, constant(kOneStart), constant(kOneEnd)) *
               PartOf(touch.at, others, b, t, back, constant(kOtherStart), constant(kOtherEnd));
      if (Any(closest.parallel)) {
        const Real slant = Dot(apart, a.edge);
        const Mask beside =
            closest.parallel & (slant * slant <= 1e-14 * (a.square * square)) & (a.square * b.square > 0);
        const Real side_by_side = Size(closest.to - closest.from);
        weight = beside ? side_by_side * Larger(Sqrt(a.square * b.inverse_square), one) : weight;
      }
      touches &= weight > 0;
      if (!Any(touches)) continue;
    }
    const Real distance = Sqrt(square), inverse_distance = 1 / distance;
    least = touches ? Smaller(least, distance) : least;
    least_share = touches ? Smaller(least_share, distance / reach) : least_share;
    const Real depth = touches ? reach - distance : none;
    Real size = touch.stiffness * depth * Sqrt(depth);
    if (touch.velocity != nullptr) {
      const Real sa = kLaw == kSegments ? s : All(0.5), tb = kLaw == kSegments ? t : All(0.5);
      const Segment a_moves = SegmentOf(touch.velocity, ones), b_moves = SegmentOf(touch.velocity, others);
      const Vector approach =
          Sub(PlusTimes(a_moves.start, sa, a_moves.edge), PlusTimes(b_moves.start, tb, b_moves.edge));
      size += touch.damping * Dot(approach, apart) * inverse_distance;
      if (kLaw == kSegments) size = Larger(size, none);
    }
    const Real scale = weight * size * inverse_distance;
    if (kLaw != kSegments) {
      s = constant(kOneRule);
      t = constant(kOtherRule);
    }
    // On the nodes of both elements: [start and end][component].
    const Vector force = {scale * apart.x, scale * apart.y, scale * apart.z};
    double on_one[6][kDoubles], on_other[6][kDoubles];
    const Real parts[4] = {s - 1, -s, 1 - t, t};
    for (int end = 0; end < 2; ++end) {
      Put(on_one[3 * end], parts[end] * force.x);
      Put(on_one[3 * end + 1], parts[end] * force.y);
      Put(on_one[3 * end + 2], parts[end] * force.z);
      Put(on_other[3 * end], parts[2 + end] * force.x);
      Put(on_other[3 * end + 1], parts[2 + end] * force.y);
      Put(on_other[3 * end + 2], parts[2 + end] * force.z);
    }
    for (unsigned bits = Bits(touches); bits != 0; bits &= bits - 1) {
      const int k = __builtin_ctz(bits);
      double *const to_one = touch.force + ones[k], *const to_other = touch.force + others[k];
      for (int row = 0; row < 6; ++row) to_one[8 * row] += on_one[row][k];
      for (int row = 0; row < 6; ++row) to_other[8 * row] += on_other[row][k];
    }
  }
  for (int k = 0; k < kDoubles; ++k) {
    if (least[k] < touch.least_distance) touch.least_distance = least[k];
    if (least_share[k] < touch.least_share) touch.least_share = least_share[k];
  }
}

template <int kLaw>
void TouchAll(Touch& touch) {
  TouchPairs<kLaw, false>(touch, 0, touch.rod_pairs);
  TouchPairs<kLaw, true>(touch, touch.rod_pairs, touch.pairs);
}

void TouchByLaw(Touch& touch) {
  if (touch.law == kSegments) return TouchAll<kSegments>(touch);
  if (touch.law == kEqual) return TouchAll<kEqual>(touch);
  TouchAll<kCenters>(touch);
}

void Clear(double* to, int eights) {
  for (int i = 0; i < 8 * eights; i += kDoubles) Put(to + i, Real{});
}

void AddTo(double* to, const double* more, int eights) {
  for (int i = 0; i < 8 * eights; i += kDoubles) Put(to + i, Get(to + i) + Get(more + i));
}

}  // namespace

Kernels TENDRIL_CONTACT_KERNELS() { return {&MoveRods, &Measure, &Choose, &TouchByLaw, &Clear, &AddTo}; }

}  // namespace tendril::contact_kernel
