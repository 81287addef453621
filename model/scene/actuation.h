#pragma once
// How far each tentacle of a gripper is pulled at a time, and the rest shape that its rod then has.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "model/result.h"
#include "model/scene/scene.h"
#include "model/scene/schedule.h"

namespace tendril {

// Uniform in [0, 1), the same on every machine and in any order: a hash of what it is drawn for (SplitMix64's
// finalizer, Steele, Lea and Flood 2014, over each word in turn).
double UniformDraw(std::uint64_t seed, std::uint64_t trial, std::uint64_t tentacle, std::uint64_t which);

// The rod that stands for a gripper's tentacle: its own values, with the design's length and taper.
RodDesign TentacleRod(const SceneGripper& gripper);

class TentacleActuation {
 public:
  // Rest curvatures are tabulated over the pull; between entries they are interpolated linearly. Before the
  // one of pull 0, which is straight, comes that of a stowed gripper's roll.
  //   errors  as LayOut, SolveFold, RolledCurvature
  //   bends_at_base  as RestCurvatureOptions says
  static Result<TentacleActuation> Make(const SceneGripper& gripper, bool bends_at_base, std::uint64_t seed,
                                        std::uint64_t trial, int tentacle,
                                        const std::vector<Phase>& phases = {});

  double PullAt(double time) const { return pulls_.At(time); }
  double PullRateAt(double time) const { return pulls_.RateAt(time); }  // 1/s

  // The rest curvature as a place in the table: (1 - share) Entry(entry) + share Entry(entry + 1).
  // An entry: of the half element at the base, then at the inner nodes, 1/m              (3, elements)
  struct Place {
    std::size_t entry = 0;
    double share = 0;
  };
  Place PlaceOf(double pull) const;  // of a tentacle that is not rolled up
  Place PlaceAt(double time) const;
  const Eigen::Matrix3Xd& Entry(std::size_t entry) const { return table_[entry]; }
  std::size_t entries() const { return table_.size(); }

  // Of what it starts with; null: straight.
  const Eigen::Matrix3Xd* roll() const { return stow_ ? &table_[0] : nullptr; }
  // The strongest rest curvature that it is ever given, of each column of an entry, 1/m.
  const Eigen::VectorXd& strongest() const { return strongest_; }

 private:
  TentacleActuation(PullSchedule pulls, double strongest_pull)
      : pulls_(std::move(pulls)), strongest_pull_(strongest_pull) {}

  PullSchedule pulls_;
  double strongest_pull_ = 0;  // the table's last entry
  std::optional<Stow> stow_;
  std::vector<Eigen::Matrix3Xd> table_;  // rolled up, where it is; at pulls 0 .. the strongest
  Eigen::VectorXd strongest_;
};

}  // namespace tendril
