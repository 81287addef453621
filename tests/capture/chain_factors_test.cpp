// capture/track/chain_factors.h, chain_matrix.h and chain_curve.h: derivatives against differences of the
// cost, the block-tridiagonal inverse against a dense one, the fold angle against the fold's own chain.
#include "capture/track/chain_factors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "capture/rig/virtual_truth.h"
#include "capture/track/chain_curve.h"
#include "capture/track/chain_matrix.h"
#include "capture/track/chain_options.h"
#include "model/fold/facet_chain.h"
#include "tests/support/synthetic_view.h"

namespace tendril {
namespace {

FacetState RandomState(std::mt19937_64& random, double turn, double move) {
  std::normal_distribution<double> normal;
  const auto three = [&] { return Eigen::Vector3d(normal(random), normal(random), normal(random)); };
  FacetState state;
  state.rotation = RotationOf(turn * three());
  state.hole = move * three();
  state.opening = 0.1 * Eigen::Vector2d(normal(random), normal(random));
  return state;
}

TEST(FitOfCrease, GradientIsHalfTheSlopeOfTheCost) {
  const TentacleLayout layout = LayOut({}).value();
  std::mt19937_64 random(1);
  for (const int number : {0, 1, 30}) {
    const CreaseGeometry crease = GeometryOfCrease(layout, number);
    const CreasePrior prior{.expected_angle = 0.4, .compliance = 1.3};
    for (const double turn : {0.0, 0.1, 0.7}) {
      const FacetState before = RandomState(random, 1, 0.1);
      FacetState after = RandomState(random, turn, 0.01);
      after.rotation = before.rotation * after.rotation;
      after.hole += before.hole;
      const CreaseFit fit = FitOfCrease(crease, prior, number, before, after);
      for (int k = 0; k < 2 * kFacetSize; ++k) {
        constexpr double kStep = 1e-6;
        const auto cost = [&](double step) {
          Eigen::VectorXd moved = Eigen::VectorXd::Zero(2 * kFacetSize);
          moved[k] = step;
          return FitOfCrease(crease, prior, number, Stepped(before, moved.head(kFacetSize)),
                             Stepped(after, moved.tail(kFacetSize)))
              .cost;
        };
        const double slope = (cost(kStep) - cost(-kStep)) / (2 * kStep);
        EXPECT_NEAR(2 * fit.gradient[k], slope, 1e-5 * (1 + std::abs(slope) + fit.gradient.norm()))
            << "crease " << number << ", turn " << turn << ", number " << k;
      }
    }
  }
}

TEST(FitOfView, GradientIsHalfTheSlopeOfTheCost) {
  const Camera camera = testing_support::CamerasAround(1).front();
  Eigen::Matrix<double, 3, 4> corners;
  corners << 0, 0, 0, 0, -0.003, 0.003, 0.003, -0.003, 0.1, 0.1, 0.106, 0.106;
  std::mt19937_64 random(2);
  const FacetState state = RandomState(random, 0.3, 0.01);
  const Eigen::Vector3d center = Eigen::Vector3d(0.12, 0, -0.3) + state.hole;
  Eigen::Matrix<double, 2, 4> observed;
  for (int c = 0; c < 4; ++c) {
    const Eigen::Vector3d arm = corners.col(c) - corners.rowwise().mean();
    observed.col(c) = Project(camera, center + state.rotation * arm).value() + Eigen::Vector2d(1.5 * c, -2);
  }
  const std::optional<ViewFit> fit = FitOfView(camera, corners, observed, {0.5, 0.3}, state.rotation, center);
  ASSERT_TRUE(fit.has_value());
  for (int k = 0; k < 6; ++k) {
    constexpr double kStep = 1e-6;
    const auto cost = [&](double step) {
      Eigen::Matrix<double, 6, 1> moved = Eigen::Matrix<double, 6, 1>::Zero();
      moved[k] = step;
      return FitOfView(camera, corners, observed, {0.5, 0.3}, state.rotation * RotationOf(moved.head<3>()),
                       center + moved.tail<3>())
          ->cost;
    };
    const double slope = (cost(kStep) - cost(-kStep)) / (2 * kStep);
    EXPECT_NEAR(2 * fit->gradient[k], slope, 1e-5 * (1 + std::abs(slope) + fit->gradient.norm())) << k;
  }
  // Behind the camera there is nothing to compare.
  const Eigen::Vector3d behind = camera.camera_from_lab.inverse() * Eigen::Vector3d(0, 0, -1);
  EXPECT_FALSE(FitOfView(camera, corners, observed, {0.5, 0.3}, state.rotation, behind).has_value());
}

TEST(FitOfView, CostIsTheChiSquareUnderNoiseThatCornersShare) {
  const Camera camera = testing_support::CamerasAround(1).front();
  Eigen::Matrix<double, 3, 4> corners;
  corners << 0, 0, 0, 0, -0.003, 0.003, 0.003, -0.003, 0.1, 0.1, 0.106, 0.106;
  const Eigen::Vector3d center(0.12, 0, -0.3);
  Eigen::Matrix<double, 2, 4> observed;
  Eigen::Matrix<double, 2, 4> off;
  off << 1, 2, -1, 3, 0.2, 0.1, 0.5, -2;
  for (int c = 0; c < 4; ++c) {
    const Eigen::Vector3d arm = corners.col(c) - corners.rowwise().mean();
    observed.col(c) = Project(camera, center + arm).value() + off.col(c);
  }
  const double alone = 0.07, shared = 0.2;
  const Eigen::Matrix4d covariance =
      alone * alone * Eigen::Matrix4d::Identity() + shared * shared * Eigen::Matrix4d::Ones();
  double expected = 0;
  for (int axis = 0; axis < 2; ++axis)
    expected += off.row(axis) * covariance.inverse() * off.row(axis).transpose();
  const auto fit = FitOfView(camera, corners, observed, {alone, shared}, Eigen::Matrix3d::Identity(), center);
  ASSERT_TRUE(fit.has_value());
  EXPECT_NEAR(fit->cost, expected, 1e-6 * expected);
}

TEST(WithSlop, IsTheMarginalOfTheFullQuadratic) {
  // Minimising cost(x + s) + |s / sigma|^2 over s, from its definition.
  Eigen::Matrix<double, 6, 6> root = Eigen::Matrix<double, 6, 6>::Random();
  ViewFit fit{
      .cost = 7, .gradient = Eigen::Matrix<double, 6, 1>::Random(), .hessian = root * root.transpose()};
  const ViewFit loose = WithSlop(
      fit, {.turn_weight = Eigen::Vector3d::Constant(4), .place_weight = 0.25 * Eigen::Matrix3d::Identity()});
  Eigen::Matrix<double, 6, 1> weight;
  weight << 4, 4, 4, 0.25, 0.25, 0.25;
  const Eigen::Matrix<double, 6, 1> x = 0.3 * Eigen::Matrix<double, 6, 1>::Random();
  const auto quadratic = [&](const Eigen::Matrix<double, 6, 1>& at) {
    return fit.cost + 2 * fit.gradient.dot(at) + at.dot(fit.hessian * at);
  };
  Eigen::Matrix<double, 6, 6> with_slop = fit.hessian;
  with_slop.diagonal() += weight;
  const Eigen::Matrix<double, 6, 1> slop = -with_slop.inverse() * (fit.gradient + fit.hessian * x);
  const double least = quadratic(x + slop) + slop.dot(weight.asDiagonal() * slop);
  EXPECT_NEAR(loose.cost + 2 * loose.gradient.dot(x) + x.dot(loose.hessian * x), least, 1e-9);
}

// Ends that are lifted alike lift the middle as much; two errors that average out lift it 1 / sqrt(2) as
// much.
TEST(HoleSlop, OfAFacetWithoutATagIsWiderByWhatItsBendLiftsAlongTheNormalAlone) {
  const ChainOptions options;
  const double bend = TruthRanges{}.facet_bend_sd;
  const double lift = 0.5 * bend * 0.005;  // of an end: half of the bend over 5 mm, m
  std::mt19937_64 random(4);
  const Eigen::Matrix3d rotation = RandomState(random, 1, 0).rotation;
  const Eigen::Matrix3d more = HoleSlop(options, rotation, false) - HoleSlop(options, rotation, true);
  const Eigen::Matrix3d in_sheet = rotation.transpose() * more * rotation;
  EXPECT_NEAR(std::sqrt(in_sheet(0, 0)), std::sqrt(lift * lift - lift * lift / 2), 0.01e-3);
  EXPECT_LT((in_sheet - in_sheet(0, 0) * Eigen::Vector3d(1, 0, 0).asDiagonal().toDenseMatrix()).norm(),
            1e-20);
}

TEST(FoldAngleBetween, IsTheAngleThatTheChainWasFoldedWith) {
  const TentacleLayout layout = LayOut({}).value();
  for (const double phi : {-0.17, 0.0, 1e-9, 0.5, 1.5707963, 1.7}) {
    const FacetChain chain = FoldChain(layout, Eigen::VectorXd::Constant(layout.crease_z.size(), phi));
    for (int i = 0; i < layout.crease_z.size(); ++i) {
      EXPECT_NEAR(FoldAngleBetween(GeometryOfCrease(layout, i), chain.tentacle_from_sheet[i].linear(),
                                   chain.tentacle_from_sheet[i + 1].linear()),
                  phi, 1e-9);
    }
  }
}

TEST(ChainCholesky, AgreesWithTheDenseInverse) {
  for (const int facets : {1, 2, 7}) {
    const int size = kFacetSize * facets;
    Eigen::MatrixXd dense = 40 * Eigen::MatrixXd::Identity(size, size);
    ChainMatrix matrix;
    for (int i = 0; i < facets; ++i) {
      const FacetMatrix root = FacetMatrix::Random();
      dense.block<kFacetSize, kFacetSize>(kFacetSize * i, kFacetSize * i) += root * root.transpose();
      if (i + 1 < facets) {
        matrix.below.push_back(3 * FacetMatrix::Random());
        dense.block<kFacetSize, kFacetSize>(kFacetSize * (i + 1), kFacetSize * i) = matrix.below.back();
        dense.block<kFacetSize, kFacetSize>(kFacetSize * i, kFacetSize * (i + 1)) =
            matrix.below.back().transpose();
      }
    }
    for (int i = 0; i < facets; ++i) {
      matrix.diagonal.push_back(dense.block<kFacetSize, kFacetSize>(kFacetSize * i, kFacetSize * i));
    }
    const Eigen::MatrixXd inverse = dense.inverse();
    const ChainCholesky cholesky(matrix);
    ASSERT_TRUE(cholesky.ok());
    const Eigen::MatrixXd all = cholesky.PoseCovariance();
    const std::vector<NearCovariance> near = cholesky.NearCovariances();
    std::vector<FacetVector> right(static_cast<std::size_t>(facets), FacetVector::Ones());
    const std::vector<FacetVector> x = cholesky.Solve(right);
    const Eigen::VectorXd expected = inverse * Eigen::VectorXd::Ones(size);
    for (int i = 0; i < facets; ++i) {
      const auto at = static_cast<std::size_t>(i);
      EXPECT_LT((x[at] - expected.segment<kFacetSize>(kFacetSize * i)).norm(), 1e-12);
      const auto block = [&](int j) {
        return inverse.block<kFacetSize, kFacetSize>(kFacetSize * i, kFacetSize * j);
      };
      EXPECT_LT((near[at].own - block(i)).norm(), 1e-12);
      if (i + 1 < facets) {
        EXPECT_LT((near[at].next - block(i + 1)).norm(), 1e-12);
      }
      for (int j = 0; j < facets; ++j) {
        EXPECT_LT((all.block<6, 6>(6 * i, 6 * j) - block(j).topLeftCorner<6, 6>()).norm(), 1e-12);
      }
    }
  }
}

TEST(FactorsOfCurve, KeepEachNodesOwnBlock) {
  const int nodes = 20;
  const Eigen::MatrixXd root = Eigen::MatrixXd::Random(3 * nodes, 3 * nodes);
  const Eigen::MatrixXd covariance = root * root.transpose();
  Eigen::MatrixXd with_turns = Eigen::MatrixXd::Zero(4 * nodes, 4 * nodes);
  with_turns.topLeftCorner(3 * nodes, 3 * nodes) = covariance;
  const Eigen::MatrixXd factor = FactorsOfCurve(with_turns, 24).points;
  EXPECT_EQ(factor.cols(), 24);
  const Eigen::MatrixXd product = factor * factor.transpose();
  for (int i = 0; i < nodes; ++i) {
    EXPECT_LT((product.block<3, 3>(3 * i, 3 * i) - covariance.block<3, 3>(3 * i, 3 * i)).norm(), 1e-9);
  }
  // With a column for each number it is the covariance itself.
  const Eigen::MatrixXd full = FactorsOfCurve(with_turns, 3 * nodes + 12).points;
  EXPECT_LT((full * full.transpose() - covariance).norm(), 1e-8 * covariance.norm());
}

}  // namespace
}  // namespace tendril
