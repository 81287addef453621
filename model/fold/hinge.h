#pragma once
// One crease as a hinge that a tendon folds: what it takes in, and how far it folds under a tension. Internal
// to the laws that balance creases against tension (exact_law.h, tendon_friction.h; docs/physics.md).

#include <Eigen/Core>
#include <numbers>

#include "model/fold/design.h"

namespace tendril {

// A closed angle from here on is a right angle: perpendicular creases' holes meet, oblique ones' only tend
// to.
inline constexpr double kClosedFlat = std::numbers::pi / 2;

// One crease: s = sin^2 a, c = cos^2 a; c is exactly 0 for a right angle, which pi / 2 as a double stands
// for.
struct Hinge {
  double d = 0;  // half of its spacing, m
  double s = 1, c = 0;
  double sin_2a = 0;
  double stiffness = 0;  // B, N m
  double rest = 0;       // phi0, rad
  double limit = 0;      // phi_max, rad
  double critical = 0;   // the tension at which it begins to fold from flat, N
  double closing = 0;    // the tension at which it closes, N
};

Hinge HingeOf(const TentacleLayout& layout, Eigen::Index crease, double stiffness, double rest_angle,
              double closed_angle);

// Half its holes' distance over d: sqrt(1 - s sin^2 phi).
double Root(const Hinge& hinge, double sine, double cosine);

// g = s sin cos / sqrt(1 - s sin^2): moment of the tendon / (T d).
double Moment(const Hinge& hinge, double angle);

// d g / d phi.
double MomentSlope(const Hinge& hinge, double angle);

// d ln(phi / g) / d phi > 0.
double LogSlope(const Hinge& hinge, double angle);

// First coefficient of s phi / g - 1 = k phi^2 + ...
double ExcessCoefficient(const Hinge& hinge);

// phi of a crease that rests flat, from its excess x = T / critical - 1 >= 0; below the limit.
double AngleOfExcess(const Hinge& hinge, double x);

// phi - phi0 of a crease that rests folded, from T d / (2 B); below the limit.
double TurnOfLoad(const Hinge& hinge, double load);

// phi at a tension, phi0 .. phi_max. Just above `critical` it has no more digits than the tension's excess
// has.
double AngleAt(const Hinge& hinge, double tension);

// By how much its holes draw together from an angle to angle + turn, without cancellation, m.
double TakenIn(const Hinge& hinge, double from, double turn);

// Distance between its holes, m.
double HoleDistance(const Hinge& hinge, double angle);

// A direction in which a hinge changes.
struct HingeChange {
  double log_stiffness = 0, half_spacing = 0, crease_angle = 0, rest_angle = 0;
};

// Its angle's derivative along a change is LogGive (d ln T + LogPush); it stays where it is flat or closed
// (LogGive is 0, LogPush not to be asked).
double LogGive(const Hinge& hinge, double angle);
double LogPush(const Hinge& hinge, double angle, const HingeChange& change);

// The derivative of HoleDistance at a fixed angle, m.
double HoleDistanceChange(const Hinge& hinge, double angle, const HingeChange& change);

}  // namespace tendril
