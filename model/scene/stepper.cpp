#include "model/scene/stepper.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <span>

#include "model/check.h"

namespace tendril {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

Stepper::Stepper(const Scene& scene, const SimulationPlan& plan, std::vector<Driven> rods, double time_step,
                 int threads)
    : scene_(scene),
      plan_(plan),
      rods_(std::move(rods)),
      bodies_(scene, time_step),
      on_bodies_(scene.objects.size()) {
  options_.form = FormOf(scene.level);
  options_.time_step = time_step;
  const double mass = plan.relief.mass;
  options_.gravity = scene.gravity / mass;
  energy_budget_ = EnergyBudget(scene, rods_);
  for (const Driven& d : rods_) ejections_.push_back(EjectionOf(scene, d));
  for (Driven& d : rods_) {
    ApplyRelief(plan.relief, d.rod);
    d.damping /= mass;
  }
  const ContactPairs pairs{
      .rods = plan.rod_contact, .selves = plan.self_contact, .bodies = plan.object_contact};
  Contact contact = scene.contact;
  contact.points = plan.contact_points;
  if (plan.plain) {
    plain_contact_.emplace(contact, pairs);
    const CarrierGrowth growth = CarrierGrowthAt(scene_, rods_, 0);
    for (Driven& d : rods_) {
      ApplyDrive(DriveAt(scene_, d, growth, 0), d, d.rod);
      DriftPlain(d.rod, options_.form, 0.5 * time_step);
    }
    return;
  }
  MakeBatches();
  for (Batch& batch : batches_) batch.lanes->Drift(0.5 * time_step);
  const int crew = std::min(threads, static_cast<int>(batches_.size()));
  if (crew > 1) crew_ = std::make_unique<Crew>(crew);
  if (!pairs.rods && !pairs.selves && !pairs.bodies) return;
  std::vector<Rod> shapes;
  for (const Driven& d : rods_) shapes.push_back(d.rod);
  std::vector<FixedBody> bodies;
  const bool published = contact.law != ContactLaw::kHertzSegments;
  for (const SceneObject& object : scene.objects) {
    if (published) bodies.push_back(object.body);
  }
  contacts_.emplace(contact, shapes, bodies, published ? std::vector<Solid>() : bodies_.solids(), pairs);
  for (Batch& batch : batches_) {
    batch.lanes->ShareLoads(contacts_->LaneForces(batch.members),
                            contacts_->Moves() ? contacts_->LaneCouples(batch.members) : std::span<double>());
  }
}

std::optional<Divergence> Stepper::AdvanceTo(std::int64_t kicks) {
  std::optional<Divergence> found;
  while (kicks_ < kicks && !found) {
    found = plan_.plain ? StepPlainly() : StepLanes();
    ++kicks_;
  }
  if (found) found = Explain(std::move(*found));
  return found;
}

std::vector<Rod> Stepper::At(double time) const {
  std::vector<Rod> rods;
  for (const Driven& d : rods_) rods.push_back(d.rod);
  const double back = time - (static_cast<double>(kicks_) + 0.5) * options_.time_step;
  for (const Batch& batch : batches_) {
    LaneRods<double> lanes = *batch.lanes;
    lanes.Drift(back);
    std::vector<Rod> state;
    for (const std::size_t r : batch.members) state.push_back(std::move(rods[r]));
    lanes.Store(state);
    for (std::size_t k = 0; k < state.size(); ++k) rods[batch.members[k]] = std::move(state[k]);
  }
  const CarrierGrowth growth = CarrierGrowthAt(scene_, rods_, time);
  for (std::size_t r = 0; r < rods.size(); ++r) {
    if (plan_.plain) DriftPlain(rods[r], options_.form, back);
    ApplyDrive(DriveAt(scene_, rods_[r], growth, time), rods_[r], rods[r]);
  }
  return rods;
}

std::vector<Eigen::Isometry3d> Stepper::PosesAt(double time) const {
  return bodies_.PosesAt(time - (static_cast<double>(kicks_) + 0.5) * options_.time_step);
}

// Names the element, as far as it can still be told.
Divergence Stepper::Explain(Divergence found) const {
  const double time = (static_cast<double>(kicks_) - 0.5) * options_.time_step;
  const std::vector<Rod> at = At(static_cast<double>(kicks_) * options_.time_step);
  if (const auto lost = FindNotFinite(rods_, at)) {
    found = *lost;
  } else if (const std::optional<std::size_t> object = bodies_.NotFinite()) {
    const std::string& name = scene_.objects[*object].name;
    found.rod = "object " + (name.empty() ? std::to_string(*object) : name);
    found.element = -1;
    found.why = "its place or motion is not finite";
  } else if (found.why == "overlap") {
    found = FindDeepest(scene_, rods_, at, PosesAt(static_cast<double>(kicks_) * options_.time_step));
  } else if (found.why == "turned") {
    found = FindFarTurned(rods_, at, options_.time_step);
  }
  if (kicks_ == 1 && (found.why.find("of the radii's sum") != std::string::npos ||
                      found.why.find("of its radius") != std::string::npos)) {
    found.why += ": they start inside each other";
    found.at_start = true;
  }
  found.time = time;
  found.suggested_step = std::min(0.5 * options_.time_step, 0.7 * plan_.stable_step);
  return found;
}

std::optional<Divergence> Stepper::CheckEnergy() const {
  const std::vector<Rod> at = At(static_cast<double>(kicks_) * options_.time_step);
  double kinetic = 0;
  for (const Rod& rod : at) kinetic += KineticEnergy(rod) / plan_.relief.mass;
  if (kinetic <= kEnergyFactor * energy_budget_ + 1e-12) return std::nullopt;
  Divergence found = FindFastest(rods_, at);
  found.why += ", and all rods together with " + ShortNumber(kinetic) + " J where the scene can put in " +
               ShortNumber(energy_budget_) + " J";
  return Explain(std::move(found));
}

void Stepper::AddPublished(const std::vector<Rod>& rods, std::vector<RodLoads>& loads) const {
  for (std::size_t r = 0; r < rods.size(); ++r) {
    if (plan_.self_contact) AddSelfContact(scene_.contact, rods[r], loads[r].force);
    for (const SceneObject& object : scene_.objects) {
      if (plan_.object_contact) AddBodyContact(scene_.contact, rods[r], object.body, loads[r].force);
    }
    for (std::size_t other = 0; plan_.rod_contact && other < r; ++other) {
      AddRodContact(scene_.contact, rods[r], rods[other], loads[r].force, loads[other].force);
    }
  }
}

std::optional<Divergence> Stepper::StepPlainly() {
  const double step = options_.time_step;
  const double middle = (static_cast<double>(kicks_) + 0.5) * step;
  const CarrierGrowth growth = CarrierGrowthAt(scene_, rods_, middle);
  Eject(middle);
  std::vector<RodLoads> loads(rods_.size());
  std::vector<Rod> shapes;
  for (std::size_t r = 0; r < rods_.size(); ++r) {
    Driven& d = rods_[r];
    ApplyDrive(DriveAt(scene_, d, growth, middle), d, d.rod);
    loads[r].force.setZero(3, d.rod.elements() + 1);
    loads[r].force.rightCols<1>() += d.tip_force;
    loads[r].couple.setZero(3, d.rod.elements());
    shapes.push_back(d.rod);
  }
  std::fill(on_bodies_.begin(), on_bodies_.end(), Wrench{});
  if (scene_.contact.law == ContactLaw::kHertzSegments) {
    plain_contact_->Add(shapes, bodies_.solids(), step, loads, on_bodies_);
  } else {
    AddPublished(shapes, loads);
  }
  bodies_.Step(middle, on_bodies_);
  std::optional<Divergence> found;
  if (bodies_.NotFinite()) found.emplace().why = "not finite";
  for (std::size_t r = 0; r < rods_.size(); ++r) {
    Driven& d = rods_[r];
    PlainOptions options = options_;
    options.damping = d.damping;
    options.medium = scene_.medium.density > 0 ? &scene_.medium : nullptr;
    options.wetted = WettedOf(r);
    KickPlain(d.rod, options, loads[r].force, loads[r].couple);
    DriftPlain(d.rod, options.form, step);
    if (!std::isfinite(d.rod.position.sum() + d.rod.velocity.sum() + d.rod.spin.sum())) {
      found.emplace().why = "not finite";
    }
  }
  return found;
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
    if (scene_.medium.density > 0) {
      std::vector<Wetted> wetted;
      for (const std::size_t r : batch.members) wetted.push_back(WettedOf(r));
      batch.lanes->SetMedium(scene_.medium, state, wetted);
    }
    batch.base.assign(batch.lanes->rest_curvatures().size(), 0.0);
    batch.slope = batch.base;
  }
}

