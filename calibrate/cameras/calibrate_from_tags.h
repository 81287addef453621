#pragma once
// A rig from the tags that its cameras saw, where the lenses are known, if roughly: recorded detections
// instead of pictures of a board.
//
// Lab frame: camera 0's. Scale comes from the tags' stated size.

#include "calibrate/cameras/calibrate_cameras.h"
#include "calibrate/cameras/tag_views.h"

namespace tendril {

struct CalibrateFromTagsOptions {
  double border = 0;       // side of the tags' black border, m
  bool tags_move = false;  // against each other, as on a tentacle; else they are fixed to each other somehow
  // Cameras that are not triggered together: pictures whose tags move more px than this from picture to
  // picture tell about lenses only (UnlinkMoving); 0: they are.
  double still_px = 0;
  CalibrateCamerasOptions
      cameras;  // its lenses are not used; corners of fixed tags are corrected by board_sigma
};

struct RigFromTags {
  CameraCalibration calibration;
  std::vector<BoardView> views;  // that it was fitted to
  TagBody body;                  // of fixed tags, with their corrections; empty: tags_move
};

//   lenses  names, sizes and lenses, which stay unless cameras.refine_lenses
//   errors  as FindTagBody and CalibrateCameras
Result<RigFromTags> CalibrateFromTags(std::vector<Camera> lenses, std::span<const TagInPicture> tags,
                                      const CalibrateFromTagsOptions& options, const Progress& progress = {});

}  // namespace tendril
