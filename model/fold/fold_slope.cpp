#include "model/fold/fold_slope.h"

#include <Eigen/Geometry>
#include <cmath>

#include "model/check.h"
#include "model/fold/hinge.h"

namespace tendril {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

double At(const Eigen::VectorXd& change, Eigen::Index i) { return change.size() > 0 ? change[i] : 0.0; }

// What changes about the sheet, and ln of the width-like stiffness W.
struct SheetChange {
  Eigen::VectorXd half_spacing, crease_angle, log_width_stiffness;
};

SheetChange ChangeOfSheet(const TentacleDesign& design, const TentacleLayout& layout,
                          const DesignChange& change) {
  const Eigen::Index creases = layout.half_spacing.size();
  const double share = 1 / (1 + design.spacing_ratio);
  const double db = change.unit_length * share - design.unit_length * share * share * change.spacing_ratio;
  const double dc = change.unit_length - db;
  const auto hole_moves = [&](Eigen::Index i) {
    const Eigen::Index units = i / 2;
    return static_cast<double>(units) * change.unit_length + static_cast<double>(i % 2) * db;
  };
  const double margin = 0.5 * (change.length - hole_moves(creases));  // of -base_z
  SheetChange sheet{Eigen::VectorXd(creases), Eigen::VectorXd(creases), Eigen::VectorXd(creases)};
  for (Eigen::Index i = 0; i < creases; ++i) {
    const bool is_alpha = i % 2 == 0;
    sheet.half_spacing[i] = 0.5 * (is_alpha ? db : dc);
    sheet.crease_angle[i] = is_alpha ? change.alpha : change.beta;
    const double place = (layout.crease_z[i] - layout.base_z) / design.length;  // of the cut length
    const double moved =
        (hole_moves(i) + sheet.half_spacing[i] + margin - place * change.length) / design.length;
    const double ratio = layout.width[i] / design.base_width;
    const double log_ratio = (change.taper * place + (design.taper - 1) * moved) / ratio;
    sheet.log_width_stiffness[i] = change.base_width / design.base_width +
                                   design.stiffness_exponent * log_ratio +
                                   change.stiffness_exponent * std::log(ratio) +
                                   (is_alpha ? 0 : change.stiffness_ratio / design.stiffness_ratio);
  }
  return sheet;
}

}  // namespace

FoldChange ChangeForPaperLaw(const TentacleDesign& design, const TentacleLayout& layout,
                             const DesignChange& change) {
  SheetChange sheet = ChangeOfSheet(design, layout, change);
  return {change.pull, change.rest_angle, std::move(sheet.log_width_stiffness), std::move(sheet.half_spacing),
          std::move(sheet.crease_angle)};
}

FoldChange ChangeForExactLaw(const TentacleDesign& design, const TentacleLayout& layout,
                             const DesignChange& change) {
  FoldChange fold = ChangeForPaperLaw(design, layout, change);
  // B = E W t^3 / (12 crease_length sin a)
  fold.log_stiffness.array() += change.youngs_modulus / design.youngs_modulus +
                                3 * change.thickness / design.thickness -
                                change.crease_length / design.crease_length;
  fold.log_stiffness.array() -= fold.crease_angle.array() / layout.crease_angle.array().tan();
  return fold;
}

Eigen::VectorXd SlopeOf(const TentacleLayout& layout, const Fold& fold, const FoldChange& change) {
  const Eigen::Index creases = fold.angle.size();
  TENDRIL_CHECK(layout.half_spacing.size() == creases && fold.scale > 0);
  // From the differential of sum 2 d cos phi = (1 - pull) sum 2 d, d phi = phi (d ln k + d ln d - d ln W).
  const double flat = FlatTendonLength(layout);
  const double remaining = fold.tendon_length / flat;
  Eigen::VectorXd slope = Eigen::VectorXd::Zero(creases);
  Eigen::VectorXd push = Eigen::VectorXd::Zero(creases);
  double moved = change.pull * flat;
  double yield = 0;
  std::size_t closed = 0;
  for (Eigen::Index i = 0; i < creases; ++i) {
    const double d = layout.half_spacing[i];
    const double angle = fold.angle[i];
    const double cosine = angle == kClosedFlat ? 0 : std::cos(angle);
    moved += 2 * At(change.half_spacing, i) * (cosine - remaining);
    if (closed < fold.closed.size() && fold.closed[closed] == i) {
      ++closed;
      continue;
    }
    push[i] = At(change.half_spacing, i) / d - At(change.log_stiffness, i);
    moved -= 2 * d * std::sin(angle) * angle * push[i];
    yield += 2 * d * std::sin(angle) * angle;
    slope[i] = angle;
  }
  TENDRIL_CHECK(yield > 0);
  return slope.array() * (moved / yield + push.array());
}

