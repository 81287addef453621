#pragma once
// Sums of segment-pair solid angles over whole polylines, in vector registers: about 3 ns per pair with
// AVX-512, where the scalar formula of solid_angle.h takes 30.
//
// The angles are not added but multiplied: each pair gives a complex number whose argument is half its solid
// angle, the numbers' product is kept together with its turns about 0, and one atan2 serves thousands of
// pairs. Same rounding rule (kCoplanar) as the scalar form. Where a pair touches or crosses in a plane the
// sum says so, and the caller goes over it again in the scalar form, which knows what to do there.

#include <cstddef>

namespace tendril {

struct NodeArrays {  // a polyline, m
  const double* x;
  const double* y;
  const double* z;
  size_t nodes;
};

struct AngleSum {
  double angle = 0;         // sum of the solid angles, rad
  bool suspicious = false;  // a pair is coplanar and touches, crosses, or comes within 1e-6 of it
};

// The vector width that this machine runs, in doubles: 8 (AVX-512), 4 (AVX2 with FMA) or 2.
int LinkKernelWidth();

// All segments of a against all of b; and all of one curve against its own non-neighbours, each pair once.
//   width  2, 4 or 8 but not above LinkKernelWidth(), to compare kernels; 0: the widest
AngleSum SumSegmentAngles(const NodeArrays& a, const NodeArrays& b, int width = 0);
AngleSum SumOwnSegmentAngles(const NodeArrays& a, int width = 0);

namespace link_kernel {

// What one kernel is given: b padded by `kPadding` copies of its last node, lengths of its segments (0 in the
// padding), and two rows of scratch as long as b with its padding. Coordinates scaled to about 1.
struct Job {
  NodeArrays a;
  NodeArrays b;             // nodes counts b without its padding
  const double* b_lengths;  // |b[j+1] - b[j]|
  double* row_here;         // scratch
  double* row_next;         // scratch
  bool own;                 // a is b: only segments j >= i + 2 of row i
  double angle;             // out, rad
  bool suspicious;          // out
};
inline constexpr size_t kPadding = 16;

void RunBase(Job& job);
void RunAvx2(Job& job);
void RunAvx512(Job& job);

}  // namespace link_kernel
}  // namespace tendril
