#include "model/scene/bodies.h"

#include <cmath>

namespace tendril {
namespace {

using Eigen::Vector3d;

std::vector<double> MassesOf(const Scene& scene) {
  std::vector<double> masses;
  for (const SceneObject& object : scene.objects) {
    masses.push_back(object.motion == ObjectMotion::kFixed ? 0 : object.mass);
  }
  return masses;
}

std::vector<Solid> SolidsOf(const Scene& scene) {
  std::vector<Solid> solids;
  for (const SceneObject& object : scene.objects) {
    Solid solid;
    solid.shape = object.shape;
    solid.pose = object.pose;
    if (object.friction) solid.friction = solid.static_friction = *object.friction;
    if (object.motion != ObjectMotion::kFixed) {
      solid.velocity = object.velocity;
      solid.spin = object.spin;
    }
    solids.push_back(solid);
  }
  return solids;
}

}  // namespace

Bodies::Bodies(const Scene& scene, double time_step)
    : scene_(scene),
      time_step_(time_step),
      solids_(SolidsOf(scene)),
      loads_(scene.objects.size()),
      contact_(scene.contact, solids_, MassesOf(scene)) {
  for (const SceneObject& object : scene.objects) {
    RigidBody body;
    body.position = object.pose.translation();
    body.lab_from_body = Eigen::Quaterniond(object.pose.linear());
    if (object.motion != ObjectMotion::kFixed) {
      moves_ = true;
      body.inertia = object.inertia;
      body.velocity = object.velocity;
      body.angular_momentum_in_body =
          object.inertia.cwiseProduct(object.pose.linear().transpose() * object.spin);
      DriftBody(body, 0.5 * time_step);
    }
    ObjectDrag drag;
    double added = 0;
    if (object.motion != ObjectMotion::kFixed && scene.medium.density > 0) {
      drag = DragOf(object.shape).value();
      for (DragPart& part : drag.parts) {
        part.area *= object.drag_scale;
        part.turning *= object.drag_scale;
      }
      // One figure for all directions.
      added = AddedMass(drag, scene.medium).trace() / 3;
    }
    body.mass = object.mass + added;
    bodies_.push_back(body);
    drags_.push_back(std::move(drag));
  }
  Refresh();
}

// But for contact's: weight, and what the medium does.
Wrench Bodies::LoadsOn(std::size_t b) const {
  Wrench wrench{scene_.objects[b].mass * scene_.gravity, Vector3d::Zero()};
  if (!(scene_.medium.density > 0)) return wrench;
  const BodyLoad load = ForceOnBody(drags_[b], bodies_[b], scene_.medium, scene_.gravity, time_step_);
  wrench.force += load.force;
  wrench.torque += load.torque;
  return wrench;
}

void Bodies::Refresh() {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (scene_.objects[b].motion == ObjectMotion::kFixed) continue;
    solids_[b].pose = bodies_[b].Pose();
    solids_[b].velocity = bodies_[b].velocity;
    solids_[b].spin = bodies_[b].Spin();
  }
}

void Bodies::Step(double time, std::span<const Wrench> loads) {
  if (!moves_) return;
  std::copy(loads.begin(), loads.end(), loads_.begin());
  for (const Push& push : scene_.pushes) loads_[push.object].force += ForceAt(push, time);
  if (contact_.CanTouch()) contact_.Add(solids_, time_step_, loads_);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const SceneObject& object = scene_.objects[b];
    if (object.motion == ObjectMotion::kFixed) continue;
    const Wrench own = LoadsOn(b);
    const Vector3d force = loads_[b].force + own.force, torque = loads_[b].torque + own.torque;
    if (object.motion == ObjectMotion::kHanging) {
      KickOnString(bodies_[b], object.string, time_step_, force, torque);
    } else {
      KickBody(bodies_[b], time_step_, force, torque);
    }
    DriftBody(bodies_[b], time_step_);
  }
  Refresh();
}

std::vector<Eigen::Isometry3d> Bodies::PosesAt(double from_now) const {
  std::vector<Eigen::Isometry3d> poses;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    RigidBody body = bodies_[b];
    if (scene_.objects[b].motion != ObjectMotion::kFixed) DriftBody(body, from_now);
    poses.push_back(body.Pose());
  }
  return poses;
}

std::optional<std::size_t> Bodies::NotFinite() const {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const RigidBody& body = bodies_[b];
    if (!std::isfinite(body.position.sum() + body.velocity.sum() + body.angular_momentum_in_body.sum())) {
      return b;
    }
  }
  return std::nullopt;
}

std::vector<double> Bodies::Save() const {
  std::vector<double> saved;
  for (const RigidBody& body : bodies_) {
    const Eigen::Vector4d turn = body.lab_from_body.coeffs();
    saved.insert(saved.end(), body.position.begin(), body.position.end());
    saved.insert(saved.end(), turn.begin(), turn.end());
    saved.insert(saved.end(), body.velocity.begin(), body.velocity.end());
    saved.insert(saved.end(), body.angular_momentum_in_body.begin(), body.angular_momentum_in_body.end());
  }
  const std::vector<double> sticks = contact_.Save();
  saved.insert(saved.end(), sticks.begin(), sticks.end());
  return saved;
}

bool Bodies::Restore(std::span<const double> saved) {
  const std::size_t own = 13 * bodies_.size();
  if (saved.size() < own || !contact_.Restore(saved.subspan(own))) return false;
  const double* from = saved.data();
  for (RigidBody& body : bodies_) {
    body.position = Eigen::Map<const Vector3d>(from);
    body.lab_from_body.coeffs() = Eigen::Map<const Eigen::Vector4d>(from + 3);
    body.velocity = Eigen::Map<const Vector3d>(from + 7);
    body.angular_momentum_in_body = Eigen::Map<const Vector3d>(from + 10);
    from += 13;
  }
  Refresh();
  return true;
}

}  // namespace tendril
