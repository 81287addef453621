#include "analysis/link/link_kernel.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "model/check.h"
#include "model/machine.h"

namespace tendril {
namespace {

using link_kernel::Job;
using link_kernel::kPadding;

void RunKernel(Job& job, int width) {
  TENDRIL_CHECK(width <= LinkKernelWidth());
#ifdef TENDRIL_LINK_X86
  if (width == 8) return link_kernel::RunAvx512(job);
  if (width == 4) return link_kernel::RunAvx2(job);
#endif
  link_kernel::RunBase(job);
}

// The power of two that brings the pair's extent to about 1: exact, and keeps sixth powers of lengths in
// range.
double Scale(const NodeArrays& a, const NodeArrays& b) {
  double extent = 0;
  for (const NodeArrays* curve : {&a, &b}) {
    for (size_t i = 0; i < curve->nodes; ++i) {
      extent = std::max({extent, std::abs(curve->x[i] - a.x[0]), std::abs(curve->y[i] - a.y[0]),
                         std::abs(curve->z[i] - a.z[0])});
    }
  }
  return extent > 0 && std::isfinite(extent) ? std::exp2(std::min(1000, -std::ilogb(extent))) : 1.0;
}

AngleSum Sum(const NodeArrays& a, const NodeArrays& b, bool own, int width) {
  TENDRIL_CHECK(a.nodes > 0 && b.nodes > 0);
  if (a.nodes < 2 || b.nodes < 2) return {};
  const double scale = Scale(a, b);
  const size_t row = b.nodes + kPadding;
  std::vector<double> memory(6 * row + (own ? 0 : 3 * a.nodes));
  double* const bx = memory.data();
  double* const by = bx + row;
  double* const bz = by + row;
  double* const lengths = bz + row;
  for (size_t j = 0; j < row; ++j) {
    const size_t from = std::min(j, b.nodes - 1);
    bx[j] = b.x[from] * scale;
    by[j] = b.y[from] * scale;
    bz[j] = b.z[from] * scale;
  }
  for (size_t j = 0; j + 1 < row; ++j) {
    const double x = bx[j + 1] - bx[j], y = by[j + 1] - by[j], z = bz[j + 1] - bz[j];
    lengths[j] = std::sqrt(x * x + y * y + z * z);
  }
  const NodeArrays b_scaled{bx, by, bz, b.nodes};
  NodeArrays a_scaled = b_scaled;
  if (!own) {
    double* const ax = memory.data() + 6 * row;
    for (size_t i = 0; i < a.nodes; ++i) {
      ax[i] = a.x[i] * scale;
      ax[a.nodes + i] = a.y[i] * scale;
      ax[2 * a.nodes + i] = a.z[i] * scale;
    }
    a_scaled = {ax, ax + a.nodes, ax + 2 * a.nodes, a.nodes};
  }
  Job job{a_scaled, b_scaled, lengths, lengths + row, lengths + 2 * row, own, 0, false};
  RunKernel(job, width > 0 ? width : LinkKernelWidth());
  return {job.angle, job.suspicious};
}

}  // namespace

int LinkKernelWidth() { return MachineDoubles(); }

AngleSum SumSegmentAngles(const NodeArrays& a, const NodeArrays& b, int width) {
  return Sum(a, b, false, width);
}

AngleSum SumOwnSegmentAngles(const NodeArrays& a, int width) { return Sum(a, a, true, width); }

}  // namespace tendril
