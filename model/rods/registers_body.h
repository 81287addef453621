// Vector registers of TENDRIL_ROD_WIDTH doubles, for kernels that are compiled once per instruction set. No
// #pragma once, and nothing but C: an inline function of the standard library compiled here with wide
// instructions could be the copy that the linker keeps for the whole program.
#include <stdint.h>
#if TENDRIL_ROD_WIDTH > 2
#include <immintrin.h>
#endif

namespace tendril {
namespace {

#define TENDRIL_INLINE inline __attribute__((always_inline))

constexpr int kDoubles = TENDRIL_ROD_WIDTH;                                 // in a register
constexpr int kFloats = TENDRIL_ROD_WIDTH < 4 ? 2 * TENDRIL_ROD_WIDTH : 8;  // no more than there are rods

template <class S>
struct Types;
template <>
struct Types<double> {
  static constexpr int kWidth = kDoubles;
  typedef double Real __attribute__((vector_size(8 * kDoubles)));
  typedef int64_t Mask __attribute__((vector_size(8 * kDoubles)));
};
template <>
struct Types<float> {
  static constexpr int kWidth = kFloats;
  typedef float Real __attribute__((vector_size(4 * kFloats)));
  typedef int32_t Mask __attribute__((vector_size(4 * kFloats)));
};

typedef Types<double>::Real Doubles;
typedef Types<float>::Real Floats;

TENDRIL_INLINE Doubles Sqrt(Doubles a) {
#if TENDRIL_ROD_WIDTH == 8
  return reinterpret_cast<Doubles>(_mm512_maskz_sqrt_pd(0xFF, reinterpret_cast<__m512d>(a)));
#elif TENDRIL_ROD_WIDTH == 4
  return reinterpret_cast<Doubles>(_mm256_sqrt_pd(reinterpret_cast<__m256d>(a)));
#else
  for (int k = 0; k < kDoubles; ++k) a[k] = __builtin_sqrt(a[k]);
  return a;
#endif
}

// 1 / sqrt(a) of a > 0, to a rounding or two.
TENDRIL_INLINE Doubles InverseSqrt(Doubles a) {
#if TENDRIL_ROD_WIDTH == 8
  // Fourteen bits, doubled twice.
  Doubles r = reinterpret_cast<Doubles>(_mm512_maskz_rsqrt14_pd(0xFF, reinterpret_cast<__m512d>(a)));
  const Doubles half = 0.5 * a;
  r *= 1.5 - half * r * r;
  return r * (1.5 - half * r * r);
#else
  return 1 / Sqrt(a);
#endif
}

TENDRIL_INLINE Floats Sqrt(Floats a) {
#if TENDRIL_ROD_WIDTH > 2
  return reinterpret_cast<Floats>(_mm256_sqrt_ps(reinterpret_cast<__m256>(a)));
#else
  for (int k = 0; k < kFloats; ++k) a[k] = __builtin_sqrtf(a[k]);
  return a;
#endif
}

}  // namespace
}  // namespace tendril
