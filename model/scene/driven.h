#pragma once
// The rods of a scene as they start, and what drives each at a time: pull, ramp, motion of held ends, loads.

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "model/result.h"
#include "model/rods/rod_plain.h"
#include "model/scene/actuation.h"
#include "model/scene/scene.h"
#include "model/scene/schedule.h"

namespace tendril {

// A rod of the scene and what drives it.
struct Driven {
  std::string name;
  Rod rod;
  double damping = 0;                                        // 1/s
  Eigen::Vector3d tip_force = Eigen::Vector3d::Zero();       // N
  Eigen::Vector3d base_start = Eigen::Vector3d::Zero();      // node 0 at time 0
  Eigen::Vector3d tip_start = Eigen::Vector3d::Zero();       // node N at time 0
  Eigen::Matrix3d base_frame = Eigen::Matrix3d::Identity();  // directors held there at time 0
  Eigen::Matrix3d tip_frame = Eigen::Matrix3d::Identity();
  // By which node 0 moves per metre of the carrier's radius.
  Eigen::Vector3d outward = Eigen::Vector3d::Zero();
  const SceneRod* plain = nullptr;
  std::optional<TentacleActuation> actuation;
  std::shared_ptr<const Schedule> carrier;  // shared by all rods; null where it stands still
};

RodForm FormOf(SimulationLevel level);

// Refers to the scene's plain rods.
//   trial   counts in the random draws
//   errors  as MakeRod, LayOut, SolveFold
Result<std::vector<Driven>> MakeRods(const Scene& scene, std::uint64_t trial);

// How much the carrier's radius has grown at a time, m, and grows, m/s.
struct CarrierGrowth {
  double by = 0, rate = 0;
};
CarrierGrowth CarrierGrowthAt(const Scene& scene, const std::vector<Driven>& rods, double time);
// The most that it ever has, m; 0 where it does not.
double LargestCarrierGrowth(const Scene& scene);

// What a rod's drive says of a time.
struct DriveState {
  TentacleActuation::Place place;  // share: of a plain rod's rest curvature
  double axial_rest_strain = 0;    // sigma^0 along d3
  Eigen::Vector3d base_position, base_velocity, tip_position, tip_velocity;  // lab; of held ends
  Eigen::Matrix3d base_frame, tip_frame;
};
//   growth  of the carrier at that time
DriveState DriveAt(const Scene& scene, const Driven& driven, const CarrierGrowth& growth, double time);

// What the springs under a rolled-up tentacle give its nodes, once: a push at the release, along the way in
// which the tentacle leaves the carrier. Over the first half turn from the base it grows from 0.
struct Ejection {
  double time = 0;            // s
  Eigen::Matrix3Xd velocity;  // to be added, m/s                                          (3, N+1)
};
std::optional<Ejection> EjectionOf(const Scene& scene, const Driven& driven);

// Puts it into the rod: positions, velocities and frames of held ends, rest curvature and strain.
void ApplyDrive(const DriveState& state, const Driven& driven, Rod& rod);

}  // namespace tendril
