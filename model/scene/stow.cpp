#include "model/scene/stow.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "model/scene/plan.h"
#include "model/scene/schedule.h"

namespace tendril {
namespace {

using std::numbers::pi;

constexpr double kMostTurn = 1.5;  // of an element against the next, rad
constexpr int kFiner = 32;         // steps of the integration to half an element

double RadiusAt(const RodDesign& design, double from_base) {
  return design.base_radius * (1 - (1 - design.taper) * std::clamp(from_base / design.length, 0.0, 1.0));
}

struct Spiral {
  Eigen::VectorXd tangent;  // its direction at the base, then in the middle of each element, rad (N+1)
  double turns = 0;
};

// From the tip outward. The pitch is that of the layer one turn farther out, which is no thinner than the
// mean of the two; along the spiral's slope layers are nearer by its cosine, and straight elements by their
// sagitta.
Spiral SpiralOf(const RodDesign& design, double inner_radius, double gap) {
  const double element = design.length / design.elements;
  const double step = 0.5 * element / kFiner;
  const auto climb = [&](double radius, double from_tip) {  // d radius / d angle
    const double here = RadiusAt(design, design.length - from_tip);
    const double turn_on = from_tip + 2 * pi * (radius + 2 * here + gap);
    const double thick = std::max(here, RadiusAt(design, design.length - turn_on));
    const double flat = (2 * thick + gap + element * element / (8 * radius)) / (2 * pi);
    return flat * std::hypot(1.0, flat / radius);
  };
  Spiral spiral;
  spiral.tangent.resize(design.elements + 1);
  double radius = inner_radius, angle = 0;
  const int halves = 2 * design.elements;
  for (int half = 0; half <= halves; ++half) {
    const double from_tip = 0.5 * element * half;
    if (half % 2 == 1 || half == halves) {
      spiral.tangent[(halves - half + 1) / 2] = angle + std::atan2(radius, climb(radius, from_tip));
    }
    for (int i = 0; half < halves && i < kFiner; ++i) {
      const double at = from_tip + step * i;
      const double up = climb(radius, at), slow = std::hypot(radius, up);
      const double middle = radius + 0.5 * step * up / slow;
      const double up_there = climb(middle, at + 0.5 * step), slow_there = std::hypot(middle, up_there);
      radius += step * up_there / slow_there;
      angle += step / slow_there;
    }
  }
  spiral.turns = angle / (2 * pi);
  return spiral;
}

}  // namespace

Result<Eigen::Matrix3Xd> RolledCurvature(const RodDesign& design, const Stow& stow, double side) {
  const double element = design.length / design.elements;
  const double tip = RadiusAt(design, design.length);
  // The innermost turn's sides do not meet, and a thick rod curves no tighter than it is thick.
  const double least = std::max(2 * tip + 0.5 * stow.gap, element / (0.9 * kMostTurn));
  double inner = stow.inner_radius;
  if (stow.turns > 0) {
    const double most = SpiralOf(design, least, stow.gap).turns;
    if (stow.turns > most) {
      return Error{ErrorKind::kBadInput, "stowed.turns = " + ShortNumber(stow.turns) + ": expected at most " +
                                             ShortNumber(most) + ", for which the rod is long enough"};
    }
    double low = least, high = std::max(2 * least, design.length / (2 * pi * stow.turns));
    while (SpiralOf(design, high, stow.gap).turns > stow.turns) high *= 2;
    for (int i = 0; i < 60 && high - low > 1e-12 * high; ++i) {
      inner = 0.5 * (low + high);
      (SpiralOf(design, inner, stow.gap).turns > stow.turns ? low : high) = inner;
    }
  }
  if (!(inner >= least)) {
    return Error{ErrorKind::kBadInput, "stowed.inner_radius = " + ShortNumber(inner) + " m: expected " +
                                           ShortNumber(least) +
                                           " m or more: the tip's thickness, and what elements can follow"};
  }
  const Spiral spiral = SpiralOf(design, inner, stow.gap);
  Eigen::Matrix3Xd curvature = Eigen::Matrix3Xd::Zero(3, design.elements);
  for (Eigen::Index i = 0; i < design.elements; ++i) {
    const double length = i == 0 ? 0.5 * element : element;
    curvature(1, i) = side * (spiral.tangent[i] - spiral.tangent[i + 1]) / length;
  }
  return curvature;
}

double RolledShare(const Stow& stow, double time) {
  if (time < stow.release_time) return 1;
  if (!(stow.unroll_time > 0)) return 0;
  return 1 - SmoothShare((time - stow.release_time) / stow.unroll_time);
}

}  // namespace tendril
