#include "model/scene/stepper.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <span>

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

// Base, rest curvature and rest strain of that moment.
void Drive(const Scene& scene, Driven& d, double growth, double time) {
  Rod& rod = d.rod;
  if (d.actuation) {
    const double pull = d.actuation->PullAt(time);
    d.actuation->RestCurvature(pull, rod.rest_curvature);
    if (scene.gripper->shortening == Shortening::kTrue) rod.rest_strain.row(2).setConstant(-pull);
    rod.position.col(0) = d.start + growth * d.outward;
  } else if (d.plain != nullptr) {
    rod.rest_curvature.colwise() = RampShare(*d.plain, time) * d.plain->rest_curvature;
  }
}

}  // namespace

std::string ShortNumber(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::general, 6);
  return {text, end.ptr};
}

Result<std::vector<Driven>> MakeRods(const Scene& scene, std::uint64_t trial) {
  std::vector<Driven> all;
  if (scene.gripper) {
    const SceneGripper& g = *scene.gripper;
    for (int i = 0; i < g.gripper.tentacles; ++i) {
      const Result<TentacleLayout> layout = LayOut(DesignOfTentacle(g.gripper, g.design, i));
      if (!layout.ok()) return layout.error();
      const Eigen::Isometry3d pose = LabFromTentacle(g.gripper, i);
      RodDesign design = g.rod;
      design.length = g.design.length;
      design.taper = g.design.taper;
      design.start = pose * Vector3d(0, 0, layout.value().base_z);
      design.direction = pose.linear().col(2);
      design.normal = pose.linear().col(0);
      design.clamped = true;
      Result<Rod> rod = MakeRod(design);
      if (!rod.ok()) return rod.error();
      Result<TentacleActuation> actuation = TentacleActuation::Make(g, scene.seed, trial, i);
      if (!actuation.ok()) return actuation.error();
      const double azimuth = g.gripper.first_azimuth + 2 * std::numbers::pi * i / g.gripper.tentacles;
      all.push_back({"tentacle" + std::to_string(i), std::move(rod).value(), g.damping, Vector3d::Zero(),
                     design.start, Vector3d(std::cos(azimuth), std::sin(azimuth), 0), nullptr,
                     std::move(actuation).value()});
    }
  }
  for (const SceneRod& plain : scene.rods) {
    Result<Rod> made = MakeRod(plain.design);
    if (!made.ok()) return made.error();
    Rod rod = std::move(made).value();
    const Vector3d centre = (rod.position * rod.mass) / rod.mass.sum();
    for (Index i = 0; i < rod.mass.size(); ++i) {
      if (rod.clamped && i == 0) continue;
      rod.velocity.col(i) = plain.velocity + plain.spin.cross(Vector3d(rod.position.col(i) - centre));
    }
    for (Index i = rod.clamped ? 1 : 0; i < rod.elements(); ++i) {
      rod.spin.col(i) = rod.directors[static_cast<std::size_t>(i)] * plain.spin;
    }
    all.push_back({plain.name, std::move(rod), plain.damping, plain.tip_force, plain.design.start,
                   Vector3d::Zero(), &plain, std::nullopt});
  }
  return all;
}

double CarrierGrowth(const Scene& scene, const std::vector<Driven>& rods, double time) {
  if (!scene.gripper || scene.gripper->shortening != Shortening::kCarrier) return 0;
  double pull = 0;
  for (const Driven& d : rods) {
    if (d.actuation) pull += d.actuation->PullAt(time) / scene.gripper->gripper.tentacles;
  }
  return scene.gripper->gripper.carrier_radius * pull / (1 - pull);
}

Stepper::Stepper(const Scene& scene, const ContactPairs& pairs, bool plain, std::vector<Driven>& rods)
    : scene_(scene), rods_(rods), pairs_(pairs), plain_(plain) {
  options_.form = scene.level == SimulationLevel::kPaper ? RodForm::kPaper : RodForm::kEnergy;
  options_.gravity = scene.gravity;
  if (plain) return;
  MakeBatches();
  if (!pairs.rods && !pairs.selves && !pairs.bodies) return;
  std::vector<Rod> shapes;
  for (const Driven& d : rods) shapes.push_back(d.rod);
  std::vector<FixedBody> bodies;
  for (const SceneObject& object : scene.objects) bodies.push_back(object.body);
  contacts_.emplace(scene.contact, shapes, bodies, pairs);
}

