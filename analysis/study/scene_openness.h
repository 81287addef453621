#pragma once
// How open the surroundings of each visible point are: corners between bodies are darker than free surfaces.
//
// Measured on what the camera sees, so a body that is hidden from it darkens nothing.

#include <Eigen/Core>
#include <vector>

#include "analysis/study/scene_raster.h"

namespace tendril {

// What the pixels of a picture show, by the first of their rays that hits, for the part of the picture in
// which the raster holds anything; row by row.
struct ScenePixels {
  int left = 0, top = 0, width = 0, height = 0;  // px
  std::vector<float> depth;                      // m; infinite: no ray hits
  std::vector<Eigen::Vector3f> points;           // m, in camera axes
  std::vector<Eigen::Vector3f> normals;          // in camera axes
  std::vector<float> open;                       // share of the surroundings that is open, 0 .. 1

  std::size_t At(int x, int y) const {  // from (left, top)
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
};

// Reads pixels of factor x factor rays off the raster, and measures how open each is: how far bodies within
// `range` (m) rise above its tangent plane. Rewrites `pixels`, whose memory is used again.
void MeasurePixels(const std::vector<ScenePiece>& pieces, const SceneRaster& raster, int factor,
                   const SceneView& view, double range, ScenePixels& pixels);

}  // namespace tendril