// Gravity is divided by what the plan makes the rods heavier by, so what they displace is multiplied.
Wetted Stepper::WettedOf(std::size_t rod) const {
  Wetted wetted = rods_[rod].plain != nullptr ? rods_[rod].plain->wetted : scene_.gripper->wetted;
  wetted.displaced *= plan_.relief.mass;
  return wetted;
}

// In the step in whose middle its time has come.
void Stepper::Eject(double middle) {
  for (std::size_t r = 0; r < rods_.size(); ++r) {
    const std::optional<Ejection>& ejection = ejections_[r];
    if (!ejection || ejection->time > middle || ejection->time <= middle - options_.time_step) continue;
    if (plan_.plain) {
      rods_[r].rod.velocity += ejection->velocity;
      continue;
    }
    for (Batch& batch : batches_) {
      for (std::size_t lane = 0; lane < batch.members.size(); ++lane) {
        if (batch.members[lane] != r) continue;
        const std::span<double> velocities = batch.lanes->velocities();
        for (Index i = 0; i < ejection->velocity.size(); ++i) {
          velocities[static_cast<std::size_t>(i) * kRodLanes + lane] += ejection->velocity.data()[i];
        }
      }
    }
  }
}

void Stepper::DriveEnds(Batch& batch, std::size_t lane, const Driven& d, const DriveState& state) {
  LaneRods<double>& lanes = *batch.lanes;
  const std::size_t last = 3 * static_cast<std::size_t>(lanes.elements());
  const bool base = d.rod.base.hold != EndHold::kFree, tip = d.rod.tip.hold != EndHold::kFree;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto row = static_cast<Index>(k);
    if (base) {
      lanes.positions()[k * kRodLanes + lane] = state.base_position[row];
      lanes.velocities()[k * kRodLanes + lane] = state.base_velocity[row];
    }
    if (tip) {
      lanes.positions()[(last + k) * kRodLanes + lane] = state.tip_position[row];
      lanes.velocities()[(last + k) * kRodLanes + lane] = state.tip_velocity[row];
    }
  }
  const bool carried = d.carrier != nullptr && d.carrier->turns();
  const bool base_turns = carried || (d.plain != nullptr && d.plain->base_motion.until > 0);
  const bool tip_turns = carried || (d.plain != nullptr && d.plain->tip_motion.until > 0);
  if (base && base_turns) lanes.SetEndFrame(0, lane, d.rod.base.hold, state.base_frame);
  if (tip && tip_turns) lanes.SetEndFrame(1, lane, d.rod.tip.hold, state.tip_frame);
}

