// Forces between elements and a part of a solid, an element to a lane; the plain form is contact_plain.cpp.
// For the contact kernels; C alone, as registers_body.h says.
#include "model/rods/contact_press_body.h"

namespace tendril::contact_kernel {
namespace {

struct Surface {
  Real distance;
  Vector normal;
};

TENDRIL_INLINE Surface FromCentre(const Vector& v, Real radius) {
  const Real length = Sqrt(Dot(v, v)), none = Real{};
  const Mask off = length > 0;
  const Real inverse = off ? 1 / length : none;
  return {length - radius, {inverse * v.x, inverse * v.y, off ? inverse * v.z : All(1)}};
}

// Distances as in model/objects/shape.h; a point in the primitive's own frame.
template <int kKind>
TENDRIL_INLINE Surface SurfaceOf(const SolidPart& part, const Vector& v) {
  const Real none = Real{}, one = All(1);
  if (kKind == kHalfSpacePart) return {v.z, {none, none, one}};
  if (kKind == kCapsulePart) {
    const Real half = All(part.half[2]);
    return FromCentre({v.x, v.y, v.z - Larger(Smaller(v.z, half), -half)}, All(part.radius));
  }
  if (kKind == kCylinderPart) {
    const Real round = Sqrt(v.x * v.x + v.y * v.y);
    const Real inverse = round > 0 ? 1 / round : none;
    const Real rx = round > 0 ? inverse * v.x : one, ry = inverse * v.y;
    const Real out = round - part.radius, over = Size(v.z) - part.half[2];
    const Real up = v.z < 0 ? All(-1) : one;
    const Real o = Larger(out, none), h = Larger(over, none);
    const Real length = Sqrt(o * o + h * h);
    const Mask outside = length > 0;
    const Real scale = outside ? 1 / length : none;
    const Mask side = out > over;
    return {outside ? length : Larger(out, over),
            {outside ? scale * o * rx : (side ? rx : none), outside ? scale * o * ry : (side ? ry : none),
             outside ? scale * h * up : (side ? none : up)}};
  }
  // A box.
  const Real sx = v.x < 0 ? All(-1) : one, sy = v.y < 0 ? All(-1) : one, sz = v.z < 0 ? All(-1) : one;
  const Real dx = Size(v.x) - part.half[0], dy = Size(v.y) - part.half[1], dz = Size(v.z) - part.half[2];
  const Real x = Larger(dx, none), y = Larger(dy, none), z = Larger(dz, none);
  const Real length = Sqrt(x * x + y * y + z * z);
  const Mask outside = length > 0;
  const Real scale = outside ? 1 / length : none, nearest = Larger(dx, Larger(dy, dz));
  const Mask by_x = dx >= nearest, by_y = ~by_x & (dy >= nearest), by_z = ~(by_x | by_y);
  return {outside ? length : nearest,
          {outside ? scale * x * sx : (by_x ? sx : none), outside ? scale * y * sy : (by_y ? sy : none),
           outside ? scale * z * sz : (by_z ? sz : none)}};
}

// v into the part's frame, and back; its axes are rows of `axes`.
TENDRIL_INLINE Vector Into(const SolidPart& part, const Vector& v) {
  return {Dot(AllOf(part.axes[0]), v), Dot(AllOf(part.axes[1]), v), Dot(AllOf(part.axes[2]), v)};
}
TENDRIL_INLINE Vector OutOf(const SolidPart& part, const Vector& v) {
  const Vector x = Times(v.x, AllOf(part.axes[0]));
  return PlusTimes(PlusTimes(x, v.y, AllOf(part.axes[1])), v.z, AllOf(part.axes[2]));
}

template <int kKind, bool kMoves>
void PressOnPart(PressOnSolid& job) {
  const Real none = Real{}, one = All(1);
  const SolidPart& part = job.part;
  const Vector position = AllOf(part.position), origin = AllOf(job.origin);
  Vector on_solid = {none, none, none}, torque = {none, none, none};
  Real least_share = All(job.least_share), longest_stick = All(job.longest_stick_square);
  for (int p = 0; p < job.elements; p += kDoubles) {
    const int* const places = job.one + p;
    const double* const constants = job.constants + p / 8 * (8 * kSolidConstants) + p % 8;
    double* const spring = job.springs + p / 8 * (8 * kSpring) + p % 8;
    const Real radius = Get(constants + 8 * kSolidRadius), stiffness = Get(constants + 8 * kSolidStiffness);
    const Segment it = SegmentOf(job.at, places);
    Vector start = {none, none, none}, end = start, sum = start;
    Real total = none, at_sum = none, gap = none, pressing = none;
    Mask touches = Mask{};
    for (int k = 0; k < job.points; ++k) {
      const Real at = All((k + 0.5) / job.points);
      const Vector point = PlusTimes(it.start, at, it.edge);
      const Surface surface = SurfaceOf<kKind>(part, Into(part, Sub(point, position)));
      // Padding's radius is NaN.
      const Mask on = radius > surface.distance;
      if (!Any(on)) continue;
      touches |= on;
      const Real depth = on ? radius - surface.distance : none;
      least_share = on ? Smaller(least_share, one - 0.5 * depth / radius) : least_share;
      const Real size = on ? stiffness * depth : none;
      const Vector push = Times(size, OutOf(part, surface.normal));
      start = PlusTimes(start, 1 - at, push);
      end = PlusTimes(end, at, push);
      on_solid = Sub(on_solid, push);
      torque = Sub(torque, Cross(Sub(point, origin), push));
      if (!kMoves) continue;
      sum = Plus(sum, push);
      total += size;
      at_sum += size * at;
      gap += on ? size * surface.distance : none;
      pressing += on ? stiffness : none;
    }
    if (!Any(touches)) {
      if (kMoves) {
        for (int row = 0; row < kSpring; ++row) Put(spring + 8 * row, none);
      }
      continue;
    }
    const unsigned bits = Bits(touches);
    if (kMoves) {
      const Real size = Sqrt(Dot(sum, sum));
      const Mask moves = touches & (size > 0);
      const Real inverse = moves ? 1 / size : none, inverse_total = moves ? 1 / total : none;
      const Vector normal = Times(inverse, sum);
      const Real s = at_sum * inverse_total;
      const Real reach = moves ? -0.5 * (radius + gap * inverse_total) : none;
      const Vector arm = Times(reach, normal);
      const Vector from_origin = Sub(Plus(PlusTimes(it.start, s, it.edge), arm), origin);
      const Vector spin = NodeOf(job.spin, places), turning = AllOf(job.turning);
      const Segment moving = SegmentOf(job.velocity, places);
      const Vector of_rod = Plus(PlusTimes(moving.start, s, moving.edge), Cross(spin, arm));
      const Vector velocity = Sub(of_rod, Plus(AllOf(job.moving), Cross(turning, from_origin)));
      const Real damping =
          moves ? job.damping * pressing * Get(constants + 8 * kSolidInverseReference) : none;
      const Real damped = Larger(-damping * Dot(velocity, normal), -size);
      Vector force = Times(damped, normal);
      if (job.sliding.at_rest > 0) {
        force =
            Plus(force, FrictionOf(spring, moves, job.sliding, Get(constants + 8 * kSolidStick), damping,
                                   normal, size + damped, velocity, Times(All(0.5), Plus(spin, turning))));
        const Real drawn = DrawnSquare(spring) / (4 * radius * radius);
        longest_stick = moves ? Larger(longest_stick, drawn) : longest_stick;
      }
      force = {moves ? force.x : none, moves ? force.y : none, moves ? force.z : none};
      start = PlusTimes(start, one - s, force);
      end = PlusTimes(end, s, force);
      on_solid = Sub(on_solid, force);
      torque = Sub(torque, Cross(from_origin, force));
      const Vector couple = Cross(arm, force);
      const Real rows[3] = {couple.x, couple.y, couple.z};
      Scatter<3>(job.couple, places, bits, rows);
    }
    const Real rows[6] = {start.x, start.y, start.z, end.x, end.y, end.z};
    Scatter<6>(job.force, places, bits, rows);
  }
  for (int k = 0; k < kDoubles; ++k) {
    if (least_share[k] < job.least_share) job.least_share = least_share[k];
    if (longest_stick[k] > job.longest_stick_square) job.longest_stick_square = longest_stick[k];
    job.on_solid[0] += on_solid.x[k], job.on_solid[1] += on_solid.y[k], job.on_solid[2] += on_solid.z[k];
    job.on_solid[3] += torque.x[k], job.on_solid[4] += torque.y[k], job.on_solid[5] += torque.z[k];
  }
}

template <int kKind>
void PressOnKind(PressOnSolid& job) {
  job.velocity != nullptr ? PressOnPart<kKind, true>(job) : PressOnPart<kKind, false>(job);
}

void PressOnAny(PressOnSolid& job) {
  if (job.part.kind == kCapsulePart) return PressOnKind<kCapsulePart>(job);
  if (job.part.kind == kCylinderPart) return PressOnKind<kCylinderPart>(job);
  if (job.part.kind == kBoxPart) return PressOnKind<kBoxPart>(job);
  PressOnKind<kHalfSpacePart>(job);
}

}  // namespace
}  // namespace tendril::contact_kernel
