#include "model/fold/exact_law.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "model/check.h"
#include "model/fold/hinge.h"

namespace tendril {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string Number(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value);
  return {text, end.ptr};
}

// All creases at one tension, which is kept as base + extra: near a tension where creases begin to fold their
// angles are all in the extra.
class Tentacle {
 public:
  Tentacle(const TentacleLayout& layout, const Eigen::VectorXd& stiffness, double rest, double closed_angle)
      : rest_(rest), right_angle_(closed_angle >= kClosedFlat), limit_(std::min(closed_angle, kClosedFlat)) {
    for (Eigen::Index i = 0; i < stiffness.size(); ++i) {
      const Hinge hinge = HingeOf(layout, i, stiffness[i], rest, closed_angle);
      hinges_.push_back(hinge);
      flat_ += 2 * hinge.d;
      at_rest_ += TakenIn(hinge, 0, rest_);
    }
    angle_.resize(stiffness.size());
  }

  double flat() const { return flat_; }
  double at_rest() const { return at_rest_; }  // shortening of the rest shape, m
  const Eigen::VectorXd& angle() const { return angle_; }
  const std::vector<Hinge>& hinges() const { return hinges_; }
  bool right_angle() const { return right_angle_; }
  double limit() const { return limit_; }

  struct Sums {
    double shortening = 0;  // beyond the rest shape's, m
    double remaining = 0;   // hole to hole, m
    double slope = 0;       // of the shortening by the tension, m/N
  };

  // Sets the angles.
  Sums At(double base, double extra) {
    Sums sums;
    for (std::size_t i = 0; i < hinges_.size(); ++i) {
      const Hinge& hinge = hinges_[i];
      double turn = 0;  // phi - phi0
      double turn_slope = 0;
      const double tension = base + extra;
      if (tension >= hinge.closing) {
        turn = limit_ - rest_;
      } else if (rest_ > 0) {
        turn = TurnOfLoad(hinge, tension * hinge.d / (2 * hinge.stiffness));
        turn_slope = TurnSlope(hinge, rest_ + turn, tension);
      } else {
        const double x = (base - hinge.critical) / hinge.critical + extra / hinge.critical;
        if (x >= 0) {
          turn = AngleOfExcess(hinge, x);
          // At the very start the slope is infinite, that of the shortening finite: the limit is added below.
          if (turn > 1e-8)
            turn_slope = 1 / (tension * LogSlope(hinge, turn));
          else
            sums.slope += hinge.d * hinge.s / (ExcessCoefficient(hinge) * hinge.critical);
        }
      }
      const double angle = turn == limit_ - rest_ ? limit_ : rest_ + turn;
      angle_[static_cast<Eigen::Index>(i)] = angle;
      sums.shortening += TakenIn(hinge, rest_, turn);
      sums.remaining += HoleDistance(hinge, angle);
      sums.slope += 2 * hinge.d * Moment(hinge, angle) * turn_slope;
    }
    return sums;
  }

 private:
  static double TurnSlope(const Hinge& hinge, double angle, double tension) {
    const double per_load = hinge.d / (2 * hinge.stiffness);
    return per_load * Moment(hinge, angle) / (1 - tension * per_load * MomentSlope(hinge, angle));
  }

  double rest_ = 0;
  bool right_angle_ = true;
  double limit_ = kClosedFlat;
  std::vector<Hinge> hinges_;
  double flat_ = 0;
  double at_rest_ = 0;
  Eigen::VectorXd angle_;
};

struct Tension {
  double base = 0;
  double extra = 0;
};

// How much the shortening at a tension exceeds what is wanted, m. Past half of the pull the lengths that
// remain are compared: they keep their digits.
class Wanted {
 public:
  Wanted(const Tentacle& tentacle, double pull)
      : by_remaining_(pull > 0.5),
        length_(by_remaining_ ? (1 - pull) * tentacle.flat() : pull * tentacle.flat() - tentacle.at_rest()) {}
  double Excess(const Tentacle::Sums& sums) const {
    return by_remaining_ ? length_ - sums.remaining : sums.shortening - length_;
  }

 private:
  bool by_remaining_;
  double length_;
};