ExactSlope SlopeOf(const TentacleLayout& layout, const ExactFold& fold, double rest_angle,
                   double closed_angle, const FoldChange& change) {
  const Eigen::Index creases = fold.angle.size();
  TENDRIL_CHECK(layout.half_spacing.size() == creases && std::isfinite(fold.tension));
  ExactSlope slope;
  if (fold.tension == 0) {
    TENDRIL_CHECK(rest_angle > 0);
    slope.angle.setConstant(creases, change.rest_angle);
    return slope;
  }
  const double flat = FlatTendonLength(layout);
  const double remaining = fold.tendon_length / flat;
  Eigen::VectorXd give(creases), push(creases);
  double moved = change.pull * flat;
  double yield = 0;
  for (Eigen::Index i = 0; i < creases; ++i) {
    // Stiffness does not matter to the geometry asked of it here.
    const Hinge hinge = HingeOf(layout, i, 1, rest_angle, closed_angle);
    const HingeChange of{At(change.log_stiffness, i), At(change.half_spacing, i), At(change.crease_angle, i),
                         change.rest_angle};
    give[i] = LogGive(hinge, fold.angle[i]);
    push[i] = give[i] > 0 ? LogPush(hinge, fold.angle[i], of) : 0;
    const double taken = 2 * hinge.d * Moment(hinge, fold.angle[i]);  // of the tendon, per phi
    moved += HoleDistanceChange(hinge, fold.angle[i], of) - 2 * of.half_spacing * remaining;
    moved -= taken * give[i] * push[i];
    yield += taken * give[i];
  }
  TENDRIL_CHECK(yield > 0);
  slope.log_tension = moved / yield;
  slope.angle = give.array() * (slope.log_tension + push.array());
  return slope;
}

namespace {

Matrix3d CrossMatrix(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// A quantity and its derivative along the change.
template <class T>
struct Moving {
  T value;
  T slope;
};

// The turn by `angle` about a crease at angle a, and how it changes.
Moving<Matrix3d> Turn(double a, double da, double angle, double dangle) {
  const Matrix3d k = CrossMatrix({0, std::sin(a), std::cos(a)});
  const Matrix3d dk = CrossMatrix({0, std::cos(a) * da, -std::sin(a) * da});
  const double s = std::sin(angle), half = std::sin(0.5 * angle), v = 2 * half * half;
  const Matrix3d turn = Matrix3d::Identity() + s * k + v * k * k;
  return {turn, dangle * k * turn + s * dk + v * (dk * k + k * dk)};
}

}  // namespace

Eigen::Matrix3Xd HoleSlopes(const TentacleLayout& layout, const Eigen::VectorXd& angle,
                            const Eigen::VectorXd& angle_slope, const FoldChange& change) {
  const Eigen::Index creases = layout.half_spacing.size();
  TENDRIL_CHECK(angle.size() == creases && angle_slope.size() == creases);
  // First in the frame of facet 0, where hole i + 1 is hole i + d (z of facet i + z of facet i + 1).
  Moving<Matrix3d> facet{Matrix3d::Identity(), Matrix3d::Zero()};
  Eigen::Matrix3Xd holes = Eigen::Matrix3Xd::Zero(3, creases + 1);
  Eigen::Matrix3Xd slopes = Eigen::Matrix3Xd::Zero(3, creases + 1);
  for (Eigen::Index i = 0; i < creases; ++i) {
    const double sign = i % 2 == 0 ? -1 : 1;  // mountain, valley, ... seen from +x
    const Moving<Matrix3d> turn = Turn(layout.crease_angle[i], At(change.crease_angle, i),
                                       2 * sign * angle[i], 2 * sign * angle_slope[i]);
    const Moving<Matrix3d> next{facet.value * turn.value,
                                facet.slope * turn.value + facet.value * turn.slope};
    const double d = layout.half_spacing[i];
    const Vector3d z = facet.value.col(2) + next.value.col(2);
    holes.col(i + 1) = holes.col(i) + d * z;
    slopes.col(i + 1) =
        slopes.col(i) + At(change.half_spacing, i) * z + d * (facet.slope.col(2) + next.slope.col(2));
    facet = next;
  }
  // Then seen from the first tendon segment: d3 its chord, d1 facet 0's normal turned by phi.
  const Moving<Matrix3d> half =
      Turn(layout.crease_angle[0], At(change.crease_angle, 0), -angle[0], -angle_slope[0]);
  const double length = holes.col(1).norm();
  TENDRIL_CHECK(length > 0);
  Moving<Matrix3d> segment;
  segment.value.col(0) = half.value.col(0);
  segment.slope.col(0) = half.slope.col(0);
  const Vector3d d3 = holes.col(1) / length;
  segment.value.col(2) = d3;
  segment.slope.col(2) = (slopes.col(1) - d3.dot(slopes.col(1)) * d3) / length;
  segment.value.col(1) = segment.value.col(2).cross(segment.value.col(0));
  segment.slope.col(1) =
      segment.slope.col(2).cross(segment.value.col(0)) + segment.value.col(2).cross(segment.slope.col(0));
  return segment.value.transpose() * slopes + segment.slope.transpose() * holes;
}

}  // namespace tendril
