#pragma once
// Where a bundle adjustment of cameras may begin: a lens from its views of a flat board, and cameras placed
// one after another along shared views (camera 3 may share views with camera 2 only).

#include <vector>

#include "calibrate/cameras/bundle.h"

namespace tendril {

struct BoardPose {
  Eigen::Isometry3d camera_from_board = Eigen::Isometry3d::Identity();
  double rms_px = 0;
};

// Up to two poses of a board that explain a view, the better first; none where it has fewer than 4 corners or
// they lie on a line. Where a view's corners do not lie in a plane (a body with tags on several sides) there
// is one.
//   points  the board's corners   (3, corners)
//   source  Collins and Bartoli, "Infinitesimal plane-based pose estimation", 2014 (OpenCV's IPPE); Terzakis
//   and
//           Lourakis, "A consistently fast and globally optimal solution to the perspective-n-point problem",
//           2020 (OpenCV's SQPNP)
std::vector<BoardPose> PosesOfBoard(const Camera& camera, const Eigen::Matrix3Xd& points,
                                    const BoardCorners& corners);

struct StartedLens {
  Camera camera;
  LensPrior prior;  // about the length found first: 50 % of it, a quarter of the width for the centre, and
                    // what distortion can do at the picture's corner
};

// A lens without distortion, centred in the picture, whose focal length explains the views best among
// lengths from 0.15 to 8 picture widths, and fitted from there with its distortion to the views alone.
//   camera  name, size and kind of distortion
//   errors  kUnreachable  fewer than 3 views with 6 corners or more; none that any focal length explains
Result<StartedLens> StartLens(const Camera& camera, const std::vector<const BoardView*>& views,
                              const Eigen::Matrix3Xd& points);

// Every board that one of the placed cameras saw, where its views' best pose has it.
std::vector<BoardPlace> PlaceBoards(const std::vector<Camera>& cameras,
                                    const std::vector<const BoardView*>& views,
                                    const Eigen::Matrix3Xd& points);

// Places the cameras from camera 0 outward over the pairs whose shared boards agree best, and every board
// that a placed camera saw.
//   cameras  with intrinsics
//   errors   kUnreachable  cameras that never see a board together with camera 0's group: names both groups
struct CameraLink {
  int a = 0;
  int b = 0;
  int moments = 0;  // boards seen by both
};
struct StartedRig {
  Bundle bundle;                  // sigma_px 1
  std::vector<CameraLink> links;  // every pair that shares a board
};
Result<StartedRig> StartRig(std::vector<Camera> cameras, const std::vector<BoardView>& views,
                            const Eigen::Matrix3Xd& points);

}  // namespace tendril
