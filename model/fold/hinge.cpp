#include "model/fold/hinge.h"

#include <algorithm>
#include <cmath>

namespace tendril {
namespace {

// x - sin x without cancellation, for x in [0, pi/2].
double MinusSine(double x) {
  if (x > 1) return x - std::sin(x);
  const double y = x * x;
  double sum = 1;
  for (int k = 17; k >= 5; k -= 2) sum = 1 - sum * y / ((k - 1) * k);
  return x * y / 6 * sum;
}

// s phi / g - 1 = T / critical - 1 of a crease that rests flat: rises from 0, as a product of two factors
// whose excesses over 1 are known without cancellation.
double Excess(const Hinge& hinge, double angle) {
  const double sine = std::sin(angle);
  const double p = MinusSine(angle) / sine;
  if (hinge.c == 0) return p;
  const double cosine = std::cos(angle);
  const double r = hinge.c * sine * sine / (cosine * (Root(hinge, sine, cosine) + cosine));
  return p + r + p * r;
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

double LogSlope(const Hinge& hinge, double angle) {
  const double sine = std::sin(angle);
  const double half = std::sin(0.5 * angle);
  const double first = (2 * angle * half * half - MinusSine(angle)) / (angle * sine);
  if (hinge.c == 0) return first;
  const double cosine = std::cos(angle);
  const double root = Root(hinge, sine, cosine);
  return first + hinge.c * sine / (cosine * root * root);
}

double ExcessCoefficient(const Hinge& hinge) { return 1.0 / 6 + 0.5 * hinge.c; }

// Newton's method on the logarithms, kept between bounds.
double AngleOfExcess(const Hinge& hinge, double x) {
  double angle = std::sqrt(x / ExcessCoefficient(hinge));  // above the root: higher terms are positive
  if (angle < 1e-8) return angle;
  double low = 0;
  double high = hinge.limit;
  if (!(angle < high)) angle = 0.5 * high;
  const double wanted = std::log1p(x);
  for (int iteration = 0; iteration < 100; ++iteration) {
    const double off = std::log1p(Excess(hinge, angle)) - wanted;
    (off > 0 ? high : low) = angle;
    const double step = off / LogSlope(hinge, angle);
    if (std::abs(step) <= 2e-16 * angle) break;
    double next = angle - step;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (next == angle) break;
    angle = next;
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

}  // namespace tendril
