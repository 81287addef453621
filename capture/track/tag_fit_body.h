// The sums behind a tag's fit, for many pixels at once; compiled once per instruction set by the
// tag_fit_*.cpp that define TENDRIL_FIT_WIDTH (floats in a register) and TENDRIL_FIT_KERNELS, and include
// this. Nothing but C: an inline function of the standard library compiled here with wide instructions could
// be the copy that the linker keeps for the whole program.
#include "capture/track/tag_fit_kernel.h"

namespace tendril::tag_fit {
namespace {

#define TENDRIL_INLINE inline __attribute__((always_inline))

constexpr int kWidth = TENDRIL_FIT_WIDTH;
typedef float Real __attribute__((vector_size(4 * kWidth)));
typedef std::int32_t Int __attribute__((vector_size(4 * kWidth)));
typedef std::int16_t Short __attribute__((vector_size(2 * kWidth)));
typedef std::int16_t Eight __attribute__((vector_size(16)));
typedef float Four __attribute__((vector_size(16)));

TENDRIL_INLINE Real All(float v) { return v - Real{}; }
TENDRIL_INLINE Real Get(const float* from) {
  Real r;
  __builtin_memcpy(&r, from, sizeof r);
  return r;
}
TENDRIL_INLINE void Put(float* to, Real v) { __builtin_memcpy(to, &v, sizeof v); }
TENDRIL_INLINE void Put(std::int32_t* to, Int v) { __builtin_memcpy(to, &v, sizeof v); }
TENDRIL_INLINE Real Get(const std::int16_t* from) {
  Short s;
  __builtin_memcpy(&s, from, sizeof s);
  return __builtin_convertvector(__builtin_convertvector(s, Int), Real);
}

// Pixels at once: their rows fit the nearest cache.
constexpr int kBlock = 128;
struct Block {
  float tx[kBlock], ty[kBlock], du[kBlock], dv[kBlock];
  std::int32_t at[kBlock], along[kBlock], across[kBlock];
  std::int16_t seen[kSeenParts][kBlock];
  float sides[2][kSideParts][kBlock];
  float rows[kRow][kBlock];
};

// Where each pixel lies in the tag, and the place of the table that is nearest.
TENDRIL_INLINE void Place(const Evaluate& e, int from, int count, Block& b) {
  const float* const g = e.g;
  const TableView& t = e.table;
  const float scale = e.half * t.per_module, offset = (e.middle + 0.5f) * t.per_module;
  const float last = static_cast<float>(t.side - 1), spacing = 1 / t.per_module;
  for (int i = 0; i < count; i += kWidth) {
    const Real x = Get(e.x + from + i), y = Get(e.y + from + i);
    const Real s = g[6] * x + g[7] * y + g[8], d = 1 / s;
    const Real tx = d * (g[0] * x + g[1] * y + g[2]), ty = d * (g[3] * x + g[4] * y + g[5]);
    // Beyond the table as at its rim.
    Real along = tx * scale + offset, across = ty * scale + offset;
    along = along > 0 ? along : Real{};
    across = across > 0 ? across : Real{};
    along = along < last ? along : All(last);
    across = across < last ? across : All(last);
    const Real u = along + 0.5f, v = across + 0.5f;
    const Int column = __builtin_convertvector(u, Int), row = __builtin_convertvector(v, Int);
    Put(b.tx + i, tx);
    Put(b.ty + i, ty);
    Put(b.du + i, spacing * (along - __builtin_convertvector(column, Real)));
    Put(b.dv + i, spacing * (across - __builtin_convertvector(row, Real)));
    Put(b.at + i, row * t.side + column);
    Put(b.along + i, column);
    Put(b.across + i, row);
  }
}

TENDRIL_INLINE Eight Load(const TableView& t, std::int32_t at) {
  Eight e;
  __builtin_memcpy(&e, t.seen + static_cast<std::int64_t>(at) * kSeenParts, sizeof e);
  return e;
}

// The table's entries of eight pixels, as eight arrays. (Shuffles, not the machine's gather, which takes
// thrice as long.)
TENDRIL_INLINE void LoadSeen(const TableView& t, const std::int32_t* at, int i, Block& b) {
  const Eight low = {0, 8, 1, 9, 2, 10, 3, 11}, high = {4, 12, 5, 13, 6, 14, 7, 15};
  Eight r[8], s[8];
  for (int k = 0; k < 8; ++k) r[k] = Load(t, at[k]);
  // Thrice: entries k and k + 4 by turns.
  for (int k = 0; k < 4; ++k) {
    s[2 * k] = __builtin_shuffle(r[k], r[k + 4], low);
    s[2 * k + 1] = __builtin_shuffle(r[k], r[k + 4], high);
  }
  for (int k = 0; k < 4; ++k) {
    r[2 * k] = __builtin_shuffle(s[k], s[k + 4], low);
    r[2 * k + 1] = __builtin_shuffle(s[k], s[k + 4], high);
  }
  for (int k = 0; k < 4; ++k) {
    s[2 * k] = __builtin_shuffle(r[k], r[k + 4], low);
    s[2 * k + 1] = __builtin_shuffle(r[k], r[k + 4], high);
  }
  for (int part = 0; part < kSeenParts; ++part) __builtin_memcpy(&b.seen[part][i], &s[part], sizeof s[part]);
}

TENDRIL_INLINE void LoadSides(const float* sides, const std::int32_t* at, int i, float (*to)[kBlock]) {
  typedef std::int32_t Mask __attribute__((vector_size(16)));
  Four r[4];
  for (int k = 0; k < 4; ++k) __builtin_memcpy(&r[k], sides + at[k] * kSideParts, sizeof r[k]);
  const Mask low = {0, 4, 1, 5}, high = {2, 6, 3, 7}, front = {0, 1, 4, 5}, back = {2, 3, 6, 7};
  const Four a = __builtin_shuffle(r[0], r[1], low), c = __builtin_shuffle(r[2], r[3], low);
  const Four d = __builtin_shuffle(r[0], r[1], high), e = __builtin_shuffle(r[2], r[3], high);
  const Four share = __builtin_shuffle(a, c, front), slope = __builtin_shuffle(a, c, back);
  const Four curvature = __builtin_shuffle(d, e, front);
  __builtin_memcpy(&to[kSideShare][i], &share, sizeof share);
  __builtin_memcpy(&to[kSideSlope][i], &slope, sizeof slope);
  __builtin_memcpy(&to[kSideCurvature][i], &curvature, sizeof curvature);
}

// The Jacobian's rows with the residual. The pattern moves under the pixel: gray by pixel, then pixel by
// homography with its sign turned.
TENDRIL_INLINE void Rows(const Evaluate& e, int from, int count, Block& b) {
  const float* const g = e.g;
  const TableView& t = e.table;
  for (int i = 0; i < count; i += kWidth) {
    const Real du = Get(b.du + i), dv = Get(b.dv + i);
    const auto seen = [&](SeenPart part) { return t.scale[part] * Get(b.seen[part] + i); };
    const Real uu = seen(kSeenByUU), uv = seen(kSeenByUV), vv = seen(kSeenByVV);
    const Real u0 = seen(kSeenByU), v0 = seen(kSeenByV);
    const Real along = du * uu + dv * uv, across = du * uv + dv * vv;
    const Real by_u = u0 + along, by_v = v0 + across;
    const Real by_blur =
        t.blur_uu * uu + t.blur_uv * uv + t.blur_vv * vv + du * seen(kSeenBlurByU) + dv * seen(kSeenBlurByV);
    const Real white =
        seen(kSeenWhite) + du * (u0 + 0.5f * along) + dv * (v0 + 0.5f * across) + e.blur_change * by_blur;
    const auto side = [&](int which, SidePart part) { return Get(b.sides[which][part] + i); };
    const Real in_u_by = side(0, kSideSlope) + du * side(0, kSideCurvature);
    const Real in_v_by = side(1, kSideSlope) + dv * side(1, kSideCurvature);
    const Real in_u = side(0, kSideShare) + 0.5f * du * (side(0, kSideSlope) + in_u_by);
    const Real in_v = side(1, kSideShare) + 0.5f * dv * (side(1, kSideSlope) + in_v_by);
    const Real surround = 1 - in_u * in_v;

    const Real x = Get(e.x + from + i), y = Get(e.y + from + i);
    const Real tx = Get(b.tx + i), ty = Get(b.ty + i);
    const Real by_tx = e.half * (e.white * by_u - e.surround * in_u_by * in_v);
    const Real by_ty = e.half * (e.white * by_v - e.surround * in_v_by * in_u);
    const Real cx = -(by_tx * (g[0] - tx * g[6]) + by_ty * (g[3] - ty * g[6]));
    const Real cy = -(by_tx * (g[1] - tx * g[7]) + by_ty * (g[4] - ty * g[7]));
    const Real bend = -(cx * x + cy * y);
    Put(b.rows[0] + i, cx * tx);
    Put(b.rows[1] + i, cx * ty);
    Put(b.rows[2] + i, cx);
    Put(b.rows[3] + i, cy * tx);
    Put(b.rows[4] + i, cy * ty);
    Put(b.rows[5] + i, cy);
    Put(b.rows[6] + i, bend * tx);
    Put(b.rows[7] + i, bend * ty);
    Put(b.rows[8] + i, All(1));
    Put(b.rows[9] + i, white);
    Put(b.rows[10] + i, surround);
    Put(b.rows[11] + i, e.white * by_blur);
    Put(b.rows[12] + i, e.black + e.white * white + e.surround * surround - Get(e.gray + from + i));
  }
}

// Sums of a tile of products stay in registers.
template <int kDown, int kAcross>
TENDRIL_INLINE void Tile(const Block& b, int count, int down, int across, Real (*sums)[kRow]) {
  Real tile[kDown][kAcross];
  for (int r = 0; r < kDown; ++r) {
    for (int c = 0; c < kAcross; ++c) tile[r][c] = sums[down + r][across + c];
  }
  for (int i = 0; i < count; i += kWidth) {
    Real one[kDown], other[kAcross];
    for (int r = 0; r < kDown; ++r) one[r] = Get(b.rows[down + r] + i);
    for (int c = 0; c < kAcross; ++c) other[c] = Get(b.rows[across + c] + i);
    for (int r = 0; r < kDown; ++r) {
      for (int c = 0; c < kAcross; ++c) tile[r][c] += one[r] * other[c];
    }
  }
  for (int r = 0; r < kDown; ++r) {
    for (int c = 0; c < kAcross; ++c) sums[down + r][across + c] = tile[r][c];
  }
}

void EvaluateTag(Evaluate& e) {
  constexpr int kDown = 4, kAcross = kWidth < 16 ? 2 : 4, kWhole = kRow / kDown * kDown;
  Block b;
  Real sums[kRow][kRow] = {};
  for (int from = 0; from < e.pixels; from += kBlock) {
    const int left = e.pixels - from, pixels = left < kBlock ? left : kBlock;
    const int count = (pixels + 15) / 16 * 16;
    Place(e, from, count, b);
    for (int i = 0; i < count; i += 8) LoadSeen(e.table, b.at + i, i, b);
    for (int i = 0; i < count; i += 4) {
      LoadSides(e.table.sides_u, b.along + i, i, b.sides[0]);
      LoadSides(e.table.sides_v, b.across + i, i, b.sides[1]);
    }
    Rows(e, from, count, b);
    for (int r = 0; r < kRow; ++r) {
      for (int i = pixels; i < count; ++i) b.rows[r][i] = 0;
    }
    for (int r = 0; r < kWhole; r += kDown) {
      for (int c = 0; c < r + kDown; c += kAcross) Tile<kDown, kAcross>(b, count, r, c, sums);
    }
    for (int c = 0; c < kWhole; c += kAcross) Tile<1, kAcross>(b, count, kWhole, c, sums);
    Tile<1, 1>(b, count, kWhole, kWhole, sums);
  }
  for (int r = 0; r < kRow; ++r) {
    for (int c = 0; c <= r; ++c) {
      float sum = 0;
      for (int k = 0; k < kWidth; ++k) sum += sums[r][c][k];
      e.sums[r][c] = sum;
    }
  }
}

}  // namespace

Kernels TENDRIL_FIT_KERNELS() { return {EvaluateTag}; }

}  // namespace tendril::tag_fit
