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
    const Real square = Dot(edge, edge), length = Sqrt(square);
    const Real drift = Sqrt(Larger(Get(row.allowed + i), Get(row.allowed + i + 1)));
    const Real turn = Sqrt(Get(row.edge_allowed + i));
    // An element gets thicker as it gets shorter; one that could shrink to nothing reaches everywhere.
    const Real shortest = length - turn;
    const Real at_rest = Get(row.rest_radius + i);
    const Real radius = row.law == kSegments ? at_rest : at_rest * Sqrt(Get(row.rest_length + i) / shortest);
    const Real fat = shortest > 0.5 * length ? radius + drift : at_rest + All(__builtin_inf());
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
    Put(row.fat + i, fat);
    Put(row.bound + i, bound);
  }
  row.strayed = strayed[0];
  for (int k = 1; k < kDoubles; ++k) row.strayed = strayed[k] > row.strayed ? strayed[k] : row.strayed;
}

// An element, for all lanes or one in each.

template <bool kAll>
TENDRIL_INLINE Real In(const double* from, int i) {
  return kAll ? All(from[i]) : Get(from + i);
}
template <bool kAll>
TENDRIL_INLINE Segment SegmentAt(const Row& row, int i) {
  const auto node = [&](int n) { return Vector{In<kAll>(row.x, n), In<kAll>(row.y, n), In<kAll>(row.z, n)}; };
  Segment s;
  s.start = node(i);
  s.edge = Sub(node(i + 1), s.start);
  s.square = Dot(s.edge, s.edge);
  s.inverse_square = In<kAll>(row.inverse_square, i);
  return s;
}

template <int kLaw, bool kBodies>
void ChoosePairs(Row& row) {
  Real least_gap = All(row.least_gap);
  for (int n = row.from; n < row.to; ++n) {
    const int i = row.element[n];
    const Segment a = SegmentAt<true>(row, i);
    const Vector center = AllAt(row.center_x, row.center_y, row.center_z, i);
    const Real bound = All(row.bound[i]), fat = All(row.fat[i]), drift = All(row.drift[i]);
    for (int run = row.first[n]; run < row.first[n + 1]; ++run) {
      for (int j = row.runs[run]; j < row.runs[run] + 8; j += kDoubles) {
        const Vector apart = Sub(At(row.center_x, row.center_y, row.center_z, j), center);
        const Real far = bound + Get(row.bound + j);
        Mask near = Dot(apart, apart) < far * far;
        if (!Any(near)) continue;
        const Segment b = SegmentAt<false>(row, j);
        const Closest closest = ClosestOf<kLaw, kBodies>(a, b);
        const Real reach = fat + Get(row.fat + j);
        const Real square = Dot(closest.apart, closest.apart);
        near &= square < reach * reach;
        const Real gap = Sqrt(square) - drift - Get(row.drift + j);
        least_gap = near ? Smaller(gap, least_gap) : least_gap;
        unsigned bits = Bits(near);
        for (; bits != 0; bits &= bits - 1) {
          row.one[row.pairs] = i;
          row.other[row.pairs++] = j + __builtin_ctz(bits);
        }
      }
    }
  }
  for (int k = 0; k < kDoubles; ++k) {
    if (least_gap[k] < row.least_gap) row.least_gap = least_gap[k];
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
