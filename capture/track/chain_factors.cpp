#include "capture/track/chain_factors.h"

#include <ceres/jet.h>

#include <cmath>
#include <numbers>

#include "model/check.h"

namespace tendril {

Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Matrix3d RotationOf(const Eigen::Vector3d& rotation_vector) {
  const double angle = rotation_vector.norm();
  if (angle < 1e-12) return Eigen::Matrix3d::Identity() + CrossMatrix(rotation_vector);
  return Eigen::AngleAxisd(angle, rotation_vector / angle).toRotationMatrix();
}

FacetState Stepped(const FacetState& state, const Eigen::Ref<const Eigen::VectorXd>& step) {
  TENDRIL_CHECK(step.size() == kFacetSize);
  FacetState next;
  // Through a quaternion, so that hundreds of steps leave the matrix a rotation.
  next.rotation =
      Eigen::Quaterniond(state.rotation * RotationOf(step.head<3>())).normalized().toRotationMatrix();
  next.hole = state.hole + step.segment<3>(3);
  next.opening = state.opening + step.tail<2>();
  return next;
}

CreaseGeometry GeometryOfCrease(const TentacleLayout& layout, int crease) {
  TENDRIL_CHECK(crease >= 0 && crease < layout.crease_z.size());
  const double angle = layout.crease_angle[crease];
  CreaseGeometry geometry;
  geometry.along = Eigen::Vector3d(0, std::sin(angle), std::cos(angle));
  geometry.across = geometry.along.cross(Eigen::Vector3d::UnitX());
  geometry.arm_before = Eigen::Vector3d(0, 0, layout.crease_z[crease] - layout.hole_z[crease]);
  geometry.arm_after = Eigen::Vector3d(0, 0, layout.crease_z[crease] - layout.hole_z[crease + 1]);
  geometry.turn = crease % 2 == 0 ? -1.0 : 1.0;
  return geometry;
}

namespace {

// Sine and cosine parts of the turning about the crease: theta = atan2(sine, cosine).
struct Turning {
  double sine = 0;
  double cosine = 0;
};

Turning TurningOf(const CreaseGeometry& crease, const Eigen::Matrix3d& relative) {
  const Eigen::Vector3d normal = Eigen::Vector3d::UnitX();
  const Eigen::Vector3d& across = crease.across;
  const Eigen::Vector3d turned_normal = relative * normal;
  const Eigen::Vector3d turned_across = relative * across;
  return {across.dot(turned_normal) - normal.dot(turned_across),
          normal.dot(turned_normal) + across.dot(turned_across)};
}

double FoldAngleOf(const CreaseGeometry& crease, const Turning& turning) {
  double twice = crease.turn * std::atan2(turning.sine, turning.cosine);
  if (twice <= -std::numbers::pi / 2) twice += 2 * std::numbers::pi;  // folds close to 90 deg, not -90 deg
  return 0.5 * twice;
}

}  // namespace

double FoldAngleBetween(const CreaseGeometry& crease, const Eigen::Matrix3d& before,
                        const Eigen::Matrix3d& after) {
  const Eigen::Matrix3d relative = before.transpose() * after;
  return FoldAngleOf(crease, TurningOf(crease, relative));
}

AngleMotion MotionOfAngle(const CreaseGeometry& crease, const Eigen::Matrix3d& relative) {
  const Turning turning = TurningOf(crease, relative);
  AngleMotion motion{.angle = FoldAngleOf(crease, turning)};
  const double square = turning.sine * turning.sine + turning.cosine * turning.cosine;
  if (!(square > 1e-9)) return motion;
  const Eigen::Vector3d normal = Eigen::Vector3d::UnitX();
  const Eigen::Vector3d turned_normal = relative * normal;
  const Eigen::Vector3d turned_across = relative * crease.across;
  const Eigen::RowVector3d sine_before = crease.across.transpose() * CrossMatrix(turned_normal) -
                                         normal.transpose() * CrossMatrix(turned_across);
  const Eigen::RowVector3d cosine_before = normal.transpose() * CrossMatrix(turned_normal) +
                                           crease.across.transpose() * CrossMatrix(turned_across);
  const Eigen::RowVector3d sine_after = -crease.across.transpose() * relative * CrossMatrix(normal) +
                                        normal.transpose() * relative * CrossMatrix(crease.across);
  const Eigen::RowVector3d cosine_after = -normal.transpose() * relative * CrossMatrix(normal) -
                                          crease.across.transpose() * relative * CrossMatrix(crease.across);
  const double scale = 0.5 * crease.turn / square;
  motion.before = scale * (turning.cosine * sine_before - turning.sine * cosine_before);
  motion.after = scale * (turning.cosine * sine_after - turning.sine * cosine_after);
  return motion;
}

CreaseFit FitOfCrease(const CreaseGeometry& crease, const CreasePrior& prior, int crease_number,
                      const FacetState& before, const FacetState& after) {
  constexpr int kResiduals = 9;
  constexpr int kAfter = kFacetSize;
  Eigen::Matrix<double, kResiduals, 1> residual;
  Eigen::Matrix<double, kResiduals, 2 * kFacetSize> jacobian;
  jacobian.setZero();

  // The crease's centre as the facet after carries it, in the sheet of the facet before.
  const Eigen::Matrix3d relative = before.rotation.transpose() * after.rotation;
  const Eigen::Vector3d turned_arm = relative * crease.arm_after;
  const Eigen::Vector3d apart = before.rotation.transpose() * (after.hole - before.hole);
  const Eigen::Vector3d firm = prior.sigma_gap.cwiseInverse();
  residual.head<3>() = firm.cwiseProduct(apart + turned_arm - crease.arm_before);
  jacobian.block<3, 3>(0, 0) = firm.asDiagonal() * CrossMatrix(apart + turned_arm);
  jacobian.block<3, 3>(0, 3) = -(firm.asDiagonal() * before.rotation.transpose());
  jacobian.block<3, 3>(0, kAfter) = -(firm.asDiagonal() * relative * CrossMatrix(crease.arm_after));
  jacobian.block<3, 3>(0, kAfter + 3) = firm.asDiagonal() * before.rotation.transpose();

  // The crease's direction as either facet carries it: two components across it.
  const Eigen::Vector3d normal = Eigen::Vector3d::UnitX();
  const Eigen::Vector3d turned_along = relative * crease.along;
  Eigen::Matrix<double, 2, 3> sideways;
  sideways << normal.transpose(), crease.across.transpose();
  residual.segment<2>(3) = sideways * turned_along / prior.sigma_swing;
  jacobian.block<2, 3>(3, 0) = sideways * CrossMatrix(turned_along) / prior.sigma_swing;
  jacobian.block<2, 3>(3, kAfter) = -sideways * relative * CrossMatrix(crease.along) / prior.sigma_swing;

  // The fold angle.
  const AngleMotion fold = MotionOfAngle(crease, relative);
  const int parity = crease_number % 2;
  residual[5] =
      (fold.angle - prior.expected_angle - prior.compliance * before.opening[parity]) / prior.sigma_angle;
  jacobian.block<1, 3>(5, 0) = fold.before / prior.sigma_angle;
  jacobian.block<1, 3>(5, kAfter) = fold.after / prior.sigma_angle;
  jacobian(5, 6 + parity) = -prior.compliance / prior.sigma_angle;

  residual[8] = prior.recalled_weight * (fold.angle - prior.recalled_angle);
  jacobian.block<1, 3>(8, 0) = prior.recalled_weight * fold.before;
  jacobian.block<1, 3>(8, kAfter) = prior.recalled_weight * fold.after;

  residual.segment<2>(6) = (after.opening - before.opening) / prior.sigma_walk;
  jacobian.block<2, 2>(6, 6) = -Eigen::Matrix2d::Identity() / prior.sigma_walk;
  jacobian.block<2, 2>(6, kAfter + 6) = Eigen::Matrix2d::Identity() / prior.sigma_walk;

  CreaseFit fit;
  fit.cost = residual.squaredNorm();
  fit.gradient = jacobian.transpose() * residual;
  fit.hessian = jacobian.transpose().lazyProduct(jacobian);
  return fit;
}

std::optional<ViewFit> FitOfView(const Camera& camera, const Eigen::Matrix<double, 3, 4>& corners_in_sheet,
                                 const Eigen::Matrix<double, 2, 4>& observed_px, const CornerSigma& sigma_px,
                                 const Eigen::Matrix3d& lab_from_sheet_rotation,
                                 const Eigen::Vector3d& tag_center_in_lab) {
  using Jet = ceres::Jet<double, 3>;
  constexpr double kNearest = 1e-3;  // m in front of the camera
  const Eigen::Matrix3d camera_from_lab = camera.camera_from_lab.linear();
  const Eigen::Matrix3d camera_from_sheet = camera_from_lab * lab_from_sheet_rotation;
  const Eigen::Vector3d center_in_camera = camera.camera_from_lab * tag_center_in_lab;
  const Eigen::Vector3d center_in_sheet = corners_in_sheet.rowwise().mean();

  Eigen::Matrix<double, 8, 1> residual;
  Eigen::Matrix<double, 8, 6> jacobian;
  for (int c = 0; c < 4; ++c) {
    const Eigen::Vector3d arm = corners_in_sheet.col(c) - center_in_sheet;
    const Eigen::Vector3d p = center_in_camera + camera_from_sheet * arm;
    if (!(p.z() > kNearest)) return std::nullopt;
    const Eigen::Vector3<Jet> moving(Jet(p.x(), 0), Jet(p.y(), 1), Jet(p.z(), 2));
    const Eigen::Vector2<Jet> pixel = ProjectInCamera<Jet>(camera, moving);
    Eigen::Matrix<double, 2, 3> by_camera;
    by_camera << pixel.x().v.transpose(), pixel.y().v.transpose();
    by_camera /= sigma_px.alone;
    residual[2 * c] = (pixel.x().a - observed_px(0, c)) / sigma_px.alone;
    residual[2 * c + 1] = (pixel.y().a - observed_px(1, c)) / sigma_px.alone;
    jacobian.block<2, 3>(2 * c, 0) = -by_camera * camera_from_sheet * CrossMatrix(arm);
    jacobian.block<2, 3>(2 * c, 3) = by_camera * camera_from_lab;
  }
  // What the corners have in common counts less: whitened by the root of (alone^2 I + shared^2 1 1^T)^-1.
  const double excess = 1 - sigma_px.alone / std::hypot(sigma_px.alone, 2 * sigma_px.shared);
  for (int axis = 0; axis < 2; ++axis) {
    double mean = 0;
    Eigen::Matrix<double, 1, 6> slope = Eigen::Matrix<double, 1, 6>::Zero();
    for (int row = axis; row < 8; row += 2) {
      mean += 0.25 * residual[row];
      slope += 0.25 * jacobian.row(row);
    }
    for (int row = axis; row < 8; row += 2) {
      residual[row] -= excess * mean;
      jacobian.row(row) -= excess * slope;
    }
  }
  ViewFit fit;
  fit.cost = residual.squaredNorm();
  fit.gradient = jacobian.transpose() * residual;
  fit.hessian = jacobian.transpose().lazyProduct(jacobian);
  if (!std::isfinite(fit.cost) || !fit.hessian.allFinite()) return std::nullopt;
  return fit;
}

namespace {

Eigen::Matrix<double, 6, 6> Loosened(const ViewFit& views, const TagSlop& slop) {
  Eigen::Matrix<double, 6, 6> loosened = views.hessian;
  loosened.diagonal().head<3>() += slop.turn_weight;
  loosened.bottomRightCorner<3, 3>() += slop.place_weight;
  return loosened;
}

// From a facet's step to its tag's.
Eigen::Matrix<double, 6, 6> TagFromFacet(const Eigen::Matrix3d& lab_from_sheet_rotation,
                                         const Eigen::Vector3d& hole_to_tag_in_sheet) {
  Eigen::Matrix<double, 6, 6> tag_from_facet = Eigen::Matrix<double, 6, 6>::Identity();
  tag_from_facet.bottomLeftCorner<3, 3>() = -lab_from_sheet_rotation * CrossMatrix(hole_to_tag_in_sheet);
  return tag_from_facet;
}

}  // namespace

ViewFit WithSlop(const ViewFit& views, const TagSlop& slop) {
  const Eigen::LLT<Eigen::Matrix<double, 6, 6>> loosened(Loosened(views, slop));
  ViewFit fit;
  const Eigen::Matrix<double, 6, 1> pulled = loosened.solve(views.gradient);
  fit.cost = views.cost - views.gradient.dot(pulled);
  fit.gradient = views.gradient - views.hessian * pulled;
  const Eigen::Matrix<double, 6, 6> shared = loosened.solve(views.hessian);
  fit.hessian = views.hessian - Eigen::Matrix<double, 6, 6>(views.hessian.lazyProduct(shared));
  return fit;
}

Eigen::Matrix<double, 6, 1> MostProbableStep(const ViewFit& views, const TagSlop& slop) {
  return -Loosened(views, slop).llt().solve(views.gradient);
}

FacetPulls PullsOnFacet(const ViewFit& views, const TagSlop& slop,
                        const Eigen::Matrix<double, 6, 2>& gradients,
                        const Eigen::Matrix3d& lab_from_sheet_rotation,
                        const Eigen::Vector3d& hole_to_tag_in_sheet) {
  const Eigen::Matrix<double, 6, 2> left =
      gradients - views.hessian * Loosened(views, slop).llt().solve(gradients);
  FacetPulls pulls = FacetPulls::Zero();
  pulls.topRows<6>() = TagFromFacet(lab_from_sheet_rotation, hole_to_tag_in_sheet).transpose() * left;
  return pulls;
}

void AddToFacet(const ViewFit& tag, const Eigen::Matrix3d& lab_from_sheet_rotation,
                const Eigen::Vector3d& hole_to_tag_in_sheet, FacetVector& gradient, FacetMatrix& hessian) {
  const Eigen::Matrix<double, 6, 6> tag_from_facet =
      TagFromFacet(lab_from_sheet_rotation, hole_to_tag_in_sheet);
  gradient.head<6>() += tag_from_facet.transpose() * tag.gradient;
  const Eigen::Matrix<double, 6, 6> moved = tag.hessian.lazyProduct(tag_from_facet);
  hessian.topLeftCorner<6, 6>() += tag_from_facet.transpose().lazyProduct(moved);
}

}  // namespace tendril