// Rest curvature and held ends of that moment.
void Stepper::DriveBatch(Batch& batch, const CarrierGrowth& growth, double time) {
  LaneRods<double>& lanes = *batch.lanes;
  const std::span<double> curvature = lanes.rest_curvatures();
  bool changed = !batch.driven_once;
  for (std::size_t lane = 0; lane < batch.members.size(); ++lane) {
    const Driven& d = rods_[batch.members[lane]];
    const DriveState state = DriveAt(scene_, d, growth, time);
    DriveEnds(batch, lane, d, state);
    const bool moved = !batch.driven_once || state.place.share != batch.place[lane].share;
    const bool other_entry = !batch.driven_once || state.place.entry != batch.place[lane].entry;
    if (!moved && !other_entry) continue;
    changed = true;
    if (d.actuation && scene_.gripper->shortening == Shortening::kTrue) {
      const std::span<double> strain = lanes.rest_strains();
      for (std::size_t i = 2 * kRodLanes + lane; i < strain.size(); i += 3 * kRodLanes) {
        strain[i] = state.axial_rest_strain;
      }
    }
    if (other_entry) {
      if (d.actuation) {
        const Matrix3Xd& low = d.actuation->Entry(state.place.entry);
        const Matrix3Xd& high = d.actuation->Entry(state.place.entry + 1);
        batch.end_base.col(static_cast<Index>(lane)) = low.col(0);
        batch.end_slope.col(static_cast<Index>(lane)) = high.col(0) - low.col(0);
        // Column 0 is the base's.
        for (std::size_t i = lane, row = 3; i < batch.base.size(); i += kRodLanes, ++row) {
          batch.base[i] = low.data()[row];
          batch.slope[i] = high.data()[row] - batch.base[i];
        }
      } else {
        batch.end_base.col(static_cast<Index>(lane)).setZero();
        batch.end_slope.col(static_cast<Index>(lane)) = d.plain->rest_curvature;
        for (std::size_t i = lane, row = 0; i < batch.slope.size(); i += kRodLanes, ++row) {
          batch.slope[i] = d.plain->rest_curvature[static_cast<Index>(row % 3)];
        }
      }
    }
    const Vector3d end = batch.end_base.col(static_cast<Index>(lane)) +
                         state.place.share * batch.end_slope.col(static_cast<Index>(lane));
    lanes.SetEndCurvature(0, lane, end);
    // Tentacles end free.
    if (d.plain != nullptr) lanes.SetEndCurvature(1, lane, end);
    batch.place[lane] = state.place;
  }
  batch.driven_once = true;
  if (!changed) return;
  double share[kRodLanes];
  for (std::size_t lane = 0; lane < kRodLanes; ++lane) share[lane] = batch.place[lane].share;
  for (std::size_t i = 0; i < curvature.size(); i += kRodLanes) {
    for (std::size_t lane = 0; lane < kRodLanes; ++lane) {
      curvature[i + lane] = batch.base[i + lane] + share[lane] * batch.slope[i + lane];
    }
  }
}

