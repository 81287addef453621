#include "model/fold/tendon_friction.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "model/fold/exact_law.h"
#include "model/fold/facet_chain.h"

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

// The shortening rises with the tension at the base: bisection, from bounds that grow about the last tension.
void FrictionTendon::Step(double pull) {
  Eigen::VectorXd next = tension_;
  // The deflection belongs to the shape at the step's end: a few rounds settle it.
  for (int round = 0; round < 8; ++round) {
    eta_ = friction_ * (wrap_angle_ + DeflectionOf(layout_, AnglesAt(next)).array());
    const double wanted = pull * flat_;
    double low = 0;
    Slide(low, next);
    if (Shortening(next) >= wanted) break;  // slack
    double high = tension_[0] > 0 ? tension_[0] : hinges_.front().critical;
    const auto reaches = [&](double tension) {
      Slide(tension, next);
      return Shortening(next) >= wanted;
    };
    while (!reaches(high) && high < 1e200) {
      low = high;
      high *= 2;
    }
    while (true) {
      const double middle = low + 0.5 * (high - low);
      if (!(middle > low && middle < high)) break;
      (reaches(middle) ? high : low) = middle;
    }
    Slide(high, next);
    const Eigen::VectorXd eta = friction_ * (wrap_angle_ + DeflectionOf(layout_, AnglesAt(next)).array());
    if ((eta - eta_).cwiseAbs().maxCoeff() <= 1e-12) break;
  }
  tension_ = next;
  pull_ = pull;
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
  for (int i = 1; i <= steps; ++i) Step(from + (pull - from) * i / steps);
  FrictionFold fold;
  fold.angle = AnglesAt(tension_);
  fold.tension = tension_;
  fold.tendon_length = flat_ - Shortening(tension_);
  fold.slack = tension_.maxCoeff() == 0 && flat_ - fold.tendon_length > pull * flat_;
  return fold;
}

}  // namespace tendril
