#pragma once
// The Gauss integrand's exact value on straight pieces: the signed solid angle under which two segments, a
// segment and a ray, or two rays see each other. A link is the sum of these over 4 pi.
//
// Sign: the Gauss integral of (dr1 x dr2).(r1 - r2) / |r1 - r2|^3, so that a right-handed helix has positive
// writhe. Any unit of length, as long as sixth powers of lengths stay in range (CloseCurve sees to that).
// Templates on the number type, so that a wider one can check the narrow one.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace tendril {

template <class T>
struct Vec3 {
  T x, y, z;
};

template <class T>
Vec3<T> operator-(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
T Dot(const Vec3<T>& a, const Vec3<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
Vec3<T> Cross(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
T Norm(const Vec3<T>& a) {
  return std::sqrt(Dot(a, a));
}

template <class T>
Vec3<T> operator*(T s, const Vec3<T>& a) {
  return {s * a.x, s * a.y, s * a.z};
}

// A triple product below this share of its factors' lengths is rounding noise and counts as 0.
inline constexpr double kCoplanar = 1e-13;

template <class T>
struct SolidAngle {
  T angle = 0;           // rad, in [-2 pi, 2 pi]; 0, the mean of both sides, where `on_edge`
  T error = 0;           // bound on the rounding error of `angle`, rad; 2 pi where `on_edge`
  bool on_edge = false;  // coplanar and crossing or touching: the angle jumps by 4 pi (or 2 pi) here
};

// Segment p1 -> p2 against segment p3 -> p4, to rounding at any distance:
//   angle = 2 atan2(p (d1 + d2), d1 d2 - p^2)
// from the two triangles that make up the quadrilateral. p is taken from the shortest of the four
// differences, which all have the same triple product. Source: Klenin and Langowski 2000 (the quadrilateral),
// Van Oosterom and Strackee 1983 (its triangles).
//   lengths  of the differences between p1 .. p4 below, known to the caller that goes over many pairs
template <class T>
struct PairLengths {
  T a, b, c, d, r12, r34;
};

template <class T>
SolidAngle<T> SegmentSegmentAngle(const Vec3<T>& p1, const Vec3<T>& p2, const Vec3<T>& p3, const Vec3<T>& p4,
                                  const PairLengths<T>& lengths) {
  constexpr T kUlp = std::numeric_limits<T>::epsilon();
  constexpr T kPi = std::numbers::pi_v<T>;
  const Vec3<T> a = p3 - p1, b = p4 - p1, c = p4 - p2, d = p3 - p2, r12 = p2 - p1, r34 = p4 - p3;
  const T na = lengths.a, nb = lengths.b, nc = lengths.c, nd = lengths.d;
  const Vec3<T>& ab = na <= nb ? a : b;
  const Vec3<T>& cd = nc <= nd ? c : d;
  const T nab = std::min(na, nb), ncd = std::min(nc, nd);
  const T p = Dot(nab <= ncd ? ab : cd, Cross(r34, r12));
  const T size = std::min(nab, ncd) * lengths.r12 * lengths.r34;
  const T ca = Dot(c, a);
  const T n1 = na * nb * nc;
  const T n2 = na * nd * nc;
  const T d1 = n1 + Dot(a, b) * nc + Dot(b, c) * na + ca * nb;
  const T d2 = n2 + Dot(a, d) * nc + Dot(d, c) * na + ca * nd;
  if (std::abs(p) <= T(kCoplanar) * size) {
    if (d1 <= T(1e-12) * n1 || d2 <= T(1e-12) * n2) return {T(0), 2 * kPi, true};
    return {T(0), 2 * T(kCoplanar) * size * (1 / d1 + 1 / d2), false};
  }
  const T angle = 2 * std::atan2(p * (d1 + d2), d1 * d2 - p * p);
  // 23 instead of 16 sqrt(2): the sums of magnitudes stand for the roots of the sums of squares.
  const T m1 = std::abs(p) + std::abs(d1), m2 = std::abs(p) + std::abs(d2);
  const T error =
      23 * kUlp * (((n1 + size) * m2 + (n2 + size) * m1) / (m1 * m2)) + 4 * kUlp * std::abs(angle);
  return {angle, std::min(error, 4 * kPi), false};
}

template <class T>
SolidAngle<T> SegmentSegmentAngle(const Vec3<T>& p1, const Vec3<T>& p2, const Vec3<T>& p3,
                                  const Vec3<T>& p4) {
  return SegmentSegmentAngle(
      p1, p2, p3, p4,
      {Norm(p3 - p1), Norm(p4 - p1), Norm(p4 - p2), Norm(p3 - p2), Norm(p2 - p1), Norm(p4 - p3)});
}

// The ray from the origin along the unit vector u against the great arc from a to b (vectors from the ray's
// start; b may also be a direction at infinity): the triangle (a, b, -u), into which the quadrilateral
// shrinks as p2 = t u, t -> infinity. Written with the parts across u, a = alpha u + a', so that nothing
// cancels far down the ray: tan(angle / 2) = u.(a' x b') / ((|a| - alpha)(|b| - beta) + a'.b').
//   along    b - a for a segment; b itself if b is a direction at infinity
//   u_error  how far u may be off, rad
template <class T>
SolidAngle<T> RayArcAngle(const Vec3<T>& u, T u_error, const Vec3<T>& a, const Vec3<T>& b,
                          const Vec3<T>& along, bool b_at_infinity) {
  constexpr T kUlp = std::numeric_limits<T>::epsilon();
  constexpr T kPi = std::numbers::pi_v<T>;
  const T alpha = Dot(a, u), beta = Dot(b, u);
  const Vec3<T> a_across = a - alpha * u, b_across = b - beta * u;
  const T na = Norm(a), nb = Norm(b), na_across = Norm(a_across), nb_across = Norm(b_across);
  const T a_short = alpha > 0 ? na_across * na_across / (na + alpha) : na - alpha;
  const T b_short = beta > 0 ? nb_across * nb_across / (nb + beta) : nb - beta;
  const bool from_a = b_at_infinity || na <= nb;
  const T p = Dot(u, Cross(from_a ? a_across : b_across, along));
  const T size = (from_a ? na : nb) * Norm(along);
  const T doubt = T(kCoplanar) + u_error;
  const T noise = doubt * size;
  const T n = a_short * b_short + na_across * nb_across;
  const T d = a_short * b_short + Dot(a_across, b_across);
  const T d_noise = T(1e-12) * n + doubt * (na * nb_across + nb * na_across);
  if (std::abs(p) <= noise) {
    if (d <= d_noise) return {T(0), 2 * kPi, true};
    return {T(0), 2 * noise / d, false};
  }
  const T p_error = (8 * kUlp + u_error) * size;
  const T d_error = 8 * kUlp * n + (8 * kUlp + u_error) * (na * nb_across + nb * na_across);
  const T error = 2 * (p_error + d_error) / std::sqrt(p * p + d * d);
  return {2 * std::atan2(p, d), std::min(error, 2 * kPi), false};
}

template <class T>
SolidAngle<T> RaySegmentAngle(const Vec3<T>& start, const Vec3<T>& u, T u_error, const Vec3<T>& p3,
                              const Vec3<T>& p4) {
  return RayArcAngle(u, u_error, p3 - start, p4 - start, p4 - p3, false);
}

// Two rays: from p1 along u and from p3 along v (unit vectors). Undefined where u = v (0 is returned: the
// limit of equal lengths) and a jump where they meet (`on_edge`).
template <class T>
SolidAngle<T> RayRayAngle(const Vec3<T>& p1, const Vec3<T>& u, const Vec3<T>& p3, const Vec3<T>& v, T error) {
  return RayArcAngle(u, error, p3 - p1, v, v, true);
}

}  // namespace tendril
