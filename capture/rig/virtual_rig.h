#pragma once
// A good pair of cameras for the virtual rig: where to stand and which image to take so that every tag of a
// gripper can be decoded, flat or coiled.

#include <numbers>
#include <vector>

#include "capture/rig/rig.h"
#include "model/fold/design.h"
#include "model/fold/gripper.h"
#include "model/result.h"

namespace tendril {

struct ViewDirection {
  double azimuth = 0;    // of the camera about z, from the gripper's first tentacle, rad
  double elevation = 0;  // above the tentacles' middle, rad
};

struct VirtualRigOptions {
  // None: a pair chosen by measurement for the number of tentacles (docs/virtual_rig.md, "Where the cameras
  // stand"). One looks up and one looks down, because folded facets face up and down in turn.
  std::vector<ViewDirection> views;
  double distance = 1.8;         // to the tentacles' middle, m
  double pixel_pitch = 0.30e-3;  // at the farthest tentacle, m per px
  double margin_px = 60;         // kept free around everything that the tentacles reach
  double largest_pull = 0.3;     // shapes from flat to here are kept in the image
};

// Cameras named left, right, ... with a Brown distortion and a principal point that is not the image's
// centre. The image is as large as it must be to hold the tentacles at every pull, in multiples of 16 px.
//   errors  kBadInput: the design's; a distance within the gripper's reach; an image beyond 8192 px
Result<Rig> VirtualRig(const TentacleDesign& design, const Gripper& gripper,
                       const VirtualRigOptions& options = {});

}  // namespace tendril
