#pragma once
// Forces from outside on a scene's objects over time.

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace tendril {

enum class PushShape {
  kSteady,
  kRamp,   // from 0, linearly to the force
  kPulse,  // half a sine: at its middle the force
};

// At an object's centre of mass, while from <= time < until.
struct Push {
  std::size_t object = 0;
  double from = 0, until = 0;                       // s
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  // lab, N
  PushShape shape = PushShape::kSteady;
};

inline Eigen::Vector3d ForceAt(const Push& push, double time) {
  if (time < push.from || time >= push.until) return Eigen::Vector3d::Zero();
  const double share = (time - push.from) / (push.until - push.from);
  return (push.shape == PushShape::kRamp    ? share
          : push.shape == PushShape::kPulse ? std::sin(std::numbers::pi * share)
                                            : 1) *
         push.force;
}

}  // namespace tendril
