#pragma once
// How light falls on a scene: a key light from above on the camera's left that casts shadows, a fill light
// from the right, the sky's and the floor's light, dimmed where bodies are close to each other.
//
// Colours are red, green, blue, linear (proportional to light), 1 is white.

#include <Eigen/Core>

#include "analysis/study/scene_raster.h"
#include "analysis/study/scene_view.h"

namespace tendril {

struct SceneLights {
  Eigen::Vector3d toward_key = Eigen::Vector3d::UnitZ(), toward_fill = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d eye = Eigen::Vector3d::Zero();  // m
  SceneView from_key;                             // what the key light sees, from far away
  SceneView from_below;  // through the floor: how high above it things begin, up to its eye's depth below it
};

SceneLights LightsOf(const SceneView& view);

// Share of the key light that reaches the point, 0 .. 1, with a penumbra of a few pixels of `seen_by_key`.
float KeyShare(const SceneLights& lights, const SceneRaster& seen_by_key, const Eigen::Vector3d& point,
               const Eigen::Vector3d& normal);

// Light from a point toward the eye.
//   open  share of the surroundings that is not hidden by bodies close by, 0 .. 1
Eigen::Array3f Shade(const SceneLights& lights, const Eigen::Array3f& color, const Eigen::Vector3d& point,
                     const Eigen::Vector3d& normal, float key_share, float open);

// Between 8-bit sRGB and linear light.
float LinearOf(unsigned char encoded);
unsigned char EncodedOf(float linear);

}  // namespace tendril
