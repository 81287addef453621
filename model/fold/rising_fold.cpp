#include "model/fold/rising_fold.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "model/check.h"
#include "model/fold/exact_law.h"
#include "model/fold/fold.h"
#include "model/fold/hinge.h"
#include "model/fold/tendon_chord.h"

namespace tendril {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string Digits(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value);
  return {text, end.ptr};
}

// How far the tendon turns at hole i, rad, where creases i - 1 and i are folded so far.
double DeflectionAt(const TentacleLayout& layout, Eigen::Index i, double before, double after) {
  const double sign = i % 2 == 0 ? -1 : 1;
  const Eigen::Vector3d u = ChordOf(layout.crease_angle[i - 1], sign * before).along;
  const Eigen::Vector3d v = ChordOf(layout.crease_angle[i], sign * after).along;
  return std::atan2(u.cross(v).norm(), u.dot(v));
}

// One crease under either law. Its stiffness is relative: W, or W / sin a for law `exact`.
struct LoadedCrease {
  FoldLaw law = FoldLaw::kPaper;
  Hinge hinge;       // of law exact; d, rest and limit of both
  double yield = 0;  // law paper: phi - phi0 per unit of k

  bool starts_flat() const { return law == FoldLaw::kExact && hinge.rest == 0; }

  double Angle(double tension) const {
    if (law == FoldLaw::kExact) return AngleAt(hinge, tension);
    return std::min(hinge.rest + tension * yield, hinge.limit);
  }
  // d phi / d ln T
  double Give(double angle) const {
    if (law == FoldLaw::kExact) return LogGive(hinge, angle);
    return angle >= hinge.limit ? 0 : angle - hinge.rest;
  }
  // d phi / d phi0 at a tension that stays.
  double ByRest(double angle, double tension) const {
    if (angle >= hinge.limit) return 0;
    if (law == FoldLaw::kPaper) return 1;
    const double turn = angle - hinge.rest;
    if (turn > 0) return LogGive(hinge, angle) / turn;
    if (tension == 0) return 1;
    // Flat below the tension at which it begins to fold: there the slope grows without bound.
    return 1 / std::max(1 - tension / hinge.critical, 1e-3);
  }
  double TakenInFromFlat(double angle) const {
    if (law == FoldLaw::kExact) return TakenIn(hinge, 0, angle);
    const double sine = std::sin(0.5 * angle);
    return 4 * hinge.d * sine * sine;
  }
  double Lever(double angle) const {  // d TakenInFromFlat / d phi
    return 2 * hinge.d * (law == FoldLaw::kExact ? Moment(hinge, angle) : std::sin(angle));
  }
};

class RisingTendon {
 public:
  RisingTendon(FoldLaw law, const TentacleDesign& design, const TentacleLayout& layout)
      : layout_(layout), friction_(design.tendon_friction), wrap_angle_(design.wrap_angle) {
    const Eigen::Index n = layout.half_spacing.size();
    for (Eigen::Index i = 0; i < n; ++i) {
      LoadedCrease crease;
      crease.law = law;
      crease.hinge = HingeOf(layout, i, layout.stiffness[i] / std::sin(layout.crease_angle[i]),
                             design.rest_angle, design.closed_angle);
      crease.yield = layout.half_spacing[i] / (design.base_width * layout.stiffness[i]);
      creases_.push_back(crease);
    }
    angle_.resize(n);
    tension_.resize(n);
  }

  const Eigen::VectorXd& angle() const { return angle_; }
  const Eigen::VectorXd& tension() const { return tension_; }
  const LoadedCrease& at(Eigen::Index i) const { return creases_[static_cast<std::size_t>(i)]; }
  Eigen::Index size() const { return angle_.size(); }

  // Sets tensions and angles by that at the base; the shortening and its slope by ln T0, m.
  struct Sums {
    double taken = 0;
    double slope = 0;
  };
  Sums Load(double base) {
    Sums sums;
    double per_base = 1;  // d ln T_i / d ln T_0
    double give_before = 0;
    for (Eigen::Index i = 0; i < size(); ++i) {
      tension_[i] = i == 0 ? base : friction_ == 0 ? base : NextTension(i);
      angle_[i] = at(i).Angle(tension_[i]);
      const double give = at(i).Give(angle_[i]);
      if (i > 0 && friction_ > 0 && tension_[i] > 0) {
        const DeflectionSlope slope = SlopeOfDeflection(layout_, angle_, i);
        per_base *= (1 - friction_ * slope.before * give_before) / (1 + friction_ * slope.after * give);
      }
      sums.taken += at(i).TakenInFromFlat(angle_[i]);
      sums.slope += at(i).Lever(angle_[i]) * give * per_base;
      give_before = give;
    }
    return sums;
  }

