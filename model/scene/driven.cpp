#include "model/scene/driven.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/geometry/rotation.h"
#include "model/rods/start_shape.h"

namespace tendril {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

// How much of a plain rod's rest curvature there is.
double RampShare(const SceneRod& rod, double time) {
  const double length = rod.ramp_end - rod.ramp_start;
  if (!(length > 0)) return time >= rod.ramp_start ? 1 : 0;
  return std::clamp((time - rod.ramp_start) / length, 0.0, 1.0);
}

void MoveEnd(const EndMotion& motion, double time, Vector3d& position, Vector3d& velocity,
             Eigen::Matrix3d& frame) {
  const double moved = std::clamp(time - motion.from, 0.0, std::max(0.0, motion.until - motion.from));
  const bool moves = time > motion.from && time < motion.until;
  position += moved * motion.velocity;
  velocity = moves ? motion.velocity : Vector3d(Vector3d::Zero());
  frame = frame * ExpSo3(-moved * motion.spin);
}

// A held end goes where the carrier takes it.
void Carry(const CarrierMotion& carrier, Vector3d& position, Vector3d& velocity, Eigen::Matrix3d& frame) {
  const Vector3d from_centre = carrier.turned * position;
  velocity = carrier.velocity + carrier.spin.cross(from_centre) + carrier.turned * velocity;
  position = carrier.offset + from_centre;
  frame = frame * carrier.turned.transpose();
}

Result<Driven> MakeTentacle(const Scene& scene, std::uint64_t trial, int i) {
  const SceneGripper& g = *scene.gripper;
  const Result<TentacleLayout> layout = LayOut(DesignOfTentacle(g.gripper, g.design, i));
  if (!layout.ok()) return layout.error();
  const Eigen::Isometry3d pose = LabFromTentacle(g.gripper, i);
  RodDesign design = TentacleRod(g);
  design.start = pose * Vector3d(0, 0, layout.value().base_z);
  design.direction = pose.linear().col(2);
  design.normal = pose.linear().col(0);
  design.base = FormOf(scene.level) == RodForm::kPaper ? EndHold::kElement : EndHold::kFrame;
  design.tip = EndHold::kFree;
  Result<TentacleActuation> actuation =
      TentacleActuation::Make(g, design.base == EndHold::kFrame, scene.seed, trial, i, scene.phases);
  if (!actuation.ok()) return actuation.error();
  if (const Matrix3Xd* roll = actuation.value().roll()) design.start_curvatures = *roll;
  Result<Rod> rod = MakeRod(design);
  if (!rod.ok()) return rod.error();
  const double azimuth = AzimuthOfTentacle(g.gripper, i);
  Driven driven;
  driven.name = "tentacle" + std::to_string(i);
  driven.rod = std::move(rod).value();
  driven.damping = g.damping;
  driven.outward = {std::cos(azimuth), std::sin(azimuth), 0};
  driven.actuation = std::move(actuation).value();
  return driven;
}

Result<Driven> MakePlain(const Scene& scene, const SceneRod& plain) {
  const bool paper = FormOf(scene.level) == RodForm::kPaper;
  const EndHold held = paper ? EndHold::kElement : EndHold::kFrame;
  RodDesign design = plain.design;
  if (design.base != EndHold::kFree) design.base = held;
  if (design.tip != EndHold::kFree) design.tip = held;
  Result<Rod> made = MakeRod(design);
  if (!made.ok()) return made.error();
  Driven driven;
  driven.name = plain.name;
  driven.rod = std::move(made).value();
  Rod& rod = driven.rod;
  const double turn =
      std::max(plain.rest_curvature.norm(), StrongestStartCurvature(design).norm()) * rod.rest_length[0];
  if (turn > 1.5) {
    return Error{ErrorKind::kBadInput,
                 "elements = " + std::to_string(design.elements) + " turn by " + std::to_string(turn) +
                     " rad each at this curvature: expected " +
                     std::to_string(static_cast<int>(std::ceil(design.elements * turn / 1.5))) + " or more"};
  }
  const Vector3d centre = (rod.position * rod.mass) / rod.mass.sum();
  for (Index i = 0; i < rod.mass.size(); ++i) {
    rod.velocity.col(i) = plain.velocity + plain.spin.cross(Vector3d(rod.position.col(i) - centre));
  }
  for (Index i = 0; i < rod.elements(); ++i) {
    rod.spin.col(i) = rod.directors[static_cast<std::size_t>(i)] * plain.spin;
  }
  const Index last = rod.elements();
  if (rod.base.hold != EndHold::kFree) rod.velocity.col(0).setZero();
  if (rod.base.hold == EndHold::kElement) rod.spin.col(0).setZero();
  if (rod.tip.hold != EndHold::kFree) rod.velocity.col(last).setZero();
  if (rod.tip.hold == EndHold::kElement) rod.spin.col(last - 1).setZero();
  rod.tip_couple = plain.tip_couple;
  driven.damping = plain.damping;
  driven.tip_force = plain.tip_force;
  driven.plain = &plain;
  return driven;
}

}  // namespace

RodForm FormOf(SimulationLevel level) {
  return level == SimulationLevel::kPaper ? RodForm::kPaper : RodForm::kEnergy;
}

