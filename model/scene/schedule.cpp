#include "model/scene/schedule.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/check.h"
#include "model/geometry/rotation.h"

namespace tendril {
namespace {

using Eigen::Vector3d;

constexpr double kSteepest = 1.875;  // of SmoothShare, at s = 1/2

double SmoothSlope(double s) { return s > 0 && s < 1 ? 30 * s * s * (1 - s) * (1 - s) : 0; }

bool Shakes(const Phase& phase) { return phase.shake_frequency > 0 && !phase.shake_amplitude.isZero(0); }

// A shake is faded in and out over one period each, or half the phase where that is shorter.
double FadeTime(const Phase& phase) { return std::min(1 / phase.shake_frequency, 0.5 * phase.duration); }

struct ShakeState {
  double value = 0, rate = 0;  // of the amplitude
};
ShakeState ShakeAt(const Phase& phase, double into) {
  const double fade = FadeTime(phase), left = phase.duration - into;
  const double share = std::min(into, left) / fade;
  const double window = SmoothShare(share), steep = SmoothSlope(share) / fade * (into <= left ? 1 : -1);
  const double omega = 2 * std::numbers::pi * phase.shake_frequency;
  const double sine = std::sin(omega * into), cosine = std::cos(omega * into);
  return {window * sine, steep * sine + window * omega * cosine};
}

Eigen::Matrix3d TurnOf(const Phase& phase, double share) {
  return ExpSo3(share * phase.turn * phase.turn_axis.normalized());
}

}  // namespace

void AddPhase(Scene& scene, Phase phase) {
  if (scene.phases.empty()) {
    Phase pull;
    pull.name = "pull";
    pull.duration = scene.duration;
    if (scene.gripper) pull.pull = scene.gripper->pull;
    scene.phases.push_back(std::move(pull));
  }
  scene.phases.push_back(std::move(phase));
  scene.duration = 0;
  for (const Phase& one : scene.phases) scene.duration += one.duration;
}

double SmoothShare(double s) {
  if (!(s > 0)) return 0;
  if (s >= 1) return 1;
  return s * s * s * (10 + s * (6 * s - 15));
}

Schedule::Schedule(std::vector<Phase> phases) : phases_(std::move(phases)) {
  TENDRIL_CHECK(!phases_.empty());
  starts_.push_back(0);
  offsets_.push_back(Vector3d::Zero());
  turneds_.push_back(Eigen::Matrix3d::Identity());
  for (const Phase& phase : phases_) {
    TENDRIL_CHECK(phase.duration > 0);
    const bool turns = phase.turn != 0, shakes = Shakes(phase);
    moves_ = moves_ || turns || shakes || !phase.move.isZero(0);
    turns_ = turns_ || turns;
    const double way = phase.move.norm();
    double speed = kSteepest * way / phase.duration;
    if (shakes) {
      speed += phase.shake_amplitude.norm() *
               (2 * std::numbers::pi * phase.shake_frequency + kSteepest / FadeTime(phase));
    }
    starts_.push_back(starts_.back() + phase.duration);
    offsets_.push_back(offsets_.back() + phase.move);
    turneds_.push_back(turns ? Eigen::Matrix3d(TurnOf(phase, 1) * turneds_.back()) : turneds_.back());
    fastest_ = std::max(fastest_, speed);
    fastest_spin_ = std::max(fastest_spin_, kSteepest * std::abs(phase.turn) / phase.duration);
  }
}

std::size_t Schedule::PhaseAt(double time) const {
  const auto next = std::upper_bound(starts_.begin() + 1, starts_.end() - 1, time);
  return static_cast<std::size_t>(next - starts_.begin()) - 1;
}

CarrierMotion Schedule::At(double time) const {
  const std::size_t k = PhaseAt(time);
  const Phase& phase = phases_[k];
  const double into = std::clamp(time - starts_[k], 0.0, phase.duration);
  const double share = into / phase.duration;
  const double way = SmoothShare(share), rate = SmoothSlope(share) / phase.duration;
  CarrierMotion motion;
  motion.offset = share < 1 ? Vector3d(offsets_[k] + way * phase.move) : offsets_[k + 1];
  motion.velocity = rate * phase.move;
  if (Shakes(phase) && into > 0 && share < 1) {
    const ShakeState shake = ShakeAt(phase, into);
    motion.offset += shake.value * phase.shake_amplitude;
    motion.velocity += shake.rate * phase.shake_amplitude;
  }
  motion.turned = turneds_[k];
  if (phase.turn != 0) {
    motion.turned = share < 1 ? Eigen::Matrix3d(TurnOf(phase, way) * turneds_[k]) : turneds_[k + 1];
    motion.spin = rate * phase.turn * phase.turn_axis.normalized();
  }
  return motion;
}

double StrongestPull(const SceneGripper& gripper, const std::vector<Phase>& phases) {
  bool named = false;
  double strongest = 0;
  for (const Phase& phase : phases) {
    named = named || phase.pull.has_value();
    strongest = std::max(strongest, phase.pull.value_or(0));
  }
  return named ? strongest : gripper.pull;
}

PullSchedule::PullSchedule(const SceneGripper& gripper, const std::vector<Phase>& phases, double delay,
                           double rate, double earliest) {
  double start = 0;
  bool moved = false;
  const auto go = [&](double to, double at_rate) {
    Leg leg;
    leg.named = start;
    leg.from = std::max(start, earliest);
    leg.value = legs_.empty() ? 0 : At(leg.from);
    leg.sign = to < leg.value ? -1 : 1;
    leg.way = std::abs(to - leg.value);
    leg.rate = at_rate;
    if (!moved && leg.way > 0) {
      leg.from += delay;
      moved = true;
    }
    legs_.push_back(leg);
  };
  for (const Phase& phase : phases) {
    const double own = phase.pull_rate > 0 ? phase.pull_rate * (rate / gripper.pull_rate) : rate;
    if (phase.pull) go(*phase.pull, own);
    start += phase.duration;
  }
  if (!legs_.empty()) return;
  start = 0;
  go(gripper.pull, rate);
}

const PullSchedule::Leg& PullSchedule::LegAt(double time) const {
  const auto next = std::upper_bound(legs_.begin() + 1, legs_.end(), time,
                                     [](double at, const Leg& leg) { return at < leg.named; });
  return *(next - 1);
}

double PullSchedule::At(double time) const {
  const Leg& leg = LegAt(time);
  return leg.value + leg.sign * std::clamp(leg.rate * (time - leg.from), 0.0, leg.way);
}

double PullSchedule::RateAt(double time) const {
  const Leg& leg = LegAt(time);
  const double gone = leg.rate * (time - leg.from);
  return gone > 0 && gone < leg.way ? leg.sign * leg.rate : 0;
}

}  // namespace tendril