  void Set(const Eigen::VectorXd& angle, double tension) {
    angle_ = angle;
    tension_.setConstant(tension);
  }

 private:
  // The tension that slides past hole i: ln T = ln T_before - mu (theta0 + deflection(T)), rising in T where
  // the crease is folded. By Newton's method between bounds.
  double NextTension(Eigen::Index i) {
    const double before = tension_[i - 1];
    if (!(before > 0)) return 0;
    const LoadedCrease& crease = at(i);
    double low = before * std::exp(-friction_ * (wrap_angle_ + std::numbers::pi));
    double high = before * std::exp(-friction_ * wrap_angle_);
    if (crease.starts_flat()) {
      const double flat =
          before * std::exp(-friction_ * (wrap_angle_ + DeflectionAt(layout_, i, angle_[i - 1], 0)));
      if (flat <= crease.hinge.critical) return flat;
      low = std::max(low, crease.hinge.critical);
    }
    double next = std::clamp(before * std::exp(-friction_ * (wrap_angle_ + 0.1)), low, high);
    for (int iteration = 0; iteration < 60; ++iteration) {
      angle_[i] = crease.Angle(next);
      const double off = std::log(next / before) +
                         friction_ * (wrap_angle_ + DeflectionAt(layout_, i, angle_[i - 1], angle_[i]));
      (off > 0 ? high : low) = next;
      const double slope =
          1 + friction_ * SlopeOfDeflection(layout_, angle_, i).after * crease.Give(angle_[i]);
      const double step = slope > 0 ? off / slope : kInfinity;
      double to = next * std::exp(-step);
      if (std::abs(step) <= 1e-8) return to;  // quadratic convergence: the rest is below rounding
      if (!(to > low && to < high)) to = std::sqrt(low) * std::sqrt(high);
      if (!(to > low && to < high)) break;  // neighbouring doubles
      next = to;
    }
    return next;
  }

  const TentacleLayout& layout_;
  double friction_ = 0;
  double wrap_angle_ = 0;
  std::vector<LoadedCrease> creases_;
  Eigen::VectorXd angle_, tension_;
};

// The shortening rises with the tension at the base; where creases jump (law exact with friction), the answer
// is the upper side.
void SolveBase(RisingTendon& tendon, double wanted, double start) {
  double low = 0;
  double high = kInfinity;
  double base = start > 0 && std::isfinite(start) ? start : 1;
  for (int iteration = 0; iteration < 200; ++iteration) {
    const RisingTendon::Sums sums = tendon.Load(base);
    const double off = sums.taken - wanted;
    (off > 0 ? high : low) = base;
    const double step = sums.slope > 0 ? off / sums.slope : off > 0 ? kInfinity : -kInfinity;
    if (std::abs(step) <= 1e-9) {  // quadratic convergence: the rest is below rounding
      tendon.Load(base * std::exp(-step));
      return;
    }
    double next = base * std::exp(std::clamp(-step, -0.7, 0.7));
    if (!(next > low && next < high)) {
      if (!std::isfinite(high) || low == 0) return;  // nothing moves any more
      next = std::sqrt(low) * std::sqrt(high);
      if (!(next > low && next < high)) break;
    }
    base = next;
    if (!(base > 1e-300 && base < 1e300)) return;
  }
  if (std::isfinite(high)) tendon.Load(high);
}

}  // namespace

const char* NameOf(FoldLaw law) { return law == FoldLaw::kPaper ? "paper" : "exact"; }

std::optional<FoldLaw> FoldLawOf(const std::string& name) {
  if (name == "paper") return FoldLaw::kPaper;
  if (name == "exact") return FoldLaw::kExact;
  return std::nullopt;
}

double LargestPullOf(FoldLaw law, const TentacleLayout& layout, double closed_angle) {
  return law == FoldLaw::kPaper ? LargestPull(closed_angle) : LargestExactPull(layout, closed_angle);
}

