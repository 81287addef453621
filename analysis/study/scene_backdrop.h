#pragma once
// What is behind a scene: a pale room whose floor has a grid and catches the shadow of what is above it.

#include <opencv2/core/mat.hpp>

#include "analysis/study/scene_light.h"
#include "analysis/study/scene_raster.h"
#include "analysis/study/scene_view.h"

namespace tendril {

struct Backdrop {
  cv::Mat color;         // CV_8UC3, blue, green, red
  cv::Mat floor;         // CV_8UC1, how much of a shadow falls on the floor here: 255 all, 0 none
  double grid_step = 0;  // between the floor's lines, m: 1, 2 or 5 times a power of ten
};

Backdrop PaintBackdrop(const SceneView& view);

// The backdrop's colours with the shadow of what the key light sees and, on a table, a darker ground close to
// what stands on it.
cv::Mat WithShadow(const Backdrop& backdrop, const SceneView& view, const SceneLights& lights,
                   const SceneRaster& seen_by_key, const SceneRaster& seen_from_below);

// The largest of 1, 2 and 5 times a power of ten that is at most `length` (> 0).
double RoundLength(double length);

}  // namespace tendril