Result<std::vector<Driven>> MakeRods(const Scene& scene, std::uint64_t trial) {
  std::vector<Driven> all;
  for (int i = 0; scene.gripper && i < scene.gripper->gripper.tentacles; ++i) {
    Result<Driven> driven = MakeTentacle(scene, trial, i);
    if (!driven.ok()) return driven.error();
    all.push_back(std::move(driven).value());
  }
  for (const SceneRod& plain : scene.rods) {
    Result<Driven> driven = MakePlain(scene, plain);
    if (!driven.ok()) return std::move(driven).error().Within("rod " + plain.name);
    all.push_back(std::move(driven).value());
  }
  std::shared_ptr<const Schedule> carrier;
  if (!scene.phases.empty()) carrier = std::make_shared<const Schedule>(scene.phases);
  if (carrier && !carrier->moves()) carrier.reset();
  for (Driven& driven : all) {
    driven.carrier = carrier;
    const Rod& rod = driven.rod;
    driven.base_start = rod.position.col(0);
    driven.tip_start = rod.position.rightCols<1>();
    // By its element's directors in the published form, by its very end's in ours.
    driven.base_frame = rod.base.hold == EndHold::kElement ? rod.directors.front() : rod.base.frame;
    driven.tip_frame = rod.tip.hold == EndHold::kElement ? rod.directors.back() : rod.tip.frame;
  }
  return all;
}

CarrierGrowth CarrierGrowthAt(const Scene& scene, const std::vector<Driven>& rods, double time) {
  if (!scene.gripper || scene.gripper->shortening != Shortening::kCarrier) return {};
  double pull = 0, rate = 0;
  const double share = 1.0 / scene.gripper->gripper.tentacles;
  for (const Driven& d : rods) {
    if (!d.actuation) continue;
    pull += share * d.actuation->PullAt(time);
    rate += share * d.actuation->PullRateAt(time);
  }
  const double radius = scene.gripper->gripper.carrier_radius;
  return {radius * pull / (1 - pull), radius * rate / ((1 - pull) * (1 - pull))};
}

double LargestCarrierGrowth(const Scene& scene) {
  if (!scene.gripper || scene.gripper->shortening != Shortening::kCarrier) return 0;
  const double pull = StrongestPull(*scene.gripper, scene.phases);
  return scene.gripper->gripper.carrier_radius * pull / (1 - pull);
}

DriveState DriveAt(const Scene& scene, const Driven& driven, const CarrierGrowth& growth, double time) {
  DriveState state;
  state.base_position = driven.base_start + growth.by * driven.outward;
  state.base_velocity = growth.rate * driven.outward;
  state.base_frame = driven.base_frame;
  state.tip_position = driven.tip_start;
  state.tip_velocity.setZero();
  state.tip_frame = driven.tip_frame;
  if (driven.actuation) {
    state.place = driven.actuation->PlaceAt(time);
    if (scene.gripper->shortening == Shortening::kTrue) {
      state.axial_rest_strain = -driven.actuation->PullAt(time);
    }
  } else {
    state.place.share = RampShare(*driven.plain, time);
    MoveEnd(driven.plain->base_motion, time, state.base_position, state.base_velocity, state.base_frame);
    MoveEnd(driven.plain->tip_motion, time, state.tip_position, state.tip_velocity, state.tip_frame);
  }
  if (driven.carrier) {
    const CarrierMotion carrier = driven.carrier->At(time);
    Carry(carrier, state.base_position, state.base_velocity, state.base_frame);
    Carry(carrier, state.tip_position, state.tip_velocity, state.tip_frame);
  }
  return state;
}

std::optional<Ejection> EjectionOf(const Scene& scene, const Driven& driven) {
  if (!driven.actuation || driven.actuation->roll() == nullptr) return std::nullopt;
  const Stow& stow = *scene.gripper->stowed;
  if (!(stow.eject_speed > 0)) return std::nullopt;
  Vector3d away = driven.base_frame.row(2).transpose();
  if (driven.carrier) away = driven.carrier->At(stow.release_time).turned * away;
  const Rod& rod = driven.rod;
  const Matrix3Xd& roll = *driven.actuation->roll();
  Ejection ejection{stow.release_time, Matrix3Xd::Zero(3, rod.elements() + 1)};
  double turned = 0;  // from the base to the node, rad
  for (Index i = 1; i <= rod.elements(); ++i) {
    turned += roll.col(i - 1).norm() * rod.rest_length[i - 1] * (i == 1 ? 0.5 : 1);
    ejection.velocity.col(i) = std::min(1.0, turned / std::numbers::pi) * stow.eject_speed * away;
  }
  return ejection;
}

void ApplyDrive(const DriveState& state, const Driven& driven, Rod& rod) {
  if (driven.actuation) {
    const Matrix3Xd& low = driven.actuation->Entry(state.place.entry);
    const Matrix3Xd& high = driven.actuation->Entry(state.place.entry + 1);
    const Index inner = rod.rest_curvature.cols();
    rod.rest_curvature = low.rightCols(inner) + state.place.share * (high - low).rightCols(inner);
    rod.base.rest_curvature = low.col(0) + state.place.share * (high - low).col(0);
  } else {
    const Vector3d curvature = state.place.share * driven.plain->rest_curvature;
    rod.rest_curvature.colwise() = curvature;
    rod.base.rest_curvature = rod.tip.rest_curvature = curvature;
  }
  rod.rest_strain.row(2).setConstant(state.axial_rest_strain);
  if (rod.base.hold != EndHold::kFree) {
    rod.position.col(0) = state.base_position;
    rod.velocity.col(0) = state.base_velocity;
  }
  if (rod.tip.hold != EndHold::kFree) {
    rod.position.rightCols<1>() = state.tip_position;
    rod.velocity.rightCols<1>() = state.tip_velocity;
  }
  rod.base.frame = state.base_frame;
  rod.tip.frame = state.tip_frame;
  if (rod.base.hold == EndHold::kElement) rod.directors.front() = state.base_frame;
  if (rod.tip.hold == EndHold::kElement) rod.directors.back() = state.tip_frame;
}

}  // namespace tendril
