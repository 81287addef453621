// The body of the link kernels, compiled once per instruction set by the link_kernel_*.cpp that define
// TENDRIL_LINK_WIDTH and include this. No #pragma once, and nothing but C: an inline function of the standard
// library compiled here with wide instructions could be the copy that the linker keeps for the whole program.
#include <math.h>
#include <stdint.h>
#if TENDRIL_LINK_WIDTH > 2
#include <immintrin.h>
#endif

#include "analysis/link/link_kernel.h"

namespace tendril::link_kernel {
namespace {

constexpr int kWidth = TENDRIL_LINK_WIDTH;
typedef double Real __attribute__((vector_size(8 * TENDRIL_LINK_WIDTH)));
typedef int64_t Mask __attribute__((vector_size(8 * TENDRIL_LINK_WIDTH)));
typedef double Unaligned __attribute__((vector_size(8 * TENDRIL_LINK_WIDTH), aligned(8), may_alias));

inline Real Load(const double* from) { return *reinterpret_cast<const Unaligned*>(from); }
inline void Store(double* to, Real v) { *reinterpret_cast<Unaligned*>(to) = v; }
inline Real All(double v) { return v - Real{}; }

#if TENDRIL_LINK_WIDTH == 8
inline Real Fma(Real a, Real b, Real c) { return _mm512_fmadd_pd(a, b, c); }    // a b + c
inline Real Fnma(Real a, Real b, Real c) { return _mm512_fnmadd_pd(a, b, c); }  // c - a b
inline Real Sqrt(Real a) { return _mm512_maskz_sqrt_pd(0xFF, a); }  // the plain one warns in GCC 12
#elif TENDRIL_LINK_WIDTH == 4
inline Real Fma(Real a, Real b, Real c) { return _mm256_fmadd_pd(a, b, c); }
inline Real Fnma(Real a, Real b, Real c) { return _mm256_fnmadd_pd(a, b, c); }
inline Real Sqrt(Real a) { return _mm256_sqrt_pd(a); }
#else
inline Real Fma(Real a, Real b, Real c) { return a * b + c; }
inline Real Fnma(Real a, Real b, Real c) { return c - a * b; }
inline Real Sqrt(Real a) {
  Real r;
  for (int k = 0; k < kWidth; ++k) r[k] = __builtin_sqrt(a[k]);
  return r;
}
#endif

inline Real Abs(Real a) { return reinterpret_cast<Real>(reinterpret_cast<Mask>(a) & INT64_MAX); }
inline Real Min(Real a, Real b) { return a < b ? a : b; }
inline Real Max(Real a, Real b) { return a > b ? a : b; }

struct Vector {
  Real x, y, z;
};
inline Vector Minus(const Vector& a, const Vector& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Real Dot(const Vector& a, const Vector& b) { return Fma(a.x, b.x, Fma(a.y, b.y, a.z * b.z)); }
inline Vector Cross(const Vector& a, const Vector& b) {
  return {Fnma(a.z, b.y, a.y * b.z), Fnma(a.x, b.z, a.z * b.x), Fnma(a.y, b.x, a.x * b.y)};
}
inline Vector Select(Mask m, const Vector& a, const Vector& b) {
  return {m ? a.x : b.x, m ? a.y : b.y, m ? a.z : b.z};
}
inline Vector LoadVector(const NodeArrays& b, size_t j) {
  return {Load(b.x + j), Load(b.y + j), Load(b.z + j)};
}
inline Vector AllVector(const NodeArrays& a, size_t i) { return {All(a.x[i]), All(a.y[i]), All(a.z[i])}; }

// Distances of node i of a to all nodes of b, padding included.
inline void Distances(const Job& job, size_t i, double* row) {
  const Vector here = AllVector(job.a, i);
  for (size_t j = job.own ? i + 1 : 0; j < job.b.nodes + kPadding - kWidth; j += kWidth) {
    const Vector v = Minus(LoadVector(job.b, j), here);
    Store(row + j, Sqrt(Dot(v, v)));
  }
}

// One running product per lane: z = exp(i sum of half angles) up to a positive factor, without its full
// turns.
struct Product {
  Real re = All(1), im = All(0);
  Mask turns = {};

  // Half angles lie in (-pi, pi), so im's sign says which way z turned, and z's side before and after whether
  // it passed the negative real axis.
  void Times(Real factor_re, Real factor_im) {
    const Real next_re = Fnma(im, factor_im, re * factor_re);
    const Real next_im = Fma(re, factor_im, im * factor_re);
    const Mask below = im < All(0), next_below = next_im < All(0);
    turns -= (factor_im > All(0)) & ~below & next_below;
    turns += (factor_im < All(0)) & below & ~next_below;
    // Scaled back by the power of two next to its size: exact, and no product can over- or underflow.
    const Mask exponent = reinterpret_cast<Mask>(Max(Abs(next_re), Abs(next_im))) & 0x7FF0000000000000;
    const Real scale = reinterpret_cast<Real>(0x7FE0000000000000 - exponent);
    re = next_re * scale;
    im = next_im * scale;
  }

  double HalfAngles() const {
    double sum = 0;
    for (int k = 0; k < kWidth; ++k) {
      sum += atan2(im[k] + 0.0, re[k]) + 2 * M_PI * static_cast<double>(turns[k]);
    }
    return sum;
  }
};

inline void Run(Job& job) {
  constexpr double kNoise = 1e-13;  // kCoplanar of solid_angle.h
  constexpr double kNear = 1e-6;
  constexpr size_t kProductLength = 4096;  // factors between two atan2: keeps rounding at a few 1e-15
  const size_t b_segments = job.b.nodes - 1;
  double half_angles = 0;
  Mask suspicious = {};
  Product product;
  size_t factors = 0;
  Distances(job, 0, job.row_next);
  for (size_t i = 0; i + 1 < job.a.nodes; ++i) {
    double* const spare = job.row_here;
    job.row_here = job.row_next;
    job.row_next = spare;
    Distances(job, i + 1, job.row_next);
    const Vector a0 = AllVector(job.a, i), a1 = AllVector(job.a, i + 1);
    const Vector r12 = Minus(a1, a0);
    const Real noise12 = kNoise * Sqrt(Dot(r12, r12));
    for (size_t j = job.own ? i + 2 : 0; j < b_segments; j += kWidth) {
      const Vector b0 = LoadVector(job.b, j), b1 = LoadVector(job.b, j + 1);
      const Vector a = Minus(b0, a0), b = Minus(b1, a0), c = Minus(b1, a1), d = Minus(b0, a1);
      const Real na = Load(job.row_here + j), nb = Load(job.row_here + j + 1);
      const Real nd = Load(job.row_next + j), nc = Load(job.row_next + j + 1);
      const Real nab = Min(na, nb), ncd = Min(nc, nd);
      const Vector near = Select(nab <= ncd, Select(na <= nb, a, b), Select(nc <= nd, c, d));
      const Real p = Dot(near, Cross(Minus(b1, b0), r12));
      const Real n1 = na * nb * nc, n2 = na * nd * nc;
      const Real ca = Dot(c, a);
      const Real d1 = Fma(Dot(a, b), nc, Fma(Dot(b, c), na, Fma(ca, nb, n1)));
      const Real d2 = Fma(Dot(a, d), nc, Fma(Dot(d, c), na, Fma(ca, nd, n2)));
      const Mask flat = Abs(p) <= noise12 * Load(job.b_lengths + j) * Min(nab, ncd);
      suspicious |= flat & ((d1 <= kNear * n1) | (d2 <= kNear * n2));
      product.Times(flat ? All(1) : Fnma(p, p, d1 * d2), flat ? All(0) : p * (d1 + d2));
    }
    factors += b_segments / kWidth + 1;
    if (factors >= kProductLength) {
      half_angles += product.HalfAngles();
      product = Product{};
      factors = 0;
    }
  }
  half_angles += product.HalfAngles();
  job.angle = 2 * half_angles;
  job.suspicious = false;
  for (int k = 0; k < kWidth; ++k) job.suspicious = job.suspicious || suspicious[k] != 0;
}

}  // namespace
}  // namespace tendril::link_kernel
