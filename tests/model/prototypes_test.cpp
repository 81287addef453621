// The paper's four prototypes (examples/designs, Results: "Deterministic Deformation Programming"): straight
// contraction; folds largest and first closed at the tip; planar bending of constant sign; a helix.
#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <numbers>

#include "model/fold/facet_chain.h"
#include "model/fold/fold.h"

namespace tendril {
namespace {

TentacleDesign Prototype(double taper, double spacing_ratio, double beta_deg) {
  TentacleDesign design;
  design.taper = taper;
  design.spacing_ratio = spacing_ratio;
  design.beta = beta_deg * std::numbers::pi / 180;
  return design;
}

TendonCurve CurveAt(const TentacleDesign& design, double pull) {
  const TentacleLayout layout = LayOut(design).value();
  const Fold fold = SolveFold(design, pull).value();
  return TendonCurveOf(layout, FoldChain(layout, fold.angle), fold.angle);
}

TEST(Prototypes, UniformContractsStraight) {
  const TentacleDesign design = Prototype(1, 1, 90);
  for (const double pull : {0.1, 0.3, 0.7}) {
    const TendonCurve curve = CurveAt(design, pull);
    EXPECT_LT(curve.turning.cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_NEAR(curve.holes(2, 48), (1 - pull) * 0.72, 1e-12);
    EXPECT_LT(curve.holes.topRows<2>().cwiseAbs().maxCoeff(), 1e-13);
    const Eigen::VectorXd angle = SolveFold(design, pull).value().angle;
    EXPECT_LT(angle.maxCoeff() - angle.minCoeff(), 1e-14);
  }
}

TEST(Prototypes, TaperFoldsTheTipFirst) {
  const TentacleDesign design = Prototype(0.5, 1, 90);
  const Eigen::VectorXd angle = SolveFold(design, 0.3).value().angle;
  for (int i = 1; i < 48; ++i) EXPECT_GT(angle[i], angle[i - 1]);
  // Creases close one after another, each nearer to the base.
  size_t before = 0;
  for (int percent = 30; percent <= 99; ++percent) {
    const std::vector<int> closed = SolveFold(design, 0.01 * percent).value().closed;
    EXPECT_GE(closed.size(), before);
    before = closed.size();
    for (size_t i = 0; i < closed.size(); ++i) {
      EXPECT_EQ(closed[i], 48 - static_cast<int>(closed.size()) + static_cast<int>(i));
    }
  }
  EXPECT_GE(before, 40u);
  // It stays in its plane and close to straight: 100 times less lateral travel than the bending prototype.
  const TendonCurve curve = CurveAt(design, 0.3);
  EXPECT_LT(curve.holes.row(1).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_GT(curve.holes(2, 48), 0.98 * 0.7 * 0.72);
}

TEST(Prototypes, SpacingBendsInAPlaneAlwaysTheSameWay) {
  const TendonCurve curve = CurveAt(Prototype(0.5, 0.5, 90), 0.3);
  EXPECT_LT(curve.holes.row(1).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_LT(curve.turning.row(0).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_LT(curve.turning.row(2).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_LT(curve.turning.row(1).maxCoeff(), -0.1);
}

TEST(Prototypes, ObliqueCreasesCoilIntoAHelix) {
  const TendonCurve curve = CurveAt(Prototype(0.5, 0.5, 75), 0.3);
  EXPECT_LT(curve.turning.row(1).maxCoeff(), 0);
  EXPECT_GT(curve.turning.row(2).minCoeff(), 0);
  const Eigen::Matrix3Xd centred = curve.holes.colwise() - curve.holes.rowwise().mean();
  const Eigen::Vector3d spread = centred.jacobiSvd().singularValues();
  EXPECT_GT(spread[2], 0.1 * spread[1]);  // out of every plane
  // One handedness throughout: unit by unit, three chords in a row span a volume of constant sign.
  int turned = 0;
  for (int i = 0; i + 6 < 49; i += 2) {
    const Eigen::Vector3d a = curve.holes.col(i + 2) - curve.holes.col(i);
    const Eigen::Vector3d b = curve.holes.col(i + 4) - curve.holes.col(i + 2);
    const Eigen::Vector3d c = curve.holes.col(i + 6) - curve.holes.col(i + 4);
    turned += a.cross(b).dot(c) > 0 ? 1 : -1;
  }
  EXPECT_EQ(std::abs(turned), 22);
}

}  // namespace
}  // namespace tendril