// Between two tensions at which creases begin to fold or close, the shortening is smooth in the tension.
Tension SolveTension(Tentacle& tentacle, const Wanted& wanted, double rest) {
  std::vector<double> events;
  for (const Hinge& hinge : tentacle.hinges()) {
    if (rest == 0) events.push_back(hinge.critical);
    if (std::isfinite(hinge.closing)) events.push_back(hinge.closing);
  }
  if (rest > 0) events.push_back(0);
  std::sort(events.begin(), events.end());
  events.erase(std::unique(events.begin(), events.end()), events.end());
  const auto after = std::partition_point(events.begin() + 1, events.end(), [&](double tension) {
    return wanted.Excess(tentacle.At(tension, 0)) <= 0;
  });
  const double base = *(after - 1);

  double low = 0;
  double high = after == events.end() ? kInfinity : *after - base;
  const double scale = base > 0 ? base : tentacle.hinges().front().critical;
  Tentacle::Sums sums = tentacle.At(base, 0);
  double extra = -wanted.Excess(sums) / sums.slope;
  if (!(extra > 0)) return {base, 0};
  if (!(extra < high)) extra = std::isfinite(high) ? 0.5 * high : scale;
  for (int iteration = 0; iteration < 400; ++iteration) {
    sums = tentacle.At(base, extra);
    const double off = wanted.Excess(sums);
    (off > 0 ? high : low) = extra;
    const double step = off / sums.slope;
    if (std::abs(step) <= 2e-16 * extra) break;
    double next = extra - step;
    if (!(next > low && next < high)) {
      next = !std::isfinite(high) ? 4 * extra : low > 0 ? std::sqrt(low) * std::sqrt(high) : 0.5 * high;
      if (!(next > low && next < high)) break;  // neighbouring doubles
    }
    extra = next;
    if (!(extra < 1e300)) break;
  }
  return {base, extra};
}

}  // namespace

Eigen::VectorXd HingeStiffness(const TentacleDesign& design, const TentacleLayout& layout) {
  const double thickness3 = design.thickness * design.thickness * design.thickness;
  const double of_base_width =
      design.youngs_modulus * design.base_width * thickness3 / (12 * design.crease_length);
  return of_base_width * layout.stiffness.array() / layout.crease_angle.array().sin();
}

double LargestExactPull(const TentacleLayout& layout, double closed_angle) {
  const Tentacle tentacle(layout, Eigen::VectorXd::Ones(layout.half_spacing.size()), 0, closed_angle);
  double remaining = 0;
  for (const Hinge& hinge : tentacle.hinges()) remaining += HoleDistance(hinge, tentacle.limit());
  return 1 - remaining / tentacle.flat();
}

Result<ExactFold> SolveExactFold(const TentacleLayout& layout, const Eigen::VectorXd& hinge_stiffness,
                                 double rest_angle, double closed_angle, double pull) {
  const Eigen::Index creases = layout.half_spacing.size();
  TENDRIL_CHECK(creases > 0 && hinge_stiffness.size() == creases && hinge_stiffness.minCoeff() > 0);
  const double largest = LargestExactPull(layout, closed_angle);
  if (!(pull >= 0) || !std::isfinite(pull)) {
    return Error{ErrorKind::kBadInput,
                 "pull = " + Number(pull) + ": expected a fraction, 0 to " + Number(largest)};
  }
  if (!(rest_angle >= 0 && rest_angle < std::min(closed_angle, kClosedFlat))) {
    return Error{ErrorKind::kBadInput,
                 "rest angle " + Number(rest_angle) + " rad: expected 0 up to the closed angle for this law"};
  }
  if (pull > largest) {
    return Error{ErrorKind::kUnreachable, "pull = " + Number(pull) +
                                              " is beyond reach: every crease is closed at pull " +
                                              Number(largest) + ", the largest possible"};
  }
  Tentacle tentacle(layout, hinge_stiffness, rest_angle, closed_angle);
  ExactFold fold;
  fold.closing_moment.setZero(creases);
  Tension tension;
  if (pull * tentacle.flat() <= tentacle.at_rest()) {
    fold.slack = pull * tentacle.flat() < tentacle.at_rest();
    tentacle.At(0, 0);
  } else if (pull == largest) {
    tension.base = 0;
    for (const Hinge& hinge : tentacle.hinges()) tension.base = std::max(tension.base, hinge.closing);
    tentacle.At(tension.base, 0);
  } else {
    tension = SolveTension(tentacle, Wanted(tentacle, pull), rest_angle);
    tentacle.At(tension.base, tension.extra);
  }
  fold.tension = tension.base + tension.extra;
  fold.angle = tentacle.angle();
  for (Eigen::Index i = 0; i < creases; ++i) {
    const Hinge& hinge = tentacle.hinges()[static_cast<std::size_t>(i)];
    fold.tendon_length += HoleDistance(hinge, fold.angle[i]);
    if (fold.angle[i] != tentacle.limit()) continue;
    fold.closed.push_back(static_cast<int>(i));
    const bool only_tends = tentacle.right_angle() && hinge.c > 0;
    if (only_tends) continue;
    fold.closing_moment[i] = std::max(0.0, fold.tension * hinge.d * Moment(hinge, fold.angle[i]) -
                                               2 * hinge.stiffness * (fold.angle[i] - rest_angle));
  }
  return fold;
}

Result<ExactFold> SolveExactFold(const TentacleDesign& design, double pull) {
  const Result<TentacleLayout> layout = LayOut(design);
  if (!layout.ok()) return layout.error();
  return SolveExactFold(layout.value(), HingeStiffness(design, layout.value()), design.rest_angle,
                        design.closed_angle, pull);
}

}  // namespace tendril
