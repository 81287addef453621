#pragma once
// How far each tentacle of a gripper is pulled at a time, and the rest shape that its rod then has.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "model/result.h"
#include "model/scene/scene.h"

namespace tendril {

// Uniform in [0, 1), the same on every machine and in any order: a hash of what it is drawn for (SplitMix64's
// finalizer, Steele, Lea and Flood 2014, over each word in turn).
double UniformDraw(std::uint64_t seed, std::uint64_t trial, std::uint64_t tentacle, std::uint64_t which);

class TentacleActuation {
 public:
  // Rest curvatures are tabulated over the pull; between entries they are interpolated linearly.
  //   errors  as LayOut and SolveFold
  //   bends_at_base  as RestCurvatureOptions says
  static Result<TentacleActuation> Make(const SceneGripper& gripper, bool bends_at_base, std::uint64_t seed,
                                        std::uint64_t trial, int tentacle);

  double PullAt(double time) const;
  double PullRateAt(double time) const;  // 1/s

  // The rest curvature at a pull as a place in the table: (1 - share) Entry(entry) + share Entry(entry + 1).
  // An entry: of the half element at the base, then at the inner nodes, 1/m              (3, elements)
  struct Place {
    std::size_t entry = 0;
    double share = 0;
  };
  Place PlaceOf(double pull) const;
  const Eigen::Matrix3Xd& Entry(std::size_t entry) const { return table_[entry]; }
  std::size_t entries() const { return table_.size(); }

 private:
  double pull_ = 0, rate_ = 0, delay_ = 0;
  std::vector<Eigen::Matrix3Xd> table_;  // at pulls 0 .. pull_
};

}  // namespace tendril
