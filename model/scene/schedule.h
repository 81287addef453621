#pragma once
// What a scene's phases ask for at a time: where the carrier is and how it moves, and how far a tentacle is
// pulled. Closed forms, no memory of what came before; a question costs a search among the phases.
//
// SI units, lab frame. Before the first phase counts as its start, after the last one as its end.

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "model/scene/scene.h"

namespace tendril {

// Adds a phase behind all that the scene does; its duration grows by it. A scene without phases first gets
// one of its duration, in which the gripper pulls as it did.
void AddPhase(Scene& scene, Phase phase);

// Time's share s in 0 .. 1 to the way's, 10 s^3 - 15 s^4 + 6 s^5: no speed and no acceleration at either end.
double SmoothShare(double s);

// Where the carrier is against its start: a point p of it then is at offset + turned p, which moves with
// velocity + spin x (turned p).
struct CarrierMotion {
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  // m
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();  // rad/s
};

// Where the carrier is. Its position, velocity and acceleration have no jumps, nor have turn and spin.
class Schedule {
 public:
  explicit Schedule(std::vector<Phase> phases);

  double duration() const { return starts_.back(); }
  // The phase that holds a time; a phase's start belongs to it.
  std::size_t PhaseAt(double time) const;
  const std::vector<Phase>& phases() const { return phases_; }

  CarrierMotion At(double time) const;

  bool moves() const { return moves_; }  // at all, or turns
  bool turns() const { return turns_; }
  // Bounds over all time, for estimates: of |velocity|, m/s; of |spin|, rad/s.
  double Fastest() const { return fastest_; }
  double FastestSpin() const { return fastest_spin_; }

 private:
  std::vector<Phase> phases_;
  std::vector<double> starts_;            // of phases, then the end                       (phases + 1)
  std::vector<Eigen::Vector3d> offsets_;  // at those
  std::vector<Eigen::Matrix3d> turneds_;
  bool moves_ = false, turns_ = false;
  double fastest_ = 0, fastest_spin_ = 0;
};

// The largest pull that a gripper's phases, or without any itself, ask for.
double StrongestPull(const SceneGripper& gripper, const std::vector<Phase>& phases);

// One tentacle's pull. From the start of each phase that names a pull, it goes to that at the phase's rate
// and stays; its first motion begins with the tentacle's delay. Where no phase names one, or there is none,
// it goes to the gripper's.
class PullSchedule {
 public:
  //   delay, rate  the tentacle's own, s and 1/s; a phase's rate is changed in the share that its own is of
  //                the gripper's
  //   earliest     nothing is pulled before, s
  PullSchedule(const SceneGripper& gripper, const std::vector<Phase>& phases, double delay, double rate,
               double earliest = 0);

  double At(double time) const;
  double RateAt(double time) const;  // 1/s, below 0 where it is let go

 private:
  struct Leg {
    double named = 0;  // when it is told to go, s
    double from = 0;   // when it goes
    double value = 0;  // before
    double way = 0;    // to go, above 0
    double sign = 1;   // the way's
    double rate = 0;   // > 0
  };
  const Leg& LegAt(double time) const;

  std::vector<Leg> legs_;
};

}  // namespace tendril
