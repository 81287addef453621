#pragma once
// Steps the rods of a scene together. Used by simulate.h.
//
// Position Verlet whose half drifts are merged: between kicks the state stands in the middle of steps, and
// what it is at other times is worked out on a copy, so that asking changes nothing.

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "model/result.h"
#include "model/rods/contact_list.h"
#include "model/rods/contact_plain.h"
#include "model/rods/rod_lanes.h"
#include "model/rods/rod_plain.h"
#include "model/scene/bodies.h"
#include "model/scene/crew.h"
#include "model/scene/driven.h"
#include "model/scene/plan.h"
#include "model/scene/scene.h"
#include "model/scene/watchdog.h"

namespace tendril {

class Stepper {
 public:
  // Refers to the scene. `rods` as MakeRods has them; the plan's reliefs are applied here.
  //   threads  that share the rods, eight to a part; more of them change no byte
  Stepper(const Scene& scene, const SimulationPlan& plan, std::vector<Driven> rods, double time_step,
          int threads = 1);

  // Kicks up to `kicks` in all, or until something goes wrong. Kick n is at time (n + 1/2) time_step.
  std::optional<Divergence> AdvanceTo(std::int64_t kicks);
  std::int64_t kicks() const { return kicks_; }
  double time_step() const { return options_.time_step; }

  // The rods at a time within half a step of kicks * time_step: exact where the scheme is (its path is
  // straight between two kicks).
  std::vector<Rod> At(double time) const;
  // Objects likewise, lab_from_object.
  std::vector<Eigen::Isometry3d> PosesAt(double time) const;

  // What comes after depends on positions and velocities alone, not on how they came about; to be called at
  // the same kicks in every run that is to give the same bytes.
  void ForgetHistory();
  // All that a run goes on from; right after ForgetHistory.
  std::vector<double> Save() const;
  //   returns  false  it is not of such a scene; nothing has changed
  bool Restore(const std::vector<double>& state);

  // What the rods pressed on an object with in the last kick, N.
  const Eigen::Vector3d& ForceOn(std::size_t object) const { return on_bodies_[object].force; }

  // By energy; to be called from time to time.
  std::optional<Divergence> CheckEnergy() const;

  // Null where nothing can touch, and in the plain form.
  const ContactList* contacts() const { return contacts_ ? &*contacts_ : nullptr; }
  const std::vector<Driven>& rods() const { return rods_; }
  const Bodies& bodies() const { return bodies_; }

 private:
  // Up to eight rods of equally many elements. Rest curvature is base + share * slope.
  struct Batch {
    std::vector<std::size_t> members;
    std::optional<LaneRods<double>> lanes;
    std::vector<double> base, slope;                          // [inner node][component][8]
    Eigen::Matrix<double, 3, kRodLanes> end_base, end_slope;  // of the half element at the base
    std::vector<TentacleActuation::Place> place = std::vector<TentacleActuation::Place>(kRodLanes);
    bool driven_once = false;
  };
  std::optional<Divergence> StepPlainly();
  std::optional<Divergence> StepLanes();
  Divergence Explain(Divergence found) const;
  void MakeBatches();
  void DriveBatch(Batch& batch, const CarrierGrowth& growth, double time);
  void DriveEnds(Batch& batch, std::size_t lane, const Driven& driven, const DriveState& state);
  Wetted WettedOf(std::size_t rod) const;
  void Eject(double middle);
  void AddTipForces(Batch& batch) const;
  void FindContact();
  void AddPublished(const std::vector<Rod>& rods, std::vector<RodLoads>& loads) const;
  template <class Work>
  void ForEachBatch(const Work& work);

  const Scene& scene_;
  SimulationPlan plan_;
  std::vector<Driven> rods_;
  PlainOptions options_;
  std::vector<std::optional<Ejection>> ejections_;
  std::vector<Batch> batches_;
  std::unique_ptr<Crew> crew_;  // null: the caller alone
  std::optional<ContactList> contacts_;
  std::optional<PlainContact> plain_contact_;
  Bodies bodies_;
  std::vector<Wrench> on_bodies_;
  double energy_budget_ = 0;
  std::int64_t kicks_ = 0;
};

}  // namespace tendril
