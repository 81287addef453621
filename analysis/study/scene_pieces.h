#pragma once
// Tubes, objects and wires as pieces that a ray can be cast at: cones between two nodes, balls, flat round
// ends and flat faces.
//
// SI units, lab frame. Where a tube bends gently its cones are cut along the plane that halves the bend, so
// that they meet without overlapping; at ends and sharp bends they end round.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "analysis/study/scene_view.h"
#include "model/objects/shape.h"

namespace tendril {

struct ShownObject;
struct Tube;
struct Wire;

struct ScenePiece {
  // From a to b; about a; about a, facing along tangent_a; a rectangle about a that faces along tangent_a: b
  // is the middle of an edge, which reaches radius_a either way from it.
  enum class Kind { kCone, kBall, kDisc, kFace };

  Kind kind = Kind::kBall;
  int body = 0;                                                              // which tube or object
  Eigen::Vector3d a = Eigen::Vector3d::Zero(), b = Eigen::Vector3d::Zero();  // m
  double radius_a = 0, radius_b = 0;                                         // m
  Eigen::Vector3d tangent_a = Eigen::Vector3d::UnitZ(), tangent_b = Eigen::Vector3d::UnitZ();
  bool cut_a = false,
       cut_b = false;  // ends in the plane across the tangent; else where the ball there begins
  double overlap = 0;  // how far a cut end goes beyond its plane, so that no ray slips between two cones, m
};

// False for a node that is not finite or that a run that went wrong threw farther than 10 000 km away.
bool CanBeDrawn(const Eigen::Vector3d& point);

// Appends the pieces of one body. Radii are enlarged to `least_px` half a width in the view; where a tube's
// outline would show corners between its nodes, it is rounded through them.
void AddTube(const Tube& tube, int body, const SceneView& view, double least_px,
             std::vector<ScenePiece>& pieces);
void AddWire(const Wire& wire, int body, const SceneView& view, double least_px,
             std::vector<ScenePiece>& pieces);
// Without half spaces that are the floor.
void AddObject(const ShownObject& object, int body, const SceneView& view, double least_px,
               std::vector<ScenePiece>& pieces);

// Whether it is a half space that faces up.
bool IsFloor(const Primitive& primitive, const Eigen::Isometry3d& lab_from_object);

// The outward unit normal where a ray met the piece, smooth along a tube.
Eigen::Vector3d NormalAt(const ScenePiece& piece, const Eigen::Vector3d& point);

}  // namespace tendril
