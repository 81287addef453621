#pragma once
// What a simulation is told: rods, a gripper made of them, objects, what is around them, how they touch, and
// what is done one after the other.
// Read from a scene file by db/files/scene_toml.h; SI units, lab frame, angles in radians.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "model/fold/design.h"
#include "model/fold/gripper.h"
#include "model/fold/rest_curvature.h"
#include "model/objects/rigid_body.h"
#include "model/objects/shape.h"
#include "model/rods/contact.h"
#include "model/rods/medium.h"
#include "model/rods/rod.h"
#include "model/scene/push.h"

namespace tendril {

enum class SimulationLevel {
  kPaper,     // the published form at 20 us
  kStandard,  // loads that are an energy's gradient, at a share of the stable step
  kFast,      // as standard, heavier against acceleration where damping rules, for longer steps
  kStatic,    // equilibria without contact, one after the other as the drives change
};

// A held end moves from one time to another; its spin turns the frame that is held, about the end itself.
struct EndMotion {
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // m/s
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();      // rad/s, lab
  double from = 0, until = 0;                          // s
};

// A plain rod, for mechanics.
struct SceneRod {
  std::string name;
  RodDesign design;  // of its ends counts whether they are held; the level says how
  Eigen::Vector3d rest_curvature = Eigen::Vector3d::Zero();  // 1/m, reached at the ramp's end
  double ramp_start = 0, ramp_end = 0;                       // s
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();        // of all nodes at the start, m/s
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();            // about the centre of mass at the start, rad/s
  double damping = 0;                                        // 1/s
  Eigen::Vector3d tip_force = Eigen::Vector3d::Zero();       // N
  Eigen::Vector3d tip_couple = Eigen::Vector3d::Zero();      // N m, in the last element's axes
  EndMotion base_motion, tip_motion;                         // of ends that are held
  Wetted wetted;
};

enum class Shortening {
  kCarrier,  // rods keep their length, the carrier's radius grows as 1 / (1 - mean pull), as in the paper
  kTrue,     // rest lengths follow the pull
};

// Tentacles that start rolled up, each from its tip in a plane spiral on the carrier's outer side.
struct Stow {
  double inner_radius = 0;   // of the innermost turn's axis, m; 0: by the turns
  double turns = 0;          // 0: by the inner radius
  double gap = 0.001;        // between neighbouring layers, m
  double release_time = 0;   // until then the rest curvature holds the roll, s
  double unroll_time = 0.5;  // in which the rest curvature then goes to none; pulling waits for it, s
  double eject_speed = 0;    // that the release gives the roll, away from the carrier, m/s
};

struct SceneGripper {
  std::string design_name;
  TentacleDesign design;
  Gripper gripper;
  CurvatureMap curvature_map = CurvatureMap::kTurning;
  double pull = 0.3;                       // reached by every tentacle
  double pull_rate = 0.03;                 // 1/s
  double delay_low = 0, delay_high = 0.5;  // s, uniform between
  double rate_perturbation = 0.001875;     // 1/s, uniform between minus and plus
  Shortening shortening = Shortening::kCarrier;
  RodDesign rod;       // base_radius, moduli, density and elements count; the rest follows from the design
  double damping = 0;  // 1/s
  Wetted wetted;
  std::optional<Stow> stowed;
};

enum class ObjectMotion { kFixed, kFree, kHanging };

struct SceneObject {
  std::string kind = "cylinder";  // cylinder, capsule, sphere, box, union, table
  // What the published contact laws and the picture take a cylinder (its ends round), a capsule or a sphere
  // for; of other kinds a point without size.
  FixedBody body;
  std::string name;
  Shape shape;  // in the object's own frame (model/objects/shape.h, Balanced); a table's surface is its z = 0
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  // lab_from_object at the start
  ObjectMotion motion = ObjectMotion::kFixed;
  double mass = 0;                                     // kg; fixed: may be 0
  Eigen::Vector3d inertia = Eigen::Vector3d::Zero();   // principal, kg m^2; fixed: may be 0
  std::optional<double> friction;                      // against rods and objects; else the contact's
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // of the centre of mass at the start, lab, m/s
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();      // at the start, lab, rad/s
  BodyString string;                                   // where it hangs
  double drag_scale = 1;  // its drag in a medium over that of its shape (model/objects/object_drag.h)
};

// What is done for a time (model/scene/schedule.h).
struct Phase {
  std::string name;
  double duration = 1;  // s
  // Where every tentacle is pulled to from the phase's start on; else to where it was on the way before.
  std::optional<double> pull{};
  double pull_rate = 0;  // 1/s; 0: the gripper's
  // Of the carrier and of plain rods' held ends, as one: a way and a turn about the carrier's centre, both
  // smooth.
  Eigen::Vector3d move = Eigen::Vector3d::Zero();        // m, lab
  double turn = 0;                                       // rad
  Eigen::Vector3d turn_axis = Eigen::Vector3d::UnitZ();  // lab; any length
  // Back and forth, faded in and out.
  Eigen::Vector3d shake_amplitude = Eigen::Vector3d::Zero();  // m
  double shake_frequency = 0;                                 // Hz
};

struct Scene {
  std::string name;
  double duration = 10;  // s
  std::uint64_t seed = 1;
  SimulationLevel level = SimulationLevel::kStandard;
  double time_step = 0;  // s; 0: the level's
  Eigen::Vector3d gravity = Eigen::Vector3d(0, 0, -9.80665);
  std::optional<SceneGripper> gripper;
  std::vector<SceneObject> objects;
  std::vector<Push> pushes;
  Contact contact;
  std::vector<SceneRod> rods;
  Medium medium;
  // One after the other, `duration` in all; none: the gripper pulls as it says. AddPhase keeps the two
  // together.
  std::vector<Phase> phases;
};

}  // namespace tendril
