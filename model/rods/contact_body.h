// The body of the contact kernels, compiled once per instruction set by the contact_*.cpp that define
// TENDRIL_CONTACT_KERNELS and include this; C alone, as registers_body.h says.
//
// One element against eight that follow each other; the equations are contact.cpp's.
#include "model/rods/contact_kernel.h"
#include "model/rods/registers_body.h"

namespace tendril::contact_kernel {
namespace {

typedef Doubles Real;
typedef Types<double>::Mask Mask;

TENDRIL_INLINE Real All(double v) { return v - Real{}; }
TENDRIL_INLINE Real Get(const double* from) {
  Real r;
  __builtin_memcpy(&r, from, sizeof r);
  return r;
}
TENDRIL_INLINE void Put(double* to, Real v) { __builtin_memcpy(to, &v, sizeof v); }
TENDRIL_INLINE void Add(double* to, Real v) { Put(to, Get(to) + v); }
TENDRIL_INLINE Real Clamped(Real v) {
  v = v > 0 ? v : Real{};
  return v < 1 ? v : All(1);
}
TENDRIL_INLINE Real Smaller(Real a, Real b) { return a < b ? a : b; }
TENDRIL_INLINE double Sum(Real v) {
  double sum = 0;
  for (int k = 0; k < kDoubles; ++k) sum += v[k];
  return sum;
}
TENDRIL_INLINE bool Any(Mask mask) {
#if TENDRIL_ROD_WIDTH == 8
  return _mm512_test_epi64_mask(reinterpret_cast<__m512i>(mask), reinterpret_cast<__m512i>(mask)) != 0;
#elif TENDRIL_ROD_WIDTH == 4
  return _mm256_movemask_pd(reinterpret_cast<__m256d>(mask)) != 0;
#else
  int64_t any = 0;
  for (int k = 0; k < kDoubles; ++k) any |= mask[k];
  return any != 0;
#endif
}

struct Vector {
  Real x, y, z;
};
TENDRIL_INLINE Vector Sub(const Vector& a, const Vector& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
TENDRIL_INLINE Vector PlusTimes(const Vector& a, Real s, const Vector& b) {
  return {a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}
TENDRIL_INLINE Real Dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
TENDRIL_INLINE Vector Cross(const Vector& a, const Vector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
TENDRIL_INLINE Vector At(const double* x, const double* y, const double* z, int i) {
  return {Get(x + i), Get(y + i), Get(z + i)};
}
TENDRIL_INLINE Vector AllAt(const double* x, const double* y, const double* z, int i) {
  return {All(x[i]), All(y[i]), All(z[i])};
}

void Prepare(Job& job) {
  Real moved = Real{}, sum = Real{};
  for (int i = 0; i < job.size; i += kDoubles) {
    const Vector start = At(job.x, job.y, job.z, i), end = At(job.x, job.y, job.z, i + 1);
    const Vector way = Sub(start, At(job.old_x, job.old_y, job.old_z, i));
    const Real far = Dot(way, way);
    moved = far > moved ? far : moved;
    sum += far;
    Put(job.old_x + i, start.x);
    Put(job.old_y + i, start.y);
    Put(job.old_z + i, start.z);
    const Vector edge = Sub(end, start);
    const Real length = Sqrt(Dot(edge, edge));
    const Real radius = Get(job.rest_radius + i) * Sqrt(Get(job.rest_length + i) / length);
    Put(job.radius + i, radius);
    Put(job.bound + i, radius + 0.5 * length);
    Put(job.inverse_square + i, 1 / (length * length));
    Put(job.center_x + i, 0.5 * (start.x + end.x));
    Put(job.center_y + i, 0.5 * (start.y + end.y));
    Put(job.center_z + i, 0.5 * (start.z + end.z));
  }
  double most = 0;
  for (int k = 0; k < kDoubles; ++k) most = moved[k] > most ? moved[k] : most;
  // What is not a number is larger than nothing; the sum keeps it.
  const double all = Sum(sum);
  job.moved = all * 0 == 0 ? __builtin_sqrt(most) : all;
}

// An element against the others, for all lanes.
struct One {
  Vector start, edge, before, behind;
  Vector start_velocity{}, end_velocity{};
  Real square, inverse_square, radius, start_share, end_share, rule;
};

template <int kLaw, bool kBody>
TENDRIL_INLINE void TouchRuns(Job& job, int n, const One& a) {
  const Vector center = AllAt(job.center_x, job.center_y, job.center_z, job.element[n]);
  const Real bound = All(job.bound[job.element[n]]);
  Vector on_start{Real{}, Real{}, Real{}}, on_end = on_start;
  Real least = All(job.least_distance), least_share = All(job.least_share);
  bool touched = false;
  for (int run = job.first[n]; run < job.first[n + 1]; ++run) {
    for (int j = job.runs[run]; j < job.runs[run] + 8; j += kDoubles) {
      const Vector centers = Sub(At(job.center_x, job.center_y, job.center_z, j), center);
      const Real together = bound + Get(job.bound + j);
      if (!Any(Dot(centers, centers) < together * together)) continue;
      const Vector b_node = At(job.x, job.y, job.z, j), b_end = At(job.x, job.y, job.z, j + 1);
      const Vector b_edge = Sub(b_end, b_node);
      const Real reach = a.radius + Get(job.radius + j);
      Real s = All(0.5), t = All(0.5), from = s, to = t;
      Mask parallel{};
      Vector apart = centers;
      if (kLaw != kCenters || kBody) {
        Vector v = b_edge, between = Sub(b_node, a.start);
        if (kLaw == kCenters) {
          v = {Real{}, Real{}, Real{}};
          between = PlusTimes(between, All(0.5), b_edge);
        }
        const Vector& u = a.edge;
        const Real uv = Dot(u, v), vv = Dot(v, v);
        const Real inverse_vv = kLaw == kCenters ? Real{} : Get(job.inverse_square + j);
        const Vector normal = Cross(u, v);
        const Real cross = Dot(normal, normal);
        parallel = cross <= 1e-14 * (a.square * vv);
        const Real along = Dot(u, between) * a.inverse_square;
        from = Clamped(along);
        to = Clamped(along + uv * a.inverse_square);
        s = parallel ? 0.5 * (from + to) : Clamped(Dot(Cross(between, v), normal) / cross);
        t = Clamped((s * uv - Dot(between, v)) * inverse_vv);
        s = Clamped((Dot(between, u) + t * uv) * a.inverse_square);
        apart = PlusTimes(PlusTimes(between, t, v), -s, u);
      }
      const Real square = Dot(apart, apart), none = Real{};
      // Padding's reach is NaN.
      const Mask touch = (square < reach * reach) & (square > 0);
      if (!Any(touch)) continue;
      const Real distance = Sqrt(square);
      least = touch ? Smaller(least, distance) : least;
      if (Any(touch & (distance < least_share * reach))) {
        least_share = touch ? Smaller(least_share, distance / reach) : least_share;
      }
      Real weight = All(1);
      if (kLaw == kSegments) {
        // Where a neighbour goes on toward the other, the contact is the neighbour's.
        const Real vv = Dot(b_edge, b_edge);
        const Real a_tolerance = 1e-9 * a.square, b_tolerance = 1e-9 * vv;
        const Vector b_before = Sub(b_node, At(job.x, job.y, job.z, j - 1));
        const Vector b_behind = Sub(At(job.x, job.y, job.z, j + 2), b_end);
        const Real one = All(1);
        const Real at_a_end = Dot(apart, a.behind) > a_tolerance ? none : a.end_share;
        const Real at_a_start = -Dot(apart, a.before) > a_tolerance ? none : a.start_share;
        const Real at_b_end = -Dot(apart, b_behind) > b_tolerance ? none : Get(job.node_share + j + 1);
        const Real at_b_start = Dot(apart, b_before) > b_tolerance ? none : Get(job.node_share + j);
        weight = s > 1 - 1e-9 ? at_a_end : (s < 1e-9 ? at_a_start : one);
        weight *= t > 1 - 1e-9 ? at_b_end : (t < 1e-9 ? at_b_start : one);
        if (Any(parallel)) {
          const Real slant = Dot(apart, a.edge);
          const Mask beside = parallel & (slant * slant <= 1e-14 * (a.square * square)) & (a.square * vv > 0);
          const Real side_by_side = to > from ? to - from : from - to;
          const Real ratio = Sqrt(a.square / vv);
          weight = beside ? side_by_side * (ratio > 1 ? ratio : one) : weight;
        }
        weight = touch ? weight : none;
        if (!Any(weight > 0)) continue;
      }
      touched = true;
      const Real overlap = reach - distance, inverse_distance = 1 / distance;
      const Real depth = touch ? overlap : none;
      Real size = job.stiffness * depth * Sqrt(depth);
      if (job.vx != nullptr) {
        const Real sa = kLaw == kSegments ? s : All(0.5), tb = kLaw == kSegments ? t : All(0.5);
        const Vector start_v = At(job.vx, job.vy, job.vz, j), end_v = At(job.vx, job.vy, job.vz, j + 1);
        const Vector approach = Sub(PlusTimes(a.start_velocity, sa, Sub(a.end_velocity, a.start_velocity)),
                                    PlusTimes(start_v, tb, Sub(end_v, start_v)));
        size += job.damping * Dot(approach, apart) * inverse_distance;
        if (kLaw == kSegments) size = size > 0 ? size : none;
      }
      const Real scale = touch ? weight * size * inverse_distance : none;
      const Vector force{scale * apart.x, scale * apart.y, scale * apart.z};
      if (kLaw != kSegments) {
        s = a.rule;
        t = Get(job.end_share + j);
      }
      // Padding has no closest point.
      s = touch ? s : none;
      t = touch ? t : none;
      on_start = PlusTimes(on_start, s - 1, force);
      on_end = PlusTimes(on_end, -s, force);
      Add(job.fx + j, (1 - t) * force.x);
      Add(job.fy + j, (1 - t) * force.y);
      Add(job.fz + j, (1 - t) * force.z);
      Add(job.end_fx + j, t * force.x);
      Add(job.end_fy + j, t * force.y);
      Add(job.end_fz + j, t * force.z);
    }
  }
  if (!touched) return;
  const int i = job.element[n];
  job.fx[i] += Sum(on_start.x);
  job.fy[i] += Sum(on_start.y);
  job.fz[i] += Sum(on_start.z);
  job.end_fx[i] += Sum(on_end.x);
  job.end_fy[i] += Sum(on_end.y);
  job.end_fz[i] += Sum(on_end.z);
  for (int k = 0; k < kDoubles; ++k) {
    if (least[k] < job.least_distance) job.least_distance = least[k];
    if (least_share[k] < job.least_share) job.least_share = least_share[k];
  }
}

template <int kLaw>
void TouchAll(Job& job) {
  for (int n = 0; n < job.elements; ++n) {
    const int i = job.element[n];
    One a;
    a.start = AllAt(job.x, job.y, job.z, i);
    const Vector end = AllAt(job.x, job.y, job.z, i + 1);
    a.edge = Sub(end, a.start);
    a.before = Sub(a.start, AllAt(job.x, job.y, job.z, i - 1));
    a.behind = Sub(AllAt(job.x, job.y, job.z, i + 2), end);
    a.square = Dot(a.edge, a.edge);
    a.inverse_square = a.square > 0 ? 1 / a.square : Real{};
    a.radius = All(job.radius[i]);
    a.start_share = All(job.node_share[i]);
    a.end_share = All(job.node_share[i + 1]);
    a.rule = All(job.end_share[i]);
    if (job.vx != nullptr) {
      a.start_velocity = AllAt(job.vx, job.vy, job.vz, i);
      a.end_velocity = AllAt(job.vx, job.vy, job.vz, i + 1);
    }
    if (job.is_body[n] != 0) {
      TouchRuns<kLaw, true>(job, n, a);
    } else {
      TouchRuns<kLaw, false>(job, n, a);
    }
  }
}

void Touch(Job& job) {
  if (job.law == kSegments) return TouchAll<kSegments>(job);
  if (job.law == kEqual) return TouchAll<kEqual>(job);
  TouchAll<kCenters>(job);
}

}  // namespace

Kernels TENDRIL_CONTACT_KERNELS() { return {&Prepare, &Touch}; }

}  // namespace tendril::contact_kernel
