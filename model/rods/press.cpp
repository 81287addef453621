#include "model/rods/press.h"

#include <algorithm>
#include <cmath>

namespace tendril {
namespace {

using Eigen::Vector3d;

// An element, and what half of the energy does to it.
struct Loaded {
  const PressSide& it;
  Vector3d& start_force;
  Vector3d& end_force;
  Vector3d push = Vector3d::Zero();  // what is across the axes
  double at = 0;                     // sum of where on the axis, weighed by what presses there
};

// Half of the energy: points of `one` against the whole of `other`.
//   returns  the sum of the weights
double AddHalf(double factor, int points, double radii, Loaded& one_side, Loaded& other_side, Press& press) {
  const PressSide &one = one_side.it, &other = other_side.it;
  double sum = 0;
  const Vector3d edge = other.end - other.start;
  const double length = edge.norm();
  if (!(length > 0)) return sum;
  const Vector3d along = edge / length;
  const double weight = factor * one.rest_length / points;
  for (int k = 0; k < points; ++k) {
    const double at = (k + 0.5) / points;
    const Vector3d between = (1 - at) * one.start + at * one.end - other.start;
    const double foot = between.dot(along);
    const Vector3d across = between - foot * along;
    const double c2 = radii * radii - across.squaredNorm();
    if (!(c2 > 0)) continue;
    const double c = std::sqrt(c2);
    const double from = std::clamp(-foot, -c, c), to = std::clamp(length - foot, -c, c);
    if (!(to > from)) continue;
    const double piece = c2 * (to - from) - (to * to * to - from * from * from) / 3;
    const double steep = weight * (piece / (2 * c) + c * (to - from));  // d energy / d c^2
    const double at_to = weight * c * (c2 - to * to), at_from = weight * c * (c2 - from * from);
    const Vector3d push = 2 * steep * across;
    const Vector3d force = push + (at_to - at_from) * along;
    const double share = foot / length;
    const Vector3d turn = (at_from - at_to) / length * across;
    press.presses = true;
    press.energy += weight * c * piece;
    one_side.start_force += (1 - at) * force;
    one_side.end_force += at * force;
    other_side.start_force += -(1 - share) * push + turn + at_from * along;
    other_side.end_force += -share * push - turn - at_to * along;
    one_side.push += push;
    sum += steep;
    one_side.at += steep * at;
    other_side.at += steep * (foot + 0.5 * (from + to)) / length;
    press.stiffness += weight * 32. / 3 * radii * radii * 0.75 * piece / (c * c2);
  }
  return sum;
}

}  // namespace

Press PressOf(double stiffness, int points, const PressSide& a, const PressSide& b) {
  Press press;
  press.a_start = press.a_end = press.b_start = press.b_end = Vector3d::Zero();
  const double radii = a.radius + b.radius;
  const double factor = PressFactor(stiffness, radii);
  Loaded one{a, press.a_start, press.a_end}, other{b, press.b_start, press.b_end};
  double sum = AddHalf(factor, points, radii, one, other, press);
  sum += AddHalf(factor, points, radii, other, one, press);
  if (!press.presses) return press;
  press.normal_force = one.push - other.push;
  press.stick_stiffness = StickStiffness(factor, radii, a.rest_length + b.rest_length);
  // Axes that cross: no normal, and no force across.
  if (sum > 0) {
    press.a_share = one.at / sum;
    press.b_share = other.at / sum;
  }
  return press;
}

double PressFactor(double stiffness, double radii_sum) {
  return 0.5 * 9. / 64 * stiffness / (radii_sum * std::pow(2 * radii_sum, 1.5));
}

double StickStiffness(double factor, double radii_sum, double rest_lengths_sum) {
  return factor * 32. / 3 * radii_sum * radii_sum * rest_lengths_sum;
}

double ReferenceStiffness(double stiffness, double radii_sum) {
  return 1.5 * stiffness * std::sqrt(0.05 * radii_sum);
}

double SurfaceStiffness(double stiffness, double radius) { return 0.75 * stiffness / std::sqrt(4 * radius); }

}  // namespace tendril
