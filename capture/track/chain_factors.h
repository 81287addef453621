#pragma once
// What the chain's solver asks of a guess: how badly does it fit one view of a tag, or the crease between two
// facets, and how does that change with the guess? Each answer is a quadratic form, ready to be added up.
//
// SI units, rad, px. Chi-squares are dimensionless: residuals are divided by their sigma.

#include <Eigen/Geometry>
#include <optional>

#include "capture/rig/camera_model.h"
#include "model/fold/design.h"

namespace tendril {

// One facet as the solver moves it. A step is (w, v, g): rotation <- rotation Exp(w), hole += v,
// opening += g.
struct FacetState {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // lab_from_sheet
  Eigen::Vector3d hole = Eigen::Vector3d::Zero();          // the facet's hole, in the lab, m
  // How far creases around here are opened or closed beyond what the fold law expects, of even and of odd
  // creases, rad at a crease of mean compliance.
  Eigen::Vector2d opening = Eigen::Vector2d::Zero();
};

inline constexpr int kFacetSize = 8;  // numbers in a step
using FacetVector = Eigen::Matrix<double, kFacetSize, 1>;
using FacetMatrix = Eigen::Matrix<double, kFacetSize, kFacetSize>;

Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& v);
Eigen::Matrix3d RotationOf(const Eigen::Vector3d& rotation_vector);
FacetState Stepped(const FacetState& state, const Eigen::Ref<const Eigen::VectorXd>& step);

// A crease in the sheet, and which way it folds.
struct CreaseGeometry {
  Eigen::Vector3d along;       // unit vector along the crease, in the sheet's frame
  Eigen::Vector3d across;      // along x (the sheet's normal): in the sheet, square to the crease
  Eigen::Vector3d arm_before;  // from the hole before to the crease's centre, m
  Eigen::Vector3d arm_after;   // from the hole after to the crease's centre, m
  double turn = -1;            // the next facet turns by turn * 2 phi about `along`
};
CreaseGeometry GeometryOfCrease(const TentacleLayout& layout, int crease);

// Fold angle phi between two facets' rotations, rad, in (-45 deg, 135 deg].
double FoldAngleBetween(const CreaseGeometry& crease, const Eigen::Matrix3d& before,
                        const Eigen::Matrix3d& after);

// The fold angle, and how it moves with a step w of either facet:
// d phi = before . w_before + after . w_after.
struct AngleMotion {
  double angle = 0;
  Eigen::RowVector3d before = Eigen::RowVector3d::Zero();
  Eigen::RowVector3d after = Eigen::RowVector3d::Zero();
};
//   relative  from the facet after to the one before: before^T after of their rotations
AngleMotion MotionOfAngle(const CreaseGeometry& crease, const Eigen::Matrix3d& relative);

// What is expected of a crease, and how firmly.
struct CreasePrior {
  double expected_angle = 0;  // phi by the fold law, rad
  double compliance = 1;      // how far this crease goes per unit of `opening`
  // Mismatch of the two facets' creases along the sheet's axes of the facet before, m.
  Eigen::Vector3d sigma_gap = {0.25e-3, 0.25e-3, 0.25e-3};
  double sigma_swing = 0.02;  // turning about other axes than the crease, rad
  double sigma_angle = 0.09;  // phi about its expectation, rad
  double sigma_walk = 0.02;   // change of `opening` from one facet to the next, rad
  // phi as another moment knows it, rad; weight 1 / sigma, 0: it does not.
  double recalled_angle = 0;
  double recalled_weight = 0;
};

// cost = sum of squared residuals; its gradient / 2 and Gauss-Newton Hessian / 2 over both facets' steps.
struct CreaseFit {
  double cost = 0;
  Eigen::Matrix<double, 2 * kFacetSize, 1> gradient;
  Eigen::Matrix<double, 2 * kFacetSize, 2 * kFacetSize> hessian;
};
CreaseFit FitOfCrease(const CreaseGeometry& crease, const CreasePrior& prior, int crease_number,
                      const FacetState& before, const FacetState& after);

// One view of a tag: cost, gradient / 2 and Hessian / 2 over a rigid step (w in the sheet's axes about the
// tag's centre, v in the lab) of the tag.
struct ViewFit {
  double cost = 0;
  Eigen::Matrix<double, 6, 1> gradient;
  Eigen::Matrix<double, 6, 6> hessian;
};

// 1-sigma error of a coordinate of a view's corners, px.
struct CornerSigma {
  double alone = 0;   // of each corner by itself, > 0
  double shared = 0;  // of all four together
};

// corners_in_sheet, observed_px: in the same order. None if a corner is behind the camera.
std::optional<ViewFit> FitOfView(const Camera& camera, const Eigen::Matrix<double, 3, 4>& corners_in_sheet,
                                 const Eigen::Matrix<double, 2, 4>& observed_px, const CornerSigma& sigma_px,
                                 const Eigen::Matrix3d& lab_from_sheet_rotation,
                                 const Eigen::Vector3d& tag_center_in_lab);

// How far a tag may sit off its place on the facet: weights (1 / variance) of a rigid step of the tag.
struct TagSlop {
  Eigen::Vector3d turn_weight;   // about the sheet's axes, 1/rad^2
  Eigen::Matrix3d place_weight;  // in the lab, 1/m^2
};

// The same views of one tag once the tag may sit a little off its place on the facet. The slop is integrated
// out, so what the views say about the tag's place is weaker, and the same for all cameras that see the tag.
ViewFit WithSlop(const ViewFit& views, const TagSlop& slop);

// The step that takes the tag from its place on the facet to where its views and the slop would have it.
Eigen::Matrix<double, 6, 1> MostProbableStep(const ViewFit& views, const TagSlop& slop);

// What two gradients of one view (over a step of the tag) do to the facet's, once the tag's slop has taken
// its part; `views` are all of the tag.
using FacetPulls = Eigen::Matrix<double, kFacetSize, 2>;
FacetPulls PullsOnFacet(const ViewFit& views, const TagSlop& slop,
                        const Eigen::Matrix<double, 6, 2>& gradients,
                        const Eigen::Matrix3d& lab_from_sheet_rotation,
                        const Eigen::Vector3d& hole_to_tag_in_sheet);

// From a step of the tag to a step of the facet: adds to the pose's part of gradient and Hessian.
void AddToFacet(const ViewFit& tag, const Eigen::Matrix3d& lab_from_sheet_rotation,
                const Eigen::Vector3d& hole_to_tag_in_sheet, FacetVector& gradient, FacetMatrix& hessian);

}  // namespace tendril
