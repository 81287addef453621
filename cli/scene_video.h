#pragma once
// A simulated scene as a film or a picture: rods over time, the fixed objects, and what is told of each
// frame.

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "model/geometry/framed_curve.h"
#include "model/progress.h"
#include "model/result.h"
#include "model/scene/scene.h"

namespace tendril::cli {

struct SceneFilm {
  std::string name = {};
  std::vector<CurveSeries> curves = {};      // a rod each, all at the times of the first
  std::vector<Eigen::VectorXd> radius = {};  // of each rod at its nodes, m
  std::vector<SceneObject> objects = {};     // cylinders are drawn as what they are to the rods: capsules
  std::vector<std::vector<std::string>> lines = {};  // words below the time, a list per frame; none: no words
};

// Radii at nodes from those of the elements between them, as a rod has them (N+1 from N; none from none).
Eigen::VectorXd RadiusAtNodes(const Eigen::VectorXd& radius_of_elements);

// Writes the film, 1280 x 720 px, from one place from which everything is always in view. It runs in the
// scene's time; where there are more than 60 frames a second, slower, and says so. Frames are drawn on up
// to 8 threads; the bytes do not depend on how many. Written beside the target and renamed.
//   file    .mp4
//   errors  kBadInput  another extension, no frames, numbers of frames, nodes, radii or lines that differ
//           kIo        no encoder, the disk
//           kStopped   (no file is left half-made)
Status WriteSceneVideo(const SceneFilm& film, const std::filesystem::path& file,
                       const Progress& progress = {});

// Writes the last frame, 1600 x 1000 px, from as near as it can be seen whole.
//   file    .png
//   errors  as WriteSceneVideo
Status WriteScenePicture(const SceneFilm& film, const std::filesystem::path& file);

}  // namespace tendril::cli
