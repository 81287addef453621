// capture/track/chain_turn.h and the turns of chain_curve.h: against the curve of facets that really were
// moved, against rigid motion, and against the virtual rig's truth.
#include "capture/track/chain_turn.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "capture/rig/portable_random.h"
#include "capture/track/chain_curve.h"
#include "model/fold/facet_chain.h"
#include "model/fold/fold.h"
#include "tests/support/normal_turns.h"
#include "tests/support/virtual_views.h"

namespace tendril {
namespace {

using testing_support::TangentAt;
using testing_support::TurnsBetween;

std::vector<FacetState> FoldedFacets(const TentacleLayout& layout, double pull) {
  const FacetChain chain = FoldChain(layout, SolveFold(TentacleDesign{}, pull).value().angle);
  std::vector<FacetState> facets;
  for (std::size_t i = 0; i < chain.tentacle_from_sheet.size(); ++i) {
    FacetState facet;
    facet.rotation = chain.tentacle_from_sheet[i].linear();
    facet.hole =
        chain.tentacle_from_sheet[i] * Eigen::Vector3d(0, 0, layout.hole_z[static_cast<Eigen::Index>(i)]);
    facets.push_back(facet);
  }
  return facets;
}

TEST(CurveOfSteps, IsWhatTheCurveDoesWhenFacetsMove) {
  const TentacleLayout layout = LayOut({}).value();
  std::mt19937_64 random(3);
  for (const double pull : {0.0, 0.1, 0.3, 0.4, 0.5}) {
    const std::vector<FacetState> facets = FoldedFacets(layout, pull);
    const auto size = static_cast<Eigen::Index>(facets.size());
    const Eigen::SparseMatrix<double> curve = CurveOfSteps(layout, facets);
    ASSERT_EQ(curve.rows(), 4 * size);
    ASSERT_EQ(curve.cols(), 6 * size);
    const FramedCurve before = CurveOfFacets(layout, facets);
    double off = 0;
    double moved = 0;
    for (int draw = 0; draw < 20; ++draw) {
      std::vector<FacetState> other = facets;
      Eigen::VectorXd step(6 * size);
      for (Eigen::Index i = 0; i < size; ++i) {
        Eigen::VectorXd one = Eigen::VectorXd::Zero(kFacetSize);
        for (int k = 0; k < 3; ++k) one[k] = DrawNormal(random, 1e-3);
        for (int k = 3; k < 6; ++k) one[k] = DrawNormal(random, 1e-6);
        step.segment<6>(6 * i) = one.head<6>();
        other[static_cast<std::size_t>(i)] = Stepped(other[static_cast<std::size_t>(i)], one);
      }
      const FramedCurve after = CurveOfFacets(layout, other);
      const Eigen::VectorXd told = curve * step;
      const Eigen::Matrix3Xd points = after.points - before.points;
      EXPECT_LT((points.reshaped() - told.head(3 * size)).norm(), 1e-12);
      const Eigen::VectorXd turned = TurnsBetween(before, after);
      off += (turned - told.tail(size)).squaredNorm();
      moved += turned.squaredNorm();
    }
    // Beyond, creases near the tip close: neighbouring segments run back on each other, and the sum of their
    // normals has hardly a direction.
    EXPECT_LT(std::sqrt(off / moved), pull < 0.45 ? 0.05 : 0.4) << "pull " << pull;
  }
}

// All facets turn by one small rotation: each normal turns by its part along the tangent.
TEST(CurveOfSteps, OfARigidTurnIsItsPartAlongTheCurve) {
  const TentacleLayout layout = LayOut({}).value();
  const std::vector<FacetState> facets = FoldedFacets(layout, 0.25);
  const FramedCurve curve = CurveOfFacets(layout, facets);
  const Eigen::Vector3d turn(0.3, -0.5, 0.8);
  const auto size = static_cast<Eigen::Index>(facets.size());
  Eigen::VectorXd step(6 * size);
  for (Eigen::Index i = 0; i < size; ++i) {
    const FacetState& facet = facets[static_cast<std::size_t>(i)];
    step.segment<3>(6 * i) = facet.rotation.transpose() * turn;
    step.segment<3>(6 * i + 3) = turn.cross(facet.hole);
  }
  const Eigen::VectorXd told = CurveOfSteps(layout, facets) * step;
  for (Eigen::Index i = 0; i < size; ++i) {
    EXPECT_NEAR(told[3 * size + i], turn.dot(TangentAt(curve.points, i)), 0.02) << i;
  }
}

TEST(CurveOfSteps, OfAlmostClosedSegmentsIsFinite) {
  const TentacleLayout layout = LayOut({}).value();
  const std::vector<FacetState> facets = FoldedFacets(layout, 0.999);
  const Eigen::MatrixXd curve = CurveOfSteps(layout, facets);
  EXPECT_TRUE(curve.allFinite());
  EXPECT_LT(curve.cwiseAbs().maxCoeff(), 10);
}

TEST(FactorsOfCurve, KeepTheTurnsVariancesAndThePointsFactor) {
  constexpr int kNodes = 20;
  const Eigen::MatrixXd root = Eigen::MatrixXd::Random(4 * kNodes, 4 * kNodes);
  const Eigen::MatrixXd covariance = root * root.transpose();
  const CurveFactors factors = FactorsOfCurve(covariance, 36);
  EXPECT_GT(factors.turns.cols(), factors.points.cols());
  for (int i = 0; i < kNodes; ++i) {
    EXPECT_NEAR(factors.turns.row(i).squaredNorm(), covariance(3 * kNodes + i, 3 * kNodes + i), 1e-9);
  }
  // With a column for each number also what turns have in common with points.
  const CurveFactors full = FactorsOfCurve(covariance, 3 * kNodes + 12);
  const Eigen::MatrixXd both = full.points * full.turns.leftCols(full.points.cols()).transpose();
  EXPECT_LT((both - covariance.topRightCorner(3 * kNodes, kNodes)).norm(), 1e-8 * covariance.norm());
}

// Errors over sigma, of the virtual rig's tentacles: seeds of their own.
TEST(TurnFactor, SaysHowFarNormalsAndTheirDifferenceFromTipToBaseAreTurned) {
  const TentacleDesign design;
  Gripper gripper;
  gripper.tentacles = 1;
  gripper.first_azimuth = 0;
  const TagLayout drawn = LayOutTags(design, gripper).value();
  const std::vector<Camera> cameras = VirtualRig(design, gripper).value().cameras;
  double nodes = 0;
  double ends = 0;
  constexpr int kSeeds = 30;
  for (int seed = 0; seed < kSeeds; ++seed) {
    std::mt19937_64 random(40000 + static_cast<std::uint64_t>(seed));
    const TruthRanges ranges;
    const VirtualTruth truth =
        DrawTruth(design, gripper, {0.95, 1, 1}, {0.3, 0.03}, {.radius = 0}, ranges, random).value();
    const TagLayout glued = GlueTags(drawn, ranges, random);
    const TrueShape shape = TrueShapeAt(truth, DrawUniform(random, 0, 11)).value();
    const auto seen =
        testing_support::SeeTentacle(shape, gripper, 0, drawn, glued, cameras, {.every = 2}, random);
    const ChainSolution found = SolveChain(seen.model, cameras, seen.views);
    const Eigen::VectorXd turned = TurnsBetween(found.curve, shape.tentacles[0].centerline);
    const Eigen::Index last = turned.size() - 1;
    ASSERT_EQ(found.turn_factor.rows(), last + 1);
    for (Eigen::Index i = 0; i <= last; ++i) {
      nodes += turned[i] * turned[i] / found.turn_factor.row(i).squaredNorm() /
               (kSeeds * static_cast<double>(last + 1));
    }
    ends += std::pow(turned[last] - turned[0], 2) /
            (found.turn_factor.row(last) - found.turn_factor.row(0)).squaredNorm() / kSeeds;
  }
  EXPECT_GT(nodes, 0.4);
  EXPECT_LT(nodes, 1.3);
  EXPECT_GT(ends, 0.35);
  EXPECT_LT(ends, 1.6);
}

}  // namespace
}  // namespace tendril
