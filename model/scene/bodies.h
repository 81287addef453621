#pragma once
// The objects of a scene as they move between kicks and under them: weight, strings, loads, each other.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <vector>

#include "model/objects/object_drag.h"
#include "model/objects/rigid_body.h"
#include "model/rods/solid.h"
#include "model/rods/solid_contact.h"
#include "model/scene/scene.h"

namespace tendril {

class Bodies {
 public:
  //   time_step  s; the state is then in the middle of the first
  Bodies(const Scene& scene, double time_step);

  // As they are now; one for each object of the scene.
  const std::vector<Solid>& solids() const { return solids_; }
  bool AnyMoves() const { return moves_; }
  // Kick by these loads (of rods) and all else at a time, then a drift of a step.
  void Step(double time, std::span<const Wrench> loads);

  // Poses at a time from now, lab_from_object: exact where the scheme is.
  std::vector<Eigen::Isometry3d> PosesAt(double from_now) const;
  const RigidBody& body(std::size_t object) const { return bodies_[object]; }
  // The first that is not finite.
  std::optional<std::size_t> NotFinite() const;

  std::vector<double> Save() const;
  bool Restore(std::span<const double> saved);

 private:
  void Refresh();
  Wrench LoadsOn(std::size_t b) const;

  const Scene& scene_;
  double time_step_;
  bool moves_ = false;
  std::vector<RigidBody> bodies_;
  std::vector<ObjectDrag> drags_;  // in a medium
  std::vector<Solid> solids_;
  std::vector<Wrench> loads_;
  SolidContact contact_;
};

}  // namespace tendril