std::string Stepper::Advance(double time, int steps, double step) {
  options_.time_step = step;
  return plain_ ? AdvancePlain(time, steps) : AdvanceLanes(time, steps);
}

// Rods damped differently lose speed at a step's end.
std::string Stepper::AdvancePlain(double time, int steps) {
  std::vector<Rod> rods;
  for (Driven& d : rods_) rods.push_back(std::move(d.rod));
  const bool one_damping =
      std::all_of(rods_.begin(), rods_.end(), [&](const Driven& d) { return d.damping == rods_[0].damping; });
  options_.damping = one_damping ? rods_[0].damping : 0;
  std::string trouble;
  for (int i = 0; i < steps && trouble.empty(); ++i) {
    const double now = time + i * options_.time_step;
    StepPlain(rods, now, options_, [&](double middle, std::span<Rod> at, std::span<Matrix3Xd> forces) {
      const double growth = CarrierGrowth(scene_, rods_, middle);
      for (std::size_t r = 0; r < at.size(); ++r) {
        rods_[r].rod = std::move(at[r]);
        Drive(scene_, rods_[r], growth, middle);
        at[r] = std::move(rods_[r].rod);
        forces[r].rightCols<1>() += rods_[r].tip_force;
        if (pairs_.selves) AddSelfContact(scene_.contact, at[r], forces[r]);
        for (const SceneObject& object : scene_.objects) {
          if (pairs_.bodies) AddBodyContact(scene_.contact, at[r], object.body, forces[r]);
        }
        for (std::size_t other = 0; pairs_.rods && other < r; ++other) {
          AddRodContact(scene_.contact, at[r], at[other], forces[r], forces[other]);
        }
      }
    });
    for (std::size_t r = 0; r < rods.size(); ++r) {
      const double keep = one_damping ? 1 : std::exp(-rods_[r].damping * options_.time_step);
      rods[r].velocity *= keep;
      rods[r].spin *= keep;
      if (!std::isfinite(rods[r].position.sum() + rods[r].velocity.sum() + rods[r].spin.sum())) {
        trouble = "at " + ShortNumber(now) + " s " + rods_[r].name + " has positions that are not finite";
      }
    }
  }
  for (std::size_t r = 0; r < rods.size(); ++r) rods_[r].rod = std::move(rods[r]);
  return trouble;
}

void Stepper::MakeBatches() {
  for (std::size_t r = 0; r < rods_.size(); ++r) {
    const auto fits = [&](const Batch& batch) {
      return batch.members.size() < kRodLanes &&
             rods_[batch.members[0]].rod.elements() == rods_[r].rod.elements();
    };
    const auto batch = std::find_if(batches_.begin(), batches_.end(), fits);
    if (batch == batches_.end()) {
      batches_.emplace_back().members.push_back(r);
    } else {
      batch->members.push_back(r);
    }
  }
  for (Batch& batch : batches_) {
    std::vector<Rod> state;
    std::vector<double> damping;
    for (const std::size_t r : batch.members) {
      state.push_back(rods_[r].rod);
      damping.push_back(rods_[r].damping);
    }
    batch.lanes = LaneRods<double>::Make(state, options_.form).value();
    batch.lanes->SetDamping(damping);
    batch.base.assign(batch.lanes->rest_curvatures().size(), 0.0);
    batch.slope = batch.base;
  }
}

