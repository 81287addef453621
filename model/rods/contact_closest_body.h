// Three-vectors of registers and the closest points of two elements, for the contact kernels; C alone, as
// registers_body.h says.
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
// Faster than the machine's own gather, which is not made for cached data; and all at once, as GCC makes a
// chain of assignments to lanes.
TENDRIL_INLINE Real Gather(const double* from, const int* p) {
#if TENDRIL_ROD_WIDTH == 8
  return Real{from[p[0]], from[p[1]], from[p[2]], from[p[3]], from[p[4]], from[p[5]], from[p[6]], from[p[7]]};
#elif TENDRIL_ROD_WIDTH == 4
  return Real{from[p[0]], from[p[1]], from[p[2]], from[p[3]]};
#else
  return Real{from[p[0]], from[p[1]]};
#endif
}
TENDRIL_INLINE void Put(double* to, Real v) { __builtin_memcpy(to, &v, sizeof v); }
TENDRIL_INLINE Real Clamped(Real v) {
  v = v > 0 ? v : Real{};
  return v < 1 ? v : All(1);
}
TENDRIL_INLINE Real Smaller(Real a, Real b) { return a < b ? a : b; }
TENDRIL_INLINE Real Larger(Real a, Real b) { return a > b ? a : b; }
TENDRIL_INLINE Real Size(Real v) { return v < 0 ? -v : v; }
// A bit for each lane.
TENDRIL_INLINE unsigned Bits(Mask mask) {
#if TENDRIL_ROD_WIDTH == 8
  return _mm512_test_epi64_mask(reinterpret_cast<__m512i>(mask), reinterpret_cast<__m512i>(mask));
#elif TENDRIL_ROD_WIDTH == 4
  return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(mask)));
#else
  unsigned bits = 0;
  for (int k = 0; k < kDoubles; ++k) bits |= (mask[k] != 0 ? 1u : 0u) << k;
  return bits;
#endif
}
TENDRIL_INLINE bool Any(Mask mask) { return Bits(mask) != 0; }

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

// An element from its start along its edge.
struct Segment {
  Vector start, edge;
  Real square, inverse_square;  // of its length; 0 for a point
};

struct Closest {
  Real s = All(0.5), t = All(0.5);          // shares of the elements where the closest points lie
  Real from = All(0.5), to = All(0.5);      // where the other's start and end lie along the one
  Mask parallel = {};                       // within 1e-7 rad
  Vector apart = {Real{}, Real{}, Real{}};  // from the one's closest point to the other's
};

// As ClosestOfSegments; with kCenters, of the elements' centres, or of a body's axis and an element's centre.
template <int kLaw, bool kBody>
TENDRIL_INLINE Closest ClosestOf(const Segment& a, const Segment& b) {
  Closest c;
  const Vector& u = a.edge;
  Vector v = b.edge, between = Sub(b.start, a.start);
  Real inverse_vv = b.inverse_square;
  if (kLaw == kCenters) between = PlusTimes(between, All(0.5), v);
  if (kLaw == kCenters && !kBody) {
    c.apart = PlusTimes(between, All(-0.5), u);
    return c;
  }
  if (kLaw == kCenters) {
    v = {Real{}, Real{}, Real{}};
    inverse_vv = Real{};
  }
  const Real uv = Dot(u, v), vv = Dot(v, v);
  const Vector normal = Cross(u, v);
  const Real cross = Dot(normal, normal);
  c.parallel = cross <= 1e-14 * (a.square * vv);
  const Real along = Dot(u, between) * a.inverse_square;
  c.from = Clamped(along);
  c.to = Clamped(along + uv * a.inverse_square);
  c.s = c.parallel ? 0.5 * (c.from + c.to) : Clamped(Dot(Cross(between, v), normal) / cross);
  c.t = Clamped((c.s * uv - Dot(between, v)) * inverse_vv);
  c.s = Clamped((Dot(between, u) + c.t * uv) * a.inverse_square);
  c.apart = PlusTimes(PlusTimes(between, c.t, v), -c.s, u);
  return c;
}

}  // namespace
}  // namespace tendril::contact_kernel
