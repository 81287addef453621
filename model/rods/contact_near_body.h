// Which elements may press on each other: how far nodes have gone, how far elements reach, and the pairs of
// neighbours that can carry a force until nodes have gone as far as they may. For the contact kernels; C
// alone, as registers_body.h says.
#include "model/rods/contact_closest_body.h"

namespace tendril::contact_kernel {
namespace {

void MoveRods(Move& m) {
  constexpr int kParts = 8 / kDoubles;
  Real farthest[kParts] = {}, sum[kParts] = {};
  Mask left[kParts] = {};
  Vector last_way[kParts];
  for (int node = 0; node < m.nodes; ++node) {
    for (int part = 0; part < kParts; ++part) {
      const int one = 8 * node + part * kDoubles, i = 24 * node + part * kDoubles;
      const Vector now = At(m.from, m.from + 8, m.from + 16, i);
      const Vector step = Sub(now, At(m.at, m.at + 8, m.at + 16, i));
      const Vector way = Sub(now, At(m.reference, m.reference + 8, m.reference + 16, i));
      const Real far = Dot(step, step);
      farthest[part] = Larger(far, farthest[part]);
      sum[part] += far;
      left[part] |= Dot(way, way) > Get(m.allowed + one);
      if (node > 0) {
        const Vector change = Sub(way, last_way[part]);
        left[part] |= Dot(change, change) > Get(m.edge_allowed + one - 8);
      }
      last_way[part] = way;
      Put(m.at + i, now.x);
      Put(m.at + i + 8, now.y);
      Put(m.at + i + 16, now.z);
    }
  }
  const int end = 24 * m.nodes;
  for (int i = 0; i < 24; i += kDoubles) {
    Put(m.at + i - 24, Get(m.at + i));
    Put(m.at + end + i, Get(m.at + end - 24 + i));
  }
  for (int rod = 0; rod < m.rods; ++rod) {
    const int part = rod / kDoubles, k = rod % kDoubles;
    if (farthest[part][k] > m.farthest) m.farthest = farthest[part][k];
    m.sum += sum[part][k];
    m.left |= left[part][k] != 0;
  }
}

void Measure(Row& row) {
  Real strayed = All(-__builtin_inf());
  for (int i = 0; i < row.size; i += kDoubles) {
    const Vector start = At(row.x, row.y, row.z, i), end = At(row.x, row.y, row.z, i + 1);
    const Vector edge = Sub(end, start);
    // Rods begin at place 8 at the earliest.
    const Vector before = i == 0 ? edge : Sub(start, At(row.x, row.y, row.z, i - 1));
    const Vector behind = Sub(At(row.x, row.y, row.z, i + 2), end);
    const Real square = Dot(edge, edge), length = Sqrt(square);
    const Real span = Sqrt(Larger(square, Larger(Dot(before, before), Dot(behind, behind))));
    const Real drift = Sqrt(Larger(Get(row.allowed + i), Get(row.allowed + i + 1)));
    const Real own = Get(row.edge_allowed + i), next = Get(row.edge_allowed + i + 1);
    const Real turn = Sqrt(Larger(own, Larger(i == 0 ? own : Get(row.edge_allowed + i - 1), next)));
    // An element gets thicker as it gets shorter; one that could shrink to nothing reaches everywhere.
    const Real shortest = length - turn;
    const Real radius = Get(row.rest_radius + i) * Sqrt(Get(row.rest_length + i) / shortest);
    const Real fat =
        shortest > 0.5 * length ? radius + drift : Get(row.rest_radius + i) + All(__builtin_inf());
    const Real bound = fat + 0.5 * (length + turn);
    const Vector center = {0.5 * (start.x + end.x), 0.5 * (start.y + end.y), 0.5 * (start.z + end.z)};
    const Vector way = Sub(center, At(row.old_x, row.old_y, row.old_z, i));
    // Padding is not a number.
    strayed = Larger(Sqrt(Dot(way, way)) + bound - Get(row.old_reach + i), strayed);
    Put(row.center_x + i, center.x);
    Put(row.center_y + i, center.y);
    Put(row.center_z + i, center.z);
    Put(row.inverse_square + i, 1 / square);
    Put(row.drift + i, drift);
    Put(row.turn + i, turn);
    Put(row.span + i, span);
    Put(row.fat + i, fat);
    Put(row.bound + i, bound);
  }
  row.strayed = strayed[0];
  for (int k = 1; k < kDoubles; ++k) row.strayed = strayed[k] > row.strayed ? strayed[k] : row.strayed;
}

// An element and those beside it, for all lanes or one in each.
struct Place {
  Segment it;
  Vector before, behind;  // edges
  Real drift, turn, span;
};

template <bool kAll>
TENDRIL_INLINE Real In(const double* from, int i) {
  return kAll ? All(from[i]) : Get(from + i);
}
template <bool kAll>
TENDRIL_INLINE Place PlaceAt(const Row& row, int i) {
  const auto node = [&](int n) { return Vector{In<kAll>(row.x, n), In<kAll>(row.y, n), In<kAll>(row.z, n)}; };
  Place p;
  const Vector end = node(i + 1);
  p.it.start = node(i);
  p.it.edge = Sub(end, p.it.start);
  p.it.square = Dot(p.it.edge, p.it.edge);
  p.it.inverse_square = In<kAll>(row.inverse_square, i);
  p.before = Sub(p.it.start, node(i - 1));
  p.behind = Sub(node(i + 2), end);
  p.drift = In<kAll>(row.drift, i);
  p.turn = In<kAll>(row.turn, i);
  p.span = In<kAll>(row.span, i);
  return p;
}

// Where every closest point on b, of any two elements this near, stays beyond a's end and beyond the start of
// the element behind it, or the same before a's start: the contact is never a's. `apart`: from a's centre to
// b's, `far` or less in length.
//
// With d between the closest points, a has a part only where d.edge <= 0 or d.behind <= 0, and d.edge >= 0 or
// d.before >= 0 (to contact.cpp's tolerance). Below are least values of these over all points of both
// elements, and how much they change at most while nodes drift and edges turn.
TENDRIL_INLINE Mask NeverHasPart(const Place& a, const Place& b, const Vector& apart, Real far) {
  const Real change = (a.drift + b.drift) * (a.span + a.turn) + a.turn * (far + 0.5 * (a.span + b.span)) +
                      0.5 * b.turn * (a.span + a.turn) + 1e-8 * a.span * (far + a.span);
  const Vector& u = a.it.edge;
  const Vector& v = b.it.edge;
  const Vector from_end = PlusTimes(apart, All(-0.5), u), from_start = PlusTimes(apart, All(0.5), u);
  const Real sideways = 0.5 * Size(Dot(u, v));
  const Mask behind = (Dot(from_end, u) - sideways > change) &
                      (Dot(from_end, a.behind) - 0.5 * Size(Dot(a.behind, v)) > change);
  const Mask before = (Dot(from_start, u) + sideways < -change) &
                      (Dot(from_start, a.before) + 0.5 * Size(Dot(a.before, v)) < -change);
  return behind | before;
}

template <int kLaw, bool kBodies>
void ChoosePairs(Row& row) {
  for (int n = row.from; n < row.to; ++n) {
    const int i = row.element[n];
    const Place a = PlaceAt<true>(row, i);
    const Vector center = AllAt(row.center_x, row.center_y, row.center_z, i);
    const Real bound = All(row.bound[i]), fat = All(row.fat[i]);
    for (int run = row.first[n]; run < row.first[n + 1]; ++run) {
      for (int j = row.runs[run]; j < row.runs[run] + 8; j += kDoubles) {
        const Vector apart = Sub(At(row.center_x, row.center_y, row.center_z, j), center);
        const Real far = bound + Get(row.bound + j);
        Mask near = Dot(apart, apart) < far * far;
        if (!Any(near)) continue;
        const Place b = PlaceAt<false>(row, j);
        if (kLaw == kSegments) {
          const Vector back = {-apart.x, -apart.y, -apart.z};
          near &= ~(NeverHasPart(a, b, apart, far) | NeverHasPart(b, a, back, far));
          if (!Any(near)) continue;
        }
        const Closest closest = ClosestOf<kLaw, kBodies>(a.it, b.it);
        const Real reach = fat + Get(row.fat + j);
        unsigned bits = Bits(near & (Dot(closest.apart, closest.apart) < reach * reach));
        for (; bits != 0; bits &= bits - 1) {
          row.one[row.pairs] = i;
          row.other[row.pairs++] = j + __builtin_ctz(bits);
        }
      }
    }
  }
}

void Choose(Row& row, bool bodies) {
  if (row.law == kSegments)
    return bodies ? ChoosePairs<kSegments, true>(row) : ChoosePairs<kSegments, false>(row);
  if (row.law == kEqual) return bodies ? ChoosePairs<kEqual, true>(row) : ChoosePairs<kEqual, false>(row);
  bodies ? ChoosePairs<kCenters, true>(row) : ChoosePairs<kCenters, false>(row);
}

}  // namespace
}  // namespace tendril::contact_kernel
