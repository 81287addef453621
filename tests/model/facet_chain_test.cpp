// model/fold/facet_chain.h: rigid facets, the tendon's frames, and the shapes of the paper's prototypes.
#include "model/fold/facet_chain.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "model/fold/fold.h"
#include "model/geometry/rotation.h"

namespace tendril {
namespace {

struct Folded {
  TentacleLayout layout;
  Fold fold;
  FacetChain chain;
  TendonCurve curve;
};

Folded FoldAt(const TentacleDesign& design, double pull) {
  Folded folded;
  folded.layout = LayOut(design).value();
  folded.fold = SolveFold(folded.layout, design.base_width, design.closed_angle, pull).value();
  folded.chain = FoldChain(folded.layout, folded.fold.angle);
  folded.curve = TendonCurveOf(folded.layout, folded.chain, folded.fold.angle);
  return folded;
}

TEST(TendonCurve, ThePapersDesignBendsAndTwistsInTheStatedSense) {
  const Folded f = FoldAt({}, 0.3);
  EXPECT_NEAR(KinematicPull(f.layout, f.curve), 0.297, 5e-4);
  EXPECT_LT(f.curve.turning.row(1).maxCoeff(), 0);
  EXPECT_GT(f.curve.turning.row(2).minCoeff(), 0);
}

TEST(TendonCurve, StartsAtTheOriginAlongZWithItsNormalAlongX) {
  for (const double pull : {0.0, 0.1, 0.5, 1.0}) {
    const Folded f = FoldAt({}, pull);
    EXPECT_LT(f.curve.holes.col(0).norm(), 1e-15);
    EXPECT_LT((f.curve.frames[0] - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-14);
  }
}

TEST(TendonCurve, FramesAndLengthsIntegrateBackToTheHoles) {
  for (const double pull : {1e-12, 0.3, 0.6, 0.95}) {
    const Folded f = FoldAt({}, pull);
    Eigen::Matrix3d directors = Eigen::Matrix3d::Identity();  // columns
    Eigen::Vector3d hole = Eigen::Vector3d::Zero();
    for (Eigen::Index i = 0; i < f.curve.segment_length.size(); ++i) {
      if (i > 0) directors = directors * ExpSo3(f.curve.turning.col(i - 1));
      hole += f.curve.segment_length[i] * directors.col(2);
      EXPECT_LT((hole - f.curve.holes.col(i + 1)).norm(), 1e-13) << "pull " << pull << " hole " << i + 1;
      EXPECT_LT((directors.transpose() - f.curve.frames[i]).norm(), 1e-12);
    }
  }
}

}  // namespace
}  // namespace tendril
