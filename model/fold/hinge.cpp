#include "model/fold/hinge.h"

#include <algorithm>
#include <cmath>

namespace tendril {
namespace {

// x - sin x without cancellation, for x in [0, pi/2].
double MinusSine(double x, double sine) {
  if (x > 1) return x - sine;
  const double y = x * x;
  // The series' quotients 1 / ((k - 1) k), k = 17, 15, .. 5.
  constexpr double kQuotients[] = {1.0 / 272, 1.0 / 210, 1.0 / 156, 1.0 / 110, 1.0 / 72, 1.0 / 42, 1.0 / 20};
  double sum = 1;
  for (const double quotient : kQuotients) sum = 1 - sum * y * quotient;
  return x * y * (1.0 / 6) * sum;
}

// Of a crease that rests flat: how far T is above its critical tension, and how fast that changes.
struct Loaded {
  double excess = 0;  // s phi / g - 1 = T / critical - 1, a product of two factors whose excesses over 1 are
                      // known without cancellation
  double log_slope = 0;  // d ln(phi / g) / d phi > 0
};

Loaded LoadedAt(const Hinge& hinge, double angle) {
  const double sine = std::sin(angle);
  const double cosine = std::cos(angle);
  const double minus_sine = MinusSine(angle, sine);
  const double p = minus_sine / sine;
  const double first = (angle * sine * sine / (1 + cosine) - minus_sine) / (angle * sine);
  if (hinge.c == 0) return {p, first};
  const double root = Root(hinge, sine, cosine);
  const double r = hinge.c * sine * sine / (cosine * (root + cosine));
  return {p + r + p * r, first + hinge.c * sine / (cosine * root * root)};
}

}  // namespace

Hinge HingeOf(const TentacleLayout& layout, Eigen::Index crease, double stiffness, double rest_angle,
              double closed_angle) {
  Hinge hinge;
  hinge.d = layout.half_spacing[crease];
  const double cosine = std::cos(layout.crease_angle[crease]);
  if (std::abs(cosine) > 1e-15) {
    const double sine = std::sin(layout.crease_angle[crease]);
    hinge.c = cosine * cosine;
    hinge.s = sine * sine;
    hinge.sin_2a = 2 * sine * cosine;
  }
  hinge.stiffness = stiffness;
  hinge.rest = rest_angle;
  hinge.limit = std::min(closed_angle, kClosedFlat);
  hinge.critical = 2 * stiffness / (hinge.d * hinge.s);
  const double moment = hinge.limit == kClosedFlat && hinge.c > 0 ? 0 : Moment(hinge, hinge.limit);
  hinge.closing = 2 * stiffness * (hinge.limit - rest_angle) / (hinge.d * moment);
  return hinge;
}

double Root(const Hinge& hinge, double sine, double cosine) {
  return std::sqrt(cosine * cosine + hinge.c * sine * sine);  // sqrt(1 - s sin^2)
}

double Moment(const Hinge& hinge, double angle) {
  const double sine = std::sin(angle);
  if (hinge.c == 0) return sine;
  const double cosine = std::cos(angle);
  return hinge.s * sine * cosine / Root(hinge, sine, cosine);
}

double LogSlope(const Hinge& hinge, double angle) { return LoadedAt(hinge, angle).log_slope; }

double ExcessCoefficient(const Hinge& hinge) { return 1.0 / 6 + 0.5 * hinge.c; }

// Newton's method on the logarithms, kept between bounds, from the first two terms of the excess, k y + m y^2
// in y = phi^2, inverted.
double AngleOfExcess(const Hinge& hinge, double x) {
  const double k = ExcessCoefficient(hinge);
  const double m = 7.0 / 360 + hinge.c * (5.0 / 12 - 0.125 * hinge.c);
  double angle = std::sqrt(x / (k + m / k * x));
  if (angle < 1e-8) return angle;
  double low = 0;
  double high = hinge.limit;
  if (!(angle < high)) angle = 0.5 * high;
  for (int iteration = 0; iteration < 100; ++iteration) {
    const Loaded at = LoadedAt(hinge, angle);
    const double off = std::log1p((at.excess - x) / (1 + x));
    (off > 0 ? high : low) = angle;
    const double step = off / at.log_slope;
    if (std::abs(step) <= 2e-16 * angle) break;
    double next = angle - step;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (next == angle) break;
    angle = next;
    // Quadratic convergence, in the distance from either end: the rest is below rounding.
    if (std::abs(step) <= 1e-9 * std::min(angle, kClosedFlat - angle)) break;
  }
  return angle;
}

double TurnOfLoad(const Hinge& hinge, double load) {
  const double rest = hinge.rest;
  double low = 0;
  double high = hinge.limit - rest;
  double turn = std::min(load * Moment(hinge, rest), 0.5 * high);
  for (int iteration = 0; iteration < 100; ++iteration) {
    const double angle = rest + turn;
    const double off = turn - load * Moment(hinge, angle);
    (off > 0 ? high : low) = turn;
    const double step = off / (1 - load * MomentSlope(hinge, angle));
    if (std::abs(step) <= 2e-16 * turn) break;
    double next = turn - step;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (next == turn) break;
    turn = next;
  }
  return turn;
}

double MomentSlope(const Hinge& hinge, double angle) {
  const double sine = std::sin(angle);
  const double cosine = std::cos(angle);
  if (hinge.c == 0) return cosine;
  const double root = Root(hinge, sine, cosine);
  return hinge.s * ((cosine * cosine - sine * sine) / root +
                    hinge.s * sine * sine * cosine * cosine / (root * root * root));
}

double AngleAt(const Hinge& hinge, double tension) {
  if (tension >= hinge.closing) return hinge.limit;
  if (hinge.rest > 0) return hinge.rest + TurnOfLoad(hinge, tension * hinge.d / (2 * hinge.stiffness));
  return tension > hinge.critical ? AngleOfExcess(hinge, (tension - hinge.critical) / hinge.critical) : 0.0;
}

double TakenIn(const Hinge& hinge, double from, double turn) {
  const double before = Root(hinge, std::sin(from), std::cos(from));
  const double after = Root(hinge, std::sin(from + turn), std::cos(from + turn));
  return 2 * hinge.d * hinge.s * std::sin(turn) * std::sin(turn + 2 * from) / (before + after);
}

double HoleDistance(const Hinge& hinge, double angle) {
  if (angle == kClosedFlat) return 2 * hinge.d * std::sqrt(hinge.c);
  return 2 * hinge.d * Root(hinge, std::sin(angle), std::cos(angle));
}

double LogGive(const Hinge& hinge, double angle) {
  const double turn = angle - hinge.rest;
  if (angle == hinge.limit || turn == 0) return 0;
  // 1 / (ln((phi - phi0) / g))'; the first form, of a crease that rests flat, does not cancel.
  return 1 / (LogSlope(hinge, angle) + (hinge.rest > 0 ? 1 / turn - 1 / angle : 0.0));
}

double LogPush(const Hinge& hinge, double angle, const HingeChange& change) {
  const double sine = std::sin(angle);
  const double root = Root(hinge, sine, std::cos(angle));
  // d ln g / d a
  const double by_crease = hinge.sin_2a / hinge.s + 0.5 * hinge.sin_2a * sine * sine / (root * root);
  return change.rest_angle / (angle - hinge.rest) - change.log_stiffness + change.half_spacing / hinge.d +
         by_crease * change.crease_angle;
}

double HoleDistanceChange(const Hinge& hinge, double angle, const HingeChange& change) {
  double change_of_distance = change.half_spacing * HoleDistance(hinge, angle) / hinge.d;
  if (hinge.sin_2a == 0) return change_of_distance;
  const double sine = std::sin(angle);
  const double root = Root(hinge, sine, std::cos(angle));
  return change_of_distance - hinge.d * hinge.sin_2a * sine * sine / root * change.crease_angle;
}

}  // namespace tendril
