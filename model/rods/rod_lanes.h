#pragma once
// Eight rods side by side in vector registers: the stepper of rod_plain.h, fast. Same forms, same step, same
// loads; results agree to rounding (docs/rods.md, "Eight rods at once").
//
// SI units; directors are kept as unit quaternions lab_from_body. Arrays are laid out [node or
// element][component][8 rods].

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "model/result.h"
#include "model/rods/medium.h"
#include "model/rods/rod.h"
#include "model/rods/rod_plain.h"

namespace tendril {

namespace rod_kernel {
template <class S>
struct Job;
}

inline constexpr int kRodLanes = 8;

// Why a batch of rods stopped.
struct LaneTrouble {
  bool turned_too_far =
      false;  // between neighbouring elements by more than 1.6 rad, or an element by 1 rad in a step
  bool not_finite = false;
  bool any() const { return turned_too_far || not_finite; }
};

// One to eight rods of equally many elements. S: double, or float.
template <class S>
class LaneRods {
 public:
  //   errors  kBadInput  no rod, more than eight, different numbers of elements, kPaper with an
  //                      end that is held by its frame
  static Result<LaneRods> Make(std::span<const Rod> rods, RodForm form);

  // Called in the middle of each step, at `time`: positions, directors, rest strains and curvatures as below.
  // Forces and couples are 0 when it is called and may be added to.
  using Middle = std::function<void(double time, LaneRods& rods)>;

  // Steps from `time` on; stops early, at a whole step, where a rod is in trouble.
  //   returns  the steps made
  int Advance(int steps, double time, const PlainOptions& options, const Middle& middle = {});
  LaneTrouble trouble() const { return trouble_; }

  // The parts of a step, for rods whose forces depend on rods elsewhere: half a drift, forces, kick, half a
  // drift. Kick counts what is in forces() and couples().
  void Drift(double time);
  void Kick(const PlainOptions& options) { Kick(options, true); }
  // Whether there are couples(); without them a kick does not pay for them.
  void UseCouples(bool use);
  // From now on forces() and couples() (empty: there are none) are these, which the caller keeps.
  void ShareLoads(std::span<S> forces, std::span<S> couples);
  // From now on the rods, those that the batch was made from, move in a medium, each wetted in its own way;
  // of density 0: in vacuum. What PlainOptions say of a medium does not count here.
  void SetMedium(const Medium& medium, std::span<const Rod> rods, std::span<const Wetted> wetted);
  // Damping of each rod, 1/s, instead of the options'.
  void SetDamping(std::span<const double> damping);

  // At an end (0: base, 1: tip) that is held: the directors, and the rest curvature of the half element
  // there.
  void SetEndFrame(size_t end, size_t lane, EndHold hold, const Eigen::Matrix3d& frame);
  void SetEndCurvature(size_t end, size_t lane, const Eigen::Vector3d& curvature);

  // Back into the rods they came from: positions, velocities, directors, spins.
  void Store(std::span<Rod> rods) const;

  // Spins of elements along the lab's axes, rad/s: [element][component][8 rods].
  void LabSpins(std::span<S> to);

  int rods() const { return rods_; }
  int elements() const { return elements_; }
  // All that a step changes or reads, but for couples, which like forces are new in every step, and
  // the medium: with it
  // another batch of the same rods goes on to the same bytes.
  std::span<S> memory() { return memory_; }
  std::span<S> positions() { return Part(at_.position, 3 * (elements_ + 1)); }
  std::span<S> velocities() { return Part(at_.velocity, 3 * (elements_ + 1)); }
  std::span<S> forces() { return shares_ ? shared_forces_ : Part(at_.force, 3 * (elements_ + 1)); }
  // On elements from outside, along the lab's axes, N m: [element][component][8 rods]; none without
  // UseCouples.
  std::span<S> couples() { return shares_ ? shared_couples_ : std::span<S>(couples_); }
  std::span<S> rest_strains() { return Part(at_.rest_strain, 3 * elements_); }
  std::span<S> tip_couples() { return Part(at_.tip_couple, 3); }
  std::span<S> rest_curvatures() { return Part(at_.rest_curvature, 3 * (elements_ - 1)); }

 private:
  std::span<S> Part(size_t from, int rows) {
    return {memory_.data() + from, static_cast<size_t>(rows) * kRodLanes};
  }
  // Places in `memory_`.
  struct Places {
    size_t position, velocity, turn, spin, force, inverse_mass, rest_length, shear, inertia, bend,
        rest_strain, rest_curvature, mobile, damped, end_turn, end_bend, end_curvature, tip_couple;
  };
  rod_kernel::Job<S> MakeJob();
  void Kick(const PlainOptions& options, bool with_forces);

  RodForm form_ = RodForm::kEnergy;
  int rods_ = 0;
  int elements_ = 0;
  Places at_{};
  std::vector<S> memory_;
  std::vector<S> couples_;
  bool shares_ = false;  // ShareLoads
  std::span<S> shared_forces_, shared_couples_;
  std::vector<S> medium_;  // WettedNodes [node][4][8 rods]; empty: vacuum
  Eigen::Vector3d flow_ = Eigen::Vector3d::Zero();
  std::vector<double> damping_;  // of each rod; empty: the options'
  LaneTrouble trouble_;
};

// For tests: kernels of 2, 4 or 8 doubles to a register, not above MachineDoubles(); 0: the widest.
void UseRodKernel(int width);
int RodKernelWidth();

extern template class LaneRods<double>;
extern template class LaneRods<float>;

}  // namespace tendril
