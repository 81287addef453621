#pragma once
// Which piece a ray through each pixel meets first, and how far away.

#include <cstdint>
#include <vector>

#include "analysis/study/scene_pieces.h"
#include "analysis/study/scene_view.h"

namespace tendril {

// Only the pixels in [left, right) x [top, bottom) hold anything; the rest of the picture is empty.
struct SceneRaster {
  int left = 0, right = 0, top = 0, bottom = 0;  // px
  std::vector<float> depth;                      // m, row by row of that part; infinite: nothing
  std::vector<std::int32_t> piece;               // number of the piece; -1: nothing

  std::size_t At(int x, int y) const {
    return static_cast<std::size_t>(y - top) * static_cast<std::size_t>(right - left) +
           static_cast<std::size_t>(x - left);
  }
  bool Holds(int x, int y) const { return x >= left && x < right && y >= top && y < bottom; }
};

// Casts a ray per pixel and keeps the nearest piece. Pieces that are not
// wholly before the camera are left out. Rewrites `raster`, whose memory is used again.
void CastRays(const std::vector<ScenePiece>& pieces, const SceneView& view, SceneRaster& raster);

}  // namespace tendril