// To what is found of contact, if there is any.
void Stepper::AddTipForces(Batch& batch) const {
  const std::span<double> forces = batch.lanes->forces();
  if (!contacts_) std::ranges::fill(forces, 0.0);
  for (std::size_t lane = 0; lane < batch.members.size(); ++lane) {
    const Vector3d& force = rods_[batch.members[lane]].tip_force;
    double* const tip = forces.data() + forces.size() - 3 * kRodLanes + lane;
    for (std::size_t k = 0; k < 3; ++k) tip[k * kRodLanes] += force[static_cast<Index>(k)];
  }
}

void Stepper::FindContact() {
  for (Batch& batch : batches_) {
    contacts_->PutLanes(batch.members, batch.lanes->positions().data(), batch.lanes->velocities().data());
    if (contacts_->Moves()) batch.lanes->LabSpins(contacts_->LaneSpins(batch.members));
  }
  const std::vector<Solid>& solids = bodies_.solids();
  const bool published = scene_.contact.law != ContactLaw::kHertzSegments;
  for (std::size_t s = 0; bodies_.AnyMoves() && !published && s < solids.size(); ++s) {
    contacts_->PutSolid(s, solids[s].pose, solids[s].velocity, solids[s].spin);
  }
  // Positions that are not finite are found by the rods themselves, in the kick that follows.
  contacts_->Find(options_.time_step);
  for (std::size_t s = 0; !published && s < solids.size(); ++s) {
    on_bodies_[s] = contacts_->OnSolid(s);
  }
}

template <class Work>
void Stepper::ForEachBatch(const Work& work) {
  if (crew_) {
    // Two references: small enough that a std::function holds them without allocating.
    crew_->Run(static_cast<int>(batches_.size()),
               [this, &work](int b) { work(batches_[static_cast<std::size_t>(b)]); });
  } else {
    for (Batch& batch : batches_) work(batch);
  }
}

std::optional<Divergence> Stepper::StepLanes() {
  const double step = options_.time_step;
  const double middle = (static_cast<double>(kicks_) + 0.5) * step;
  const CarrierGrowth growth = CarrierGrowthAt(scene_, rods_, middle);
  Eject(middle);
  ForEachBatch([&](Batch& batch) { DriveBatch(batch, growth, middle); });
  if (contacts_) FindContact();
  ForEachBatch([&](Batch& batch) {
    AddTipForces(batch);
    batch.lanes->Kick(options_);
    batch.lanes->Drift(step);
  });
  bodies_.Step(middle, on_bodies_);
  std::optional<Divergence> found;
  if (bodies_.NotFinite()) found.emplace().why = "not finite";
  if (contacts_ && contacts_->least_share() < kLeastAxisShare) found.emplace().why = "overlap";
  for (const Batch& batch : batches_) {
    if (!batch.lanes->trouble().any() || found) continue;
    found.emplace().why = batch.lanes->trouble().not_finite ? "not finite" : "turned";
  }
  return found;
}

void Stepper::ForgetHistory() {
  if (contacts_) contacts_->ForgetList();
}

}  // namespace tendril