// Rest curvature, base and loads of that moment; forces are as good as new.
void Stepper::DriveBatch(Batch& batch, double growth, double time) {
  LaneRods<double>& lanes = *batch.lanes;
  const std::span<double> forces = lanes.forces(), curvature = lanes.rest_curvatures();
  std::fill(forces.begin(), forces.end(), 0.0);
  double share[kRodLanes] = {};
  bool changed = !batch.driven_once;
  for (std::size_t lane = 0; lane < batch.members.size(); ++lane) {
    const Driven& d = rods_[batch.members[lane]];
    TentacleActuation::Place place;
    if (d.actuation) {
      const double pull = d.actuation->PullAt(time);
      place = d.actuation->PlaceOf(pull);
      const Vector3d base = d.start + growth * d.outward;
      for (std::size_t k = 0; k < 3; ++k)
        lanes.positions()[k * kRodLanes + lane] = base[static_cast<Index>(k)];
      if (scene_.gripper->shortening == Shortening::kTrue) {
        const std::span<double> strain = lanes.rest_strains();
        for (std::size_t i = 2 * kRodLanes + lane; i < strain.size(); i += 3 * kRodLanes) strain[i] = -pull;
      }
    } else {
      place.share = RampShare(*d.plain, time);
      for (std::size_t k = 0; k < 3; ++k) {
        forces[(static_cast<std::size_t>(3 * lanes.elements()) + k) * kRodLanes + lane] =
            d.tip_force[static_cast<Index>(k)];
      }
    }
    share[lane] = place.share;
    changed = changed || place.share != batch.place[lane].share;
    if (!batch.driven_once || place.entry != batch.place[lane].entry) {
      changed = true;
      for (std::size_t i = lane, row = 0; i < batch.base.size(); i += kRodLanes, ++row) {
        if (d.actuation) {
          batch.base[i] = d.actuation->Entry(place.entry).data()[row];
          batch.slope[i] = d.actuation->Entry(place.entry + 1).data()[row] - batch.base[i];
        } else {
          batch.slope[i] = d.plain->rest_curvature[static_cast<Index>(row % 3)];
        }
      }
    }
    batch.place[lane] = place;
  }
  batch.driven_once = true;
  if (!changed) return;
  for (std::size_t i = 0; i < curvature.size(); i += kRodLanes) {
    for (std::size_t lane = 0; lane < kRodLanes; ++lane) {
      curvature[i + lane] = batch.base[i + lane] + share[lane] * batch.slope[i + lane];
    }
  }
}

void Stepper::AddContact() {
  for (Batch& batch : batches_) {
    contacts_->PutLanes(batch.members, batch.lanes->positions().data(), batch.lanes->velocities().data());
  }
  // Positions that are not finite are found by the rods themselves, in the kick that follows.
  if (!contacts_->Find()) return;
  for (Batch& batch : batches_) contacts_->AddLaneForces(batch.members, batch.lanes->forces().data());
}

// All rods step together, as they may touch. Half drifts of neighbouring steps are one.
std::string Stepper::AdvanceLanes(double time, int steps) {
  const double step = options_.time_step;
  std::string trouble;
  for (Batch& batch : batches_) batch.lanes->Drift(0.5 * step);
  for (int i = 0; i < steps && trouble.empty(); ++i) {
    const double middle = time + (i + 0.5) * step;
    const double growth = CarrierGrowth(scene_, rods_, middle);
    for (Batch& batch : batches_) DriveBatch(batch, growth, middle);
    if (contacts_) AddContact();
    for (Batch& batch : batches_) {
      batch.lanes->Kick(options_);
      if (!batch.lanes->trouble().any()) continue;
      trouble = "at " + ShortNumber(middle) + " s " + rods_[batch.members[0]].name + " or a rod beside it" +
                (batch.lanes->trouble().not_finite ? " have positions that are not finite"
                                                   : " turn too far, in a step or from element to element");
    }
    const bool last = i + 1 == steps || !trouble.empty();
    for (Batch& batch : batches_) batch.lanes->Drift(last ? 0.5 * step : step);
  }
  for (Batch& batch : batches_) {
    std::vector<Rod> state;
    for (const std::size_t r : batch.members) state.push_back(std::move(rods_[r].rod));
    batch.lanes->Store(state);
    for (std::size_t k = 0; k < state.size(); ++k) rods_[batch.members[k]].rod = std::move(state[k]);
  }
  return trouble;
}

}  // namespace tendril
