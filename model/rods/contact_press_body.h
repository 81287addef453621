// Forces of elements that press on each other (press.h) and of elements on a solid, with friction
// (friction.h), a pair to a lane; the plain form is contact_plain.cpp. For the contact kernels; C alone, as
// registers_body.h says.
#include "model/rods/contact_near_body.h"

namespace tendril::contact_kernel {
namespace {

TENDRIL_INLINE Vector Times(Real s, const Vector& a) { return {s * a.x, s * a.y, s * a.z}; }
TENDRIL_INLINE Vector Plus(const Vector& a, const Vector& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
TENDRIL_INLINE Vector AllOf(const double* v) { return {All(v[0]), All(v[1]), All(v[2])}; }

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

// Adds to what stands side by side, for the lanes of `bits`: rows of one place each.
template <int kRows>
TENDRIL_INLINE void Scatter(double* to, const int* places, unsigned bits, const Real* rows) {
  double all[kRows][kDoubles];
  for (int row = 0; row < kRows; ++row) Put(all[row], rows[row]);
  for (; bits != 0; bits &= bits - 1) {
    const int k = __builtin_ctz(bits);
    double* const at = to + places[k];
    for (int row = 0; row < kRows; ++row) at[8 * row] += all[row][k];
  }
}

// friction.cpp, in lanes: `spring` holds the stretch and whether it slides, kSpring rows of eight.
TENDRIL_INLINE Vector FrictionOf(double* spring, Mask touches, const Sliding& law, Real stiffness,
                                 Real damping, const Vector& normal, Real normal_force,
                                 const Vector& velocity, const Vector& turning) {
  const Real none = Real{}, one = All(1);
  const Vector old = {Get(spring), Get(spring + 8), Get(spring + 16)};
  const Real slid = Get(spring + 24);
  const Vector turn = Times(All(law.time_step), turning);
  const Real keep = Larger(one - 0.5 * Dot(turn, turn), none);
  Vector stretch = Times(keep, Plus(old, Cross(turn, old)));
  const Vector slip = PlusTimes(velocity, -Dot(normal, velocity), normal);
  stretch = PlusTimes(stretch, All(law.time_step), slip);
  stretch = PlusTimes(stretch, -Dot(normal, stretch), normal);
  Vector force = PlusTimes(Times(-stiffness, stretch), -damping, slip);
  const Real limit = (slid > 0 ? All(law.kinetic) : All(law.at_rest)) * normal_force;
  const Mask over = Dot(force, force) > limit * limit;
  const Real slides = over ? one : (Dot(slip, stretch) <= 0 ? none : slid);
  // First the spring alone, then with what damps it.
  const Real most = law.kinetic * normal_force, held = stiffness * stiffness * Dot(stretch, stretch);
  const Mask far = over & (held > most * most);
  stretch = Times(far ? most * InverseSqrt(far ? held : one) : one, stretch);
  force = PlusTimes(Times(-stiffness, stretch), -damping, slip);
  const Real square = Dot(force, force);
  const Mask strong = over & (square > most * most);
  force = Times(strong ? most * InverseSqrt(strong ? square : one) : one, force);
  Put(spring, touches ? stretch.x : none);
  Put(spring + 8, touches ? stretch.y : none);
  Put(spring + 16, touches ? stretch.z : none);
  Put(spring + 24, touches ? slides : none);
  return {touches ? force.x : none, touches ? force.y : none, touches ? force.z : none};
}

// The square of how far springs are drawn.
TENDRIL_INLINE Real DrawnSquare(const double* spring) {
  const Real x = Get(spring), y = Get(spring + 8), z = Get(spring + 16);
  return x * x + y * y + z * z;
}

// An element's axis in lanes, and what presses on it.
struct Side {
  Segment it;
  Real length, inverse_length;
  Vector along;
  Vector start_force, end_force;
  Vector push;  // what is across the axes
  Real at;      // sum of where on the axis, weighed by what presses there
};
TENDRIL_INLINE Side SideOf(const double* nodes, const int* places) {
  Side s{};
  s.it.start = NodeOf(nodes, places);
  s.it.edge = Sub(NodeOf(nodes + 24, places), s.it.start);
  s.it.square = Dot(s.it.edge, s.it.edge);
  s.inverse_length = InverseSqrt(s.it.square);
  s.length = s.inverse_length * s.it.square;
  s.along = Times(s.inverse_length, s.it.edge);
  return s;
}

struct PressSums {
  Mask touches;
  Real steep, stiffness, least_square;
};

// Half of the energy: points of `one` against the whole of `other` (press.cpp).
template <bool kMoves, int kPoints>
TENDRIL_INLINE void PressHalf(int some, Real radii, Real weight, Side& one, Side& other, PressSums& sums) {
  const Real none = Real{};
  const int points = kPoints > 0 ? kPoints : some;
  for (int k = 0; k < points; ++k) {
    const Real at = All((k + 0.5) / points);
    const Vector between = Sub(PlusTimes(one.it.start, at, one.it.edge), other.it.start);
    const Real foot = Dot(between, other.along);
    const Vector across = PlusTimes(between, -foot, other.along);
    const Real square = Dot(across, across), c2 = radii * radii - square;
    const Real behind = other.length - foot;
    // Padding's radii are NaN.
    Mask on = c2 > 0;
    const Real root = InverseSqrt(on ? c2 : All(1)), c = on ? c2 * root : none, minus_c = -c;
    const Real from = Larger(Smaller(-foot, c), minus_c), to = Larger(Smaller(behind, c), minus_c);
    on &= to > from;
    if (!Any(on)) continue;
    sums.touches |= on;
    sums.least_square =
        on & (foot >= 0) & (behind >= 0) ? Smaller(sums.least_square, square) : sums.least_square;
    const Real piece = c2 * (to - from) - (to * to * to - from * from * from) * (1. / 3);
    const Real w = on ? weight : none, inverse_c = on ? root : none;
    const Real steep = w * (0.5 * piece * inverse_c + c * (to - from));
    const Real at_to = w * c * (c2 - to * to), at_from = w * c * (c2 - from * from);
    const Vector push = Times(2 * steep, across);
    const Vector force = PlusTimes(push, at_to - at_from, other.along);
    const Real share = foot * other.inverse_length;
    const Vector turn = Times((at_from - at_to) * other.inverse_length, across);
    one.start_force = PlusTimes(one.start_force, 1 - at, force);
    one.end_force = PlusTimes(one.end_force, at, force);
    other.start_force =
        Plus(other.start_force, PlusTimes(PlusTimes(turn, share - 1, push), at_from, other.along));
    other.end_force = Sub(other.end_force, PlusTimes(PlusTimes(turn, share, push), at_to, other.along));
    if (!kMoves) continue;
    one.push = Plus(one.push, push);
    sums.steep += steep;
    one.at += steep * at;
    other.at += steep * (foot + 0.5 * (from + to)) * other.inverse_length;
    sums.stiffness += w * 8 * (radii * radii) * piece * (inverse_c * inverse_c * inverse_c);
  }
}

// From a point to an axis.
TENDRIL_INLINE Real SquareTo(const Vector& point, const Segment& axis) {
  const Vector between = Sub(point, axis.start);
  const Vector apart = PlusTimes(between, -Clamped(Dot(between, axis.edge) * axis.inverse_square), axis.edge);
  return Dot(apart, apart);
}

void NarrowPairs(Narrow& job) {
  job.found = 0;
  for (int p = 0; p < job.pairs; p += kDoubles) {
    const Segment a = SegmentOf(job.at, job.one + p), b = SegmentOf(job.at, job.other + p);
    // Padding's radii are NaN.
    const Real reach = Get(job.constants + p / 8 * (8 * kPressConstants) + p % 8 + 8 * kRadii) + job.margin;
    Real least = All(__builtin_inf());
    for (int k = 0; k < job.points; ++k) {
      const Real at = All((k + 0.5) / job.points);
      least = Smaller(SquareTo(PlusTimes(a.start, at, a.edge), b), least);
      least = Smaller(SquareTo(PlusTimes(b.start, at, b.edge), a), least);
    }
    for (unsigned bits = Bits(least < reach * reach); bits != 0; bits &= bits - 1) {
      job.slots[job.found++] = p + __builtin_ctz(bits);
    }
  }
}

//   kPoints  as many to an element; 0: as the job says
template <bool kMoves, int kPoints>
void PressPairs(Press& job) {
  const Real none = Real{}, one = All(1);
  Real least_square = All(job.least_square), least_share = All(job.least_share_square);
  Real longest_stick = All(job.longest_stick_square);
  for (int p = 0; p < job.pairs; p += kDoubles) {
    const int *ones = job.one + p, *others = job.other + p;
    const double* const constants = job.constants + p / 8 * (8 * kPressConstants) + p % 8;
    const auto constant = [&](PressConstant which) { return Get(constants + 8 * which); };
    double* const spring = job.springs + p / 8 * (8 * kSpring) + p % 8;
    Side a = SideOf(job.at, ones), b = SideOf(job.at, others);
    const Real radii = constant(kRadii);
    PressSums sums{Mask{}, none, none, All(__builtin_inf())};
    PressHalf<kMoves, kPoints>(job.points, radii, constant(kOneWeight), a, b, sums);
    PressHalf<kMoves, kPoints>(job.points, radii, constant(kOtherWeight), b, a, sums);
    const Mask touches = sums.touches;
    if (!Any(touches)) {
      if (kMoves) {
        for (int row = 0; row < kSpring; ++row) Put(spring + 8 * row, none);
      }
      continue;
    }
    const Real seen = touches ? sums.least_square : All(__builtin_inf());
    least_square = Smaller(least_square, seen);
    least_share = touches ? Smaller(least_share, seen / (radii * radii)) : least_share;
    const unsigned bits = Bits(touches);
    if (kMoves) {
      // Damping and friction, at the point where both surfaces meet.
      const Vector push = Sub(a.push, b.push);
      const Real square = Dot(push, push);
      const Mask moves = touches & (square > 0);
      const Real inverse = moves ? InverseSqrt(moves ? square : one) : none, size = square * inverse;
      const Real inverse_sum = moves ? 1 / sums.steep : none;
      const Vector normal = Times(inverse, push);
      const Real s = a.at * inverse_sum, t = b.at * inverse_sum;
      const Vector apart = Sub(PlusTimes(a.it.start, s, a.it.edge), PlusTimes(b.it.start, t, b.it.edge));
      const Real one_part = constant(kOneArm);
      const Vector a_arm = Times(-one_part, apart), b_arm = Times(one - one_part, apart);
      const Vector a_spin = NodeOf(job.spin, ones), b_spin = NodeOf(job.spin, others);
      const Segment a_moves = SegmentOf(job.velocity, ones), b_moves = SegmentOf(job.velocity, others);
      const Vector of_a = Plus(PlusTimes(a_moves.start, s, a_moves.edge), Cross(a_spin, a_arm));
      const Vector of_b = Plus(PlusTimes(b_moves.start, t, b_moves.edge), Cross(b_spin, b_arm));
      const Vector velocity = Sub(of_a, of_b);
      const Real damping = job.damping * sums.stiffness * constant(kInverseReference);
      const Real damped = Larger(-damping * Dot(velocity, normal), -size);
      Vector force = Times(damped, normal);
      if (job.sliding.at_rest > 0) {
        force = Plus(force, FrictionOf(spring, moves, job.sliding, constant(kStickStiffness), damping, normal,
                                       size + damped, velocity, Times(All(0.5), Plus(a_spin, b_spin))));
        const Real drawn = DrawnSquare(spring) / (radii * radii);
        longest_stick = moves ? Larger(longest_stick, drawn) : longest_stick;
      }
      force = {moves ? force.x : none, moves ? force.y : none, moves ? force.z : none};
      a.start_force = PlusTimes(a.start_force, one - s, force);
      a.end_force = PlusTimes(a.end_force, s, force);
      b.start_force = PlusTimes(b.start_force, t - one, force);
      b.end_force = PlusTimes(b.end_force, -t, force);
      const Vector on_a = Cross(a_arm, force), on_b = Cross(force, b_arm);
      const Real a_couple[3] = {on_a.x, on_a.y, on_a.z}, b_couple[3] = {on_b.x, on_b.y, on_b.z};
      Scatter<3>(job.couple, ones, bits, a_couple);
      Scatter<3>(job.couple, others, bits, b_couple);
    }
    const Real a_forces[6] = {a.start_force.x, a.start_force.y, a.start_force.z,
                              a.end_force.x,   a.end_force.y,   a.end_force.z};
    const Real b_forces[6] = {b.start_force.x, b.start_force.y, b.start_force.z,
                              b.end_force.x,   b.end_force.y,   b.end_force.z};
    Scatter<6>(job.force, ones, bits, a_forces);
    Scatter<6>(job.force, others, bits, b_forces);
  }
  for (int k = 0; k < kDoubles; ++k) {
    if (least_square[k] < job.least_square) job.least_square = least_square[k];
    if (least_share[k] < job.least_share_square) job.least_share_square = least_share[k];
    if (longest_stick[k] > job.longest_stick_square) job.longest_stick_square = longest_stick[k];
  }
}

template <bool kMoves>
void PressWith(Press& job) {
  job.points == 1 ? PressPairs<kMoves, 1>(job) : PressPairs<kMoves, 0>(job);
}
void PressAll(Press& job) { job.velocity != nullptr ? PressWith<true>(job) : PressWith<false>(job); }

}  // namespace
}  // namespace tendril::contact_kernel
