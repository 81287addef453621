#pragma once
// A simulated scene as a film or a picture: rods and objects over time, strings, the carrier, and what is
// told of each frame.

#include <Eigen/Core>
#include <Eigen/Geometry>
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
  std::vector<CurveSeries> curves = {};                    // a rod each, all at the times of the first
  std::vector<Eigen::VectorXd> radius = {};                // of each rod at its nodes, m
  std::vector<SceneObject> objects = {};                   // each where it starts, unless it has poses below
  std::vector<std::vector<Eigen::Isometry3d>> poses = {};  // of each object at each frame, lab_from_object
  // Of each frame; none at all: without.
  std::vector<Eigen::Matrix3Xd> carrier = {};        // the line that tentacles hang from, m
  std::vector<std::string> phases = {};              // what is being done
  std::vector<std::vector<std::string>> lines = {};  // words below that
};

// Radii at nodes from those of the elements between them, as a rod has them (N+1 from N; none from none).
Eigen::VectorXd RadiusAtNodes(const Eigen::VectorXd& radius_of_elements);

// Writes the film, 1280 x 720 px, from one direction and an eye that slowly follows what happens, so that all
// of a frame is always in view. It runs in the
// scene's time; where there are more than 60 frames a second, slower, and says so. Frames are drawn on up
// to 8 threads; the bytes do not depend on how many. Written beside the target and renamed.
//   file    .mp4
//   errors  kBadInput  another extension, no frames, numbers of frames, nodes, radii, poses or words that
//   differ
//           kIo        no encoder, the disk
//           kStopped   (no file is left half-made)
Status WriteSceneVideo(const SceneFilm& film, const std::filesystem::path& file,
                       const Progress& progress = {});

// Writes the last frame, 1600 x 1000 px, from as near as it can be seen whole.
//   file    .png
//   errors  as WriteSceneVideo
Status WriteScenePicture(const SceneFilm& film, const std::filesystem::path& file);

}  // namespace tendril::cli
