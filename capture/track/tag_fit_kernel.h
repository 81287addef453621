#pragma once
// What the kernels of tag_fit_problem.cpp are given; compiled once per instruction set (tag_fit_body.h).

#include <cstdint>

namespace tendril::tag_fit {

// The unknowns of a row of the Jacobian, and the residual.
constexpr int kRow = 13;

// What a blurred pattern shows at the places of a grid (TagTable), each number by its own scale.
enum SeenPart {
  kSeenWhite,
  kSeenByU,
  kSeenByV,
  kSeenByUU,
  kSeenByUV,
  kSeenByVV,
  kSeenBlurByU,  // of by_blur
  kSeenBlurByV,
  kSeenParts
};
// What lies inside of the pattern's sides along one direction: share, slope, curvature.
enum SidePart { kSideShare, kSideSlope, kSideCurvature, kSideUnused, kSideParts };

struct TableView {
  int side;  // places along one
  float per_module;
  const std::int16_t* seen;  // [v][u][kSeenParts]
  float scale[kSeenParts];
  const float *sides_u, *sides_v;   // [place][kSideParts]
  float blur_uu, blur_uv, blur_vv;  // by_blur as a sum of second derivatives
};

struct Evaluate {
  TableView table;
  int pixels;  // arrays are as long as the next whole sixteen
  const float *x, *y, *gray;
  float g[9];                    // tag_from_pixel, by rows
  float black, white, surround;  // white and surround: what they are brighter than black
  float blur_change;             // of the blur's logarithm, since the table's
  float half;                    // half the border's width, modules
  float middle;                  // of the pattern, modules
  // Out: sums of products of columns of the rows, the lower triangle.
  float sums[kRow][kRow];
};

struct Kernels {
  void (*evaluate)(Evaluate&);
};

Kernels BaseKernels();
Kernels Avx2Kernels();
Kernels Avx512Kernels();

}  // namespace tendril::tag_fit
