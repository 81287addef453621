#pragma once
// The rods of a scene, what drives them, and their steps. Used by simulate.h.

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "model/result.h"
#include "model/rods/contact_list.h"
#include "model/rods/rod_lanes.h"
#include "model/rods/rod_plain.h"
#include "model/scene/actuation.h"
#include "model/scene/scene.h"

namespace tendril {

// For messages: six digits.
std::string ShortNumber(double value);

// A rod of the scene and what drives it.
struct Driven {
  std::string name;
  Rod rod;
  double damping = 0;
  Eigen::Vector3d tip_force = Eigen::Vector3d::Zero();
  Eigen::Vector3d start = Eigen::Vector3d::Zero();  // of node 0
  Eigen::Vector3d outward =
      Eigen::Vector3d::Zero();  // by which node 0 moves per metre of the carrier's radius
  const SceneRod* plain = nullptr;
  std::optional<TentacleActuation> actuation;
};

//   errors  as MakeRod, LayOut, SolveFold
Result<std::vector<Driven>> MakeRods(const Scene& scene, std::uint64_t trial);

// The carrier's growth at a time, m.
double CarrierGrowth(const Scene& scene, const std::vector<Driven>& rods, double time);

class Stepper {
 public:
  // Refers to the scene and to the rods.
  //   plain   in the plain form, for comparison
  Stepper(const Scene& scene, const ContactPairs& pairs, bool plain, std::vector<Driven>& rods);

  // Steps all rods from `time` on.
  //   returns  what went wrong, when and with which rods; empty: nothing
  std::string Advance(double time, int steps, double step);

  // Null where nothing can touch, and in the plain form.
  const ContactList* contacts() const { return contacts_ ? &*contacts_ : nullptr; }

 private:
  // Up to eight rods of equally many elements. Rest curvature is base + share * slope.
  struct Batch {
    std::vector<std::size_t> members;
    std::optional<LaneRods<double>> lanes;
    std::vector<double> base, slope;  // [inner node][component][8]
    std::vector<TentacleActuation::Place> place = std::vector<TentacleActuation::Place>(kRodLanes);
    bool driven_once = false;
  };
  std::string AdvancePlain(double time, int steps);
  std::string AdvanceLanes(double time, int steps);
  void MakeBatches();
  void DriveBatch(Batch& batch, double growth, double time);
  void AddContact();

  const Scene& scene_;
  std::vector<Driven>& rods_;
  ContactPairs pairs_;
  bool plain_;
  PlainOptions options_;
  std::vector<Batch> batches_;
  std::optional<ContactList> contacts_;
};

}  // namespace tendril