Result<RisingFold> SolveRisingFold(FoldLaw law, const TentacleDesign& design, const TentacleLayout& layout,
                                   double pull) {
  const auto bad = [](const std::string& what) { return Error{ErrorKind::kBadInput, what}; };
  if (!(pull >= 0) || !std::isfinite(pull)) return bad("pull = " + Digits(pull) + ": expected a fraction");
  if (!(design.rest_angle >= 0 && design.rest_angle < std::min(design.closed_angle, kClosedFlat))) {
    return bad("rest angle " + Digits(design.rest_angle) + " rad: expected 0 up to the closed angle");
  }
  if (!(design.tendon_friction >= 0) || !std::isfinite(design.tendon_friction)) {
    return bad("friction " + Digits(design.tendon_friction) + ": expected 0 or more");
  }
  const double largest = LargestPullOf(law, layout, design.closed_angle);
  if (pull > largest) {
    return Error{ErrorKind::kUnreachable, "pull = " + Digits(pull) + " is beyond reach, " + Digits(largest)};
  }
  RisingTendon tendon(law, design, layout);
  const double flat = FlatTendonLength(layout);
  double at_rest = 0;
  for (Eigen::Index i = 0; i < tendon.size(); ++i) {
    at_rest += tendon.at(i).TakenInFromFlat(design.rest_angle);
  }
  RisingFold fold;
  const Eigen::Index n = tendon.size();
  if (pull * flat <= at_rest) {
    tendon.Set(Eigen::VectorXd::Constant(n, design.rest_angle), 0);
  } else if (law == FoldLaw::kExact) {
    Eigen::VectorXd stiffness = layout.stiffness.array() / layout.crease_angle.array().sin();
    const Result<ExactFold> exact =
        SolveExactFold(layout, stiffness, design.rest_angle, design.closed_angle, pull);
    if (!exact.ok()) return exact.error();
    tendon.Set(exact.value().angle, exact.value().tension);
    if (design.tendon_friction > 0 && pull < largest) SolveBase(tendon, pull * flat, exact.value().tension);
  } else {
    const Result<Fold> paper = SolveFold(layout, design.base_width, design.closed_angle, pull);
    if (!paper.ok()) return paper.error();
    tendon.Set(paper.value().angle, paper.value().scale);
    if ((design.tendon_friction > 0 || design.rest_angle > 0) && pull < largest) {
      SolveBase(tendon, pull * flat, paper.value().scale);
    }
  }
  fold.angle = tendon.angle();
  fold.tension = tendon.tension();
  fold.tendon_length = flat;
  for (Eigen::Index i = 0; i < n; ++i) {
    fold.tendon_length -= tendon.at(i).TakenInFromFlat(fold.angle[i]);
    fold.closed += fold.angle[i] >= tendon.at(i).hinge.limit ? 1 : 0;
  }
  return fold;
}

// Each ln T is of_base times that at the base plus alone, for every direction at once; the tendon's length
// then gives the base's.
RisingSlopes SlopesOf(FoldLaw law, const TentacleDesign& design, const TentacleLayout& layout,
                      const RisingFold& fold, const Eigen::Ref<const Eigen::MatrixXd>& directions,
                      bool by_friction) {
  const Eigen::Index n = fold.angle.size();
  TENDRIL_CHECK(layout.half_spacing.size() == n && directions.rows() == n);
  const RisingTendon tendon(law, design, layout);
  const Eigen::Index m = directions.cols();
  // Columns: pull, rest angle, friction, then the stiffnesses'.
  using Row = Eigen::RowVectorXd;
  Eigen::MatrixXd slope = Eigen::MatrixXd::Zero(n, 3 + m);
  Eigen::VectorXd per_base = Eigen::VectorXd::Zero(n);
  const double mu = design.tendon_friction;
  double of_base = 1;
  Row alone = Row::Zero(3 + m);
  Row moved = Row::Zero(3 + m);
  moved[0] = FlatTendonLength(layout);
  double yield = 0;
  Row shift_before = Row::Zero(3 + m);  // of the crease before: d phi at a base tension that stays
  double give_before = 0;               // its d phi / d ln T_0
  for (Eigen::Index i = 0; i < n; ++i) {
    const LoadedCrease& crease = tendon.at(i);
    const double give = crease.Give(fold.angle[i]);
    Row push = Row::Zero(3 + m);  // d phi at this crease's own tension
    push[1] = crease.ByRest(fold.angle[i], fold.tension[i]);
    push.tail(m) = -give * directions.row(i);
    if (i > 0 && fold.tension[i] > 0 && (by_friction || mu > 0)) {
      const double deflection = DeflectionAt(layout, i, fold.angle[i - 1], fold.angle[i]);
      const DeflectionSlope by = SlopeOfDeflection(layout, fold.angle, i);
      const double own = 1 + mu * by.after * give;
      alone -= mu * (by.before * shift_before + by.after * push);
      alone[2] -= design.wrap_angle + deflection;
      alone /= own;
      of_base = (of_base - mu * by.before * give_before) / own;
    }
    shift_before = give * alone + push;
    give_before = give * of_base;
    slope.row(i) = shift_before;
    per_base[i] = give_before;
    const double lever = crease.Lever(fold.angle[i]);
    moved -= lever * shift_before;
    yield += lever * give_before;
  }
  if (fold.tension[0] > 0 && yield > 0) {
    slope += per_base * (moved / yield);
  } else {
    slope.col(0).setZero();
    slope.rightCols(m + 1).setZero();
  }
  return {slope.col(0), slope.col(1), slope.col(2), slope.rightCols(m)};
}

}  // namespace tendril
