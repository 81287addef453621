#include "model/fold/tendon_friction.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "model/fold/exact_law.h"
#include "model/fold/facet_chain.h"
#include "model/fold/tendon_chord.h"

namespace tendril {
namespace {

constexpr double kLargestStep = 0.01;  // of pull

// The tendon's deflection at the hole before each crease, rad; 0 for crease 0.
Eigen::VectorXd DeflectionOf(const TentacleLayout& layout, const Eigen::VectorXd& angle) {
  const TendonCurve curve = TendonCurveOf(layout, FoldChain(layout, angle), angle);
  Eigen::VectorXd deflection = Eigen::VectorXd::Zero(angle.size());
  for (Eigen::Index i = 1; i < angle.size(); ++i) {
    const Eigen::Vector3d before = curve.frames[static_cast<std::size_t>(i - 1)].row(2);
    const Eigen::Vector3d after = curve.frames[static_cast<std::size_t>(i)].row(2);
    deflection[i] = std::atan2(before.cross(after).norm(), before.dot(after));
  }
  return deflection;
}

}  // namespace

Result<FrictionTendon> FrictionTendon::Make(const TentacleDesign& design) {
  Result<TentacleLayout> layout = LayOut(design);
  if (!layout.ok()) return layout.error();
  if (!(design.tendon_friction >= 0) || !(design.wrap_angle >= 0)) {
    return Error{ErrorKind::kBadInput, "friction and wrap angle: expected 0 or more"};
  }
  FrictionTendon tendon;
  tendon.design_ = design;
  tendon.layout_ = std::move(layout).value();
  const Eigen::VectorXd stiffness = HingeStiffness(design, tendon.layout_);
  // The frictionless law says what is wrong with a rest angle.
  if (const auto fold = SolveExactFold(tendon.layout_, stiffness, design.rest_angle, design.closed_angle, 0);
      !fold.ok()) {
    return fold.error();
  }
  for (Eigen::Index i = 0; i < stiffness.size(); ++i) {
    tendon.hinges_.push_back(
        HingeOf(tendon.layout_, i, stiffness[i], design.rest_angle, design.closed_angle));
  }
  tendon.friction_ = design.tendon_friction;
  tendon.wrap_angle_ = design.wrap_angle;
  tendon.flat_ = FlatTendonLength(tendon.layout_);
  tendon.largest_pull_ = LargestExactPull(tendon.layout_, design.closed_angle);
  tendon.tension_.setZero(stiffness.size());
  tendon.eta_.setZero(stiffness.size());
  return tendon;
}

void FrictionTendon::Slide(double base_tension, Eigen::VectorXd& tension) const {
  tension[0] = base_tension;
  for (Eigen::Index i = 1; i < tension.size(); ++i) {
    const double factor = std::exp(eta_[i]);
    tension[i] = std::clamp(tension_[i], tension[i - 1] / factor, tension[i - 1] * factor);
  }
}

Eigen::VectorXd FrictionTendon::AnglesAt(const Eigen::VectorXd& tension) const {
  Eigen::VectorXd angle(tension.size());
  for (Eigen::Index i = 0; i < angle.size(); ++i) {
    angle[i] = AngleAt(hinges_[static_cast<std::size_t>(i)], tension[i]);
  }
  return angle;
}

double FrictionTendon::Shortening(const Eigen::VectorXd& tension) const {
  double shortening = 0;
  for (Eigen::Index i = 0; i < tension.size(); ++i) {
    const Hinge& hinge = hinges_[static_cast<std::size_t>(i)];
    shortening += TakenIn(hinge, 0, AngleAt(hinge, tension[i]));
  }
  return shortening;
}

// The shortening rises with the tension at the base: bracketed about the last one, then regula falsi; an end
// that stays counts half (the Illinois rule), one that stays too long is halved.
double FrictionTendon::BaseTension(double wanted, double near, Eigen::VectorXd& next) const {
  const auto excess = [&](double tension) {
    Slide(tension, next);
    return Shortening(next) - wanted;
  };
  double low = near, high = near;
  double at_low = excess(near), at_high = at_low;
  double width = 1e-3;
  for (; at_low > 0; width *= 8) {
    high = low;
    at_high = at_low;
    low = width < 1 ? low / (1 + width) : 0;
    at_low = excess(low);
  }
  for (; at_high < 0 && high < 1e200; width *= 8) {
    low = high;
    at_low = at_high;
    high *= 1 + width;
    at_high = excess(high);
  }
  int stayed = 0;
  while (at_high > 0) {
    double middle = high - at_high * (high - low) / (at_high - at_low);
    if (std::abs(stayed) > 4 || !(middle > low && middle < high)) middle = 0.5 * (low + high);
    if (!(middle > low && middle < high)) break;  // neighbouring doubles
    const double at_middle = excess(middle);
    if (std::abs(at_middle) <= 4e-16 * flat_) return middle;
    if (at_middle > 0) {
      high = middle;
      at_high = at_middle;
      stayed = std::max(stayed, 0) + 1;
      if (stayed > 1) at_low *= 0.5;
    } else {
      low = middle;
      at_low = at_middle;
      stayed = std::min(stayed, 0) - 1;
      if (stayed < -1) at_high *= 0.5;
    }
  }
  return high;
}

void FrictionTendon::Step(double pull, double pull_slope) {
  Eigen::VectorXd next = tension_;
  const double wanted = pull * flat_;
  double base = tension_[0] > 0 ? tension_[0] : hinges_.front().critical;
  // The deflection belongs to the shape at the step's end: some rounds settle it.
  for (int round = 0; round < 100; ++round) {
    eta_ = friction_ * (wrap_angle_ + DeflectionOf(layout_, AnglesAt(next)).array());
    Slide(0, next);
    if (Shortening(next) >= wanted) break;  // slack
    base = BaseTension(wanted, base, next);
    Slide(base, next);
    const Eigen::VectorXd eta = friction_ * (wrap_angle_ + DeflectionOf(layout_, AnglesAt(next)).array());
    if ((eta - eta_).cwiseAbs().maxCoeff() <= 1e-12) break;
  }
  if (following_) tension_slope_ = TensionSlope(next, pull, pull_slope);
  tension_ = next;
  pull_ = pull;
}

void FrictionTendon::Follow(const DesignChange& change) {
  following_ = true;
  change_ = ChangeForExactLaw(design_, layout_, change);
  friction_change_ = change.tendon_friction;
  wrap_angle_change_ = change.wrap_angle;
  tension_slope_.setZero(tension_.size());
}

HingeChange FrictionTendon::ChangeOf(Eigen::Index crease) const {
  return {change_.log_stiffness[crease], change_.half_spacing[crease], change_.crease_angle[crease],
          change_.rest_angle};
}

// Each tension's slope is of_base times that of the tension at the base, plus alone; the holes' distances
// then give that of the base.
Eigen::VectorXd FrictionTendon::TensionSlope(const Eigen::VectorXd& after, double pull,
                                             double pull_slope) const {
  const Eigen::Index creases = after.size();
  if (after[0] == 0) return Eigen::VectorXd::Zero(creases);
  const Eigen::VectorXd angle = AnglesAt(after);
  const Eigen::VectorXd deflections = DeflectionOf(layout_, angle);
  Eigen::VectorXd of_base(creases), alone(creases);
  double moved = pull_slope * flat_;
  double yield = 0;
  double give_before = 0, push_before = 0;
  for (Eigen::Index i = 0; i < creases; ++i) {
    const Hinge& hinge = hinges_[static_cast<std::size_t>(i)];
    const HingeChange change = ChangeOf(i);
    const double give = LogGive(hinge, angle[i]);
    const double push = give > 0 ? LogPush(hinge, angle[i], change) : 0;
    const double factor = i > 0 ? std::exp(eta_[i]) : 1;
    const bool falls = i > 0 && tension_[i] < after[i - 1] / factor;
    const bool rises = i > 0 && tension_[i] > after[i - 1] * factor;
    if (i == 0) {
      of_base[i] = 1;
      alone[i] = 0;
    } else if (!falls && !rises) {  // sticks
      of_base[i] = 0;
      alone[i] = tension_slope_[i];
    } else {
      const double sign = falls ? -1 : 1;
      const DeflectionSlope deflection = SlopeOfDeflection(layout_, angle, i);
      // d eta but for what comes through the two tensions
      double eta = friction_change_ * (wrap_angle_ + deflections[i]) + friction_ * wrap_angle_change_;
      eta += friction_ * (deflection.before * give_before * push_before + deflection.after * give * push +
                          deflection.before_crease * change_.crease_angle[i - 1] +
                          deflection.after_crease * change.crease_angle);
      const double before =
          1 / after[i - 1] + sign * friction_ * deflection.before * give_before / after[i - 1];
      const double own = (1 - sign * friction_ * deflection.after * give) / after[i];
      of_base[i] = before * of_base[i - 1] / own;
      alone[i] = (before * alone[i - 1] + sign * eta) / own;
    }
    const double taken = 2 * hinge.d * Moment(hinge, angle[i]) * give;
    moved += HoleDistanceChange(hinge, angle[i], change) - 2 * change.half_spacing * (1 - pull);
    moved -= taken * (alone[i] / after[i] + push);
    yield += taken * of_base[i] / after[i];
    give_before = give;
    push_before = push;
  }
  if (!(yield > 0)) return alone;  // nothing gives: flat
  return of_base * (moved / yield) + alone;
}

Result<FrictionFold> FrictionTendon::MoveTo(double pull) {
  if (!(pull >= 0) || !std::isfinite(pull)) {
    return Error{ErrorKind::kBadInput, "pull = " + std::to_string(pull) + ": expected a fraction, 0 to " +
                                           std::to_string(largest_pull_)};
  }
  if (!(pull < largest_pull_)) {
    return Error{ErrorKind::kUnreachable, "pull = " + std::to_string(pull) + " is beyond reach: below " +
                                              std::to_string(largest_pull_) + ", where every crease closes"};
  }
  const double from = pull_;
  const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(pull - from) / kLargestStep - 1e-9)));
  for (int i = 1; i <= steps; ++i) {
    const double share = static_cast<double>(i) / steps;
    Step(from + (pull - from) * share, change_.pull * share);
  }
  FrictionFold fold;
  fold.angle = AnglesAt(tension_);
  fold.tension = tension_;
  fold.tendon_length = flat_ - Shortening(tension_);
  if (following_) {
    fold.angle_slope.setZero(tension_.size());
    for (Eigen::Index i = 0; i < tension_.size(); ++i) {
      const Hinge& hinge = hinges_[static_cast<std::size_t>(i)];
      const double give = LogGive(hinge, fold.angle[i]);
      if (tension_[i] == 0) {
        fold.angle_slope[i] = change_.rest_angle;
      } else if (give > 0) {
        fold.angle_slope[i] =
            give * (tension_slope_[i] / tension_[i] + LogPush(hinge, fold.angle[i], ChangeOf(i)));
      }
    }
  }
  fold.slack = tension_.maxCoeff() == 0 && flat_ - fold.tendon_length > pull * flat_;
  return fold;
}

}  // namespace tendril
