#include "analysis/study/scene_openness.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace tendril {
namespace {

constexpr int kRays = 14;  // per pixel
constexpr int kTile = 4;   // pixels whose rays are turned against each other, and then averaged
constexpr float kNone = std::numeric_limits<float>::infinity();

void ReadHits(const std::vector<ScenePiece>& pieces, const SceneRaster& raster, int factor,
              const SceneView& view, ScenePixels& pixels) {
  const SceneView fine = Magnified(view, factor);
  const Eigen::Isometry3d lab_from_camera = view.camera_from_lab.inverse();
  for (int y = 0; y < pixels.height; ++y) {
    for (int x = 0; x < pixels.width; ++x) {
      for (int ray = 0; ray < factor * factor; ++ray) {
        const int ray_x = (x + pixels.left) * factor + ray % factor;
        const int ray_y = (y + pixels.top) * factor + ray / factor;
        if (!raster.Holds(ray_x, ray_y)) continue;
        const std::size_t hit = raster.At(ray_x, ray_y);
        if (raster.piece[hit] < 0) continue;
        const double depth = raster.depth[hit];
        const Eigen::Vector3d point((ray_x - fine.center_x_px) / fine.focal_px * depth,
                                    (ray_y - fine.center_y_px) / fine.focal_px * depth, depth);
        const Eigen::Vector3d normal =
            NormalAt(pieces[static_cast<std::size_t>(raster.piece[hit])], lab_from_camera * point);
        const std::size_t here = pixels.At(x, y);
        pixels.depth[here] = raster.depth[hit];
        pixels.points[here] = point.cast<float>();
        pixels.normals[here] = (view.camera_from_lab.linear() * normal).cast<float>();
        break;
      }
    }
  }
}

// Offsets on a spiral, as shares of the range; one turn of the spiral per place in the tile.
using Spiral = std::array<Eigen::Vector2f, kRays>;
std::array<Spiral, kTile * kTile> Spirals() {
  std::array<Spiral, kTile * kTile> spirals;
  for (std::size_t turn = 0; turn < spirals.size(); ++turn) {
    for (std::size_t k = 0; k < kRays; ++k) {
      const double share =
          (static_cast<double>(k) + 0.5 + static_cast<double>(turn * 7 % 16) / 16) / (kRays + 1);
      const double angle = 2 * std::numbers::pi * (3.0 * share + static_cast<double>(turn * 5 % 16) / 16);
      spirals[turn][k] = (share * Eigen::Vector2d(std::cos(angle), std::sin(angle))).cast<float>();
    }
  }
  return spirals;
}

float OpenShareOf(const ScenePixels& pixels, int x, int y, const Spiral& spiral, float wide_px, float range) {
  const std::size_t here = pixels.At(x, y);
  const Eigen::Vector3f point = pixels.points[here];
  const Eigen::Vector3f normal = pixels.normals[here];
  float hidden = 0;
  for (const Eigen::Vector2f& offset : spiral) {
    // Rounded; the cast cuts toward zero, so it is done above zero.
    constexpr int kAbove = 1024;
    const int sx = x + static_cast<int>(wide_px * offset.x() + (kAbove + 0.5F)) - kAbove;
    const int sy = y + static_cast<int>(wide_px * offset.y() + (kAbove + 0.5F)) - kAbove;
    if (sx < 0 || sy < 0 || sx >= pixels.width || sy >= pixels.height) continue;
    const std::size_t there = pixels.At(sx, sy);
    if (pixels.depth[there] == kNone) continue;
    const Eigen::Vector3f way = pixels.points[there] - point;
    const float squared = way.squaredNorm();
    const float rise = way.dot(normal) - 0.02F * range;
    if (rise <= 0 || squared >= range * range) continue;
    hidden += (1 - squared / (range * range)) * rise / std::sqrt(squared);
  }
  return std::max(0.0F, 1 - 2.1F * hidden / kRays);
}

}  // namespace

void MeasurePixels(const std::vector<ScenePiece>& pieces, const SceneRaster& raster, int factor,
                   const SceneView& view, double range, ScenePixels& pixels) {
  pixels.left = raster.left / factor;
  pixels.top = raster.top / factor;
  pixels.width = (raster.right + factor - 1) / factor - pixels.left;
  pixels.height = (raster.bottom + factor - 1) / factor - pixels.top;
  const auto size = static_cast<std::size_t>(pixels.width) * static_cast<std::size_t>(pixels.height);
  pixels.depth.assign(size, kNone);
  pixels.points.resize(size);
  pixels.normals.resize(size);
  pixels.open.assign(size, 1.0F);
  ReadHits(pieces, raster, factor, view, pixels);

  static const std::array<Spiral, kTile* kTile> spirals = Spirals();
  const auto reach = static_cast<float>(range);
  std::vector<float> raw(size, 1.0F);
  for (int y = 0; y < pixels.height; ++y) {
    for (int x = 0; x < pixels.width; ++x) {
      const std::size_t here = pixels.At(x, y);
      if (pixels.depth[here] == kNone) continue;
      const float wide = std::min(120.0F, static_cast<float>(view.focal_px) * reach / pixels.depth[here]);
      raw[here] = OpenShareOf(
          pixels, x, y,
          spirals[static_cast<std::size_t>(y % kTile) * kTile + static_cast<std::size_t>(x % kTile)], wide,
          reach);
    }
  }
  for (int y = 0; y < pixels.height; ++y) {
    for (int x = 0; x < pixels.width; ++x) {
      const std::size_t here = pixels.At(x, y);
      if (pixels.depth[here] == kNone) continue;
      float sum = 0, count = 0;
      for (int j = std::max(0, y - kTile / 2); j < std::min(pixels.height, y + kTile / 2); ++j) {
        for (int i = std::max(0, x - kTile / 2); i < std::min(pixels.width, x + kTile / 2); ++i) {
          const std::size_t there = pixels.At(i, j);
          if (!(std::abs(pixels.depth[there] - pixels.depth[here]) < 0.2F * reach)) continue;
          sum += raw[there];
          count += 1;
        }
      }
      pixels.open[here] = count > 0 ? sum / count : raw[here];
    }
  }
}

}  // namespace tendril
