// calibrate/fold/node_motion.h, shape_residual.h: derivatives against numeric ones, the chain against one
// that shares no code with it.
#include "calibrate/fold/node_motion.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "calibrate/fold/shape_residual.h"
#include "tests/support/perturbed_tentacle.h"

namespace tendril {
namespace {

// Law exact, where every direction counts.
struct Place {
  double pull = 0.2, log_ratio = 0.3, exponent = 1.2, rest_angle = 0.1, friction = 0.05;
  double& operator[](int i) {
    double* const all[] = {&pull, &log_ratio, &exponent, &rest_angle, &friction};
    return *all[i];
  }
};

FoldTangent ExactFoldAt(const TentacleDesign& design, const TentacleLayout& layout, const Place& at) {
  return FoldAt(design, layout,
                {at.pull, at.log_ratio, at.exponent, at.rest_angle, at.friction, FoldLaw::kExact, true, true})
      .value();
}

TentacleDesign RandomDesign(std::mt19937_64& random) {
  TentacleDesign d;
  d.holes = 17;
  d.taper = test::Uniform(random, 0.2, 1);
  d.spacing_ratio = test::Uniform(random, 0.3, 1);
  d.alpha = test::Uniform(random, 1.2, 1.9);
  d.beta = test::Uniform(random, 1.0, 2.1);
  return d;
}

TEST(FoldAt, SlopesAgreeWithCentralDifferences) {
  std::mt19937_64 random(7);
  for (int draw = 0; draw < 30; ++draw) {
    const TentacleDesign design = RandomDesign(random);
    const TentacleLayout layout = LayOut(design).value();
    Place at{test::Uniform(random, 0.02, 0.6), test::Uniform(random, -1, 1), test::Uniform(random, -1, 3)};
    const FoldTangent fold = FoldAt(design, layout, {at.pull, at.log_ratio, at.exponent}).value();
    for (int k = 0; k < 3; ++k) {
      Place low = at, high = at;
      const double step = 1e-6;
      low[k] -= step;
      high[k] += step;
      const FoldTangent a = FoldAt(design, layout, {low.pull, low.log_ratio, low.exponent}).value();
      const FoldTangent b = FoldAt(design, layout, {high.pull, high.log_ratio, high.exponent}).value();
      if (a.closed != b.closed) continue;  // a kink of the law
      const Eigen::VectorXd numeric = (b.angle - a.angle) / (2 * step);
      EXPECT_LT((numeric - fold.slope.col(k)).cwiseAbs().maxCoeff(),
                1e-6 * (1 + numeric.cwiseAbs().maxCoeff()))
          << "draw " << draw << " direction " << k;
    }
  }
}

TEST(FoldAt, SlopesOfTheExactLawAgreeWithCentralDifferencesInEveryDirection) {
  std::mt19937_64 random(29);
  int compared = 0;
  for (int draw = 0; draw < 20; ++draw) {
    const TentacleDesign design = RandomDesign(random);
    const TentacleLayout layout = LayOut(design).value();
    const Place at{test::Uniform(random, 0.12, 0.4), test::Uniform(random, -0.5, 0.5),
                   test::Uniform(random, 0, 2)};
    const FoldTangent fold = ExactFoldAt(design, layout, at);
    for (int k = 0; k < kFoldDirections; ++k) {
      Place low = at, high = at;
      const double step = 1e-6;
      low[k] -= step;
      high[k] += step;
      const FoldTangent a = ExactFoldAt(design, layout, low);
      const FoldTangent b = ExactFoldAt(design, layout, high);
      if (a.closed != b.closed) continue;  // a kink of the law
      const Eigen::VectorXd numeric = (b.angle - a.angle) / (2 * step);
      EXPECT_GT(numeric.norm(), 1e-3) << "draw " << draw << " direction " << k;
      EXPECT_LT((numeric - fold.slope.col(k)).cwiseAbs().maxCoeff(),
                2e-5 * (1 + numeric.cwiseAbs().maxCoeff()))
          << "draw " << draw << " direction " << k;
      ++compared;
    }
  }
  EXPECT_GT(compared, 80);
}

TEST(FoldAt, FlatHasNoSlopes) {
  const TentacleDesign design;
  const FoldTangent fold = FoldAt(design, LayOut(design).value(), {0, 0.5, 2}).value();
  EXPECT_EQ(fold.angle.norm(), 0);
  EXPECT_EQ(fold.slope.norm(), 0);
}

TEST(FoldAt, AllClosedDoesNotMove) {
  const TentacleDesign design;
  const FoldTangent fold = FoldAt(design, LayOut(design).value(), {1, 0, 1}).value();
  EXPECT_TRUE(fold.slope.allFinite());
  EXPECT_LT(fold.slope.col(kLogRatio).norm(), 1e-6);
}

TEST(FoldAt, RefusesWhatIsNotANumber) {
  const TentacleDesign design;
  EXPECT_FALSE(FoldAt(design, LayOut(design).value(), {0.1, std::nan(""), 1}).ok());
  EXPECT_FALSE(FoldAt(design, LayOut(design).value(), {1.5, 0, 1}).ok());
}

// All distances between nodes, which no pose changes.
Eigen::VectorXd Distances(const Eigen::Matrix3Xd& nodes) {
  Eigen::VectorXd all(nodes.cols() * (nodes.cols() - 1) / 2);
  Eigen::Index k = 0;
  for (Eigen::Index i = 0; i < nodes.cols(); ++i) {
    for (Eigen::Index j = i + 1; j < nodes.cols(); ++j) all[k++] = (nodes.col(i) - nodes.col(j)).norm();
  }
  return all;
}

TEST(MoveNodes, AgreesWithAChainOfItsOwn) {
  std::mt19937_64 random(11);
  for (int draw = 0; draw < 10; ++draw) {
    const TentacleDesign design = RandomDesign(random);
    const TentacleLayout layout = LayOut(design).value();
    const test::FoldTruth truth{1, 1.3, 0.8};
    const Eigen::Matrix3Xd own = test::HolesAt(test::Draw(design, truth, test::kExactly, random), 0.3);
    const NodeMotion motion = MoveNodes(layout, FoldAt(design, layout, {0.3, std::log(1.3), 0.8}).value());
    EXPECT_LT((Distances(own) - Distances(motion.nodes)).cwiseAbs().maxCoeff(), 1e-12);
    SeenNodes seen;  // and it is no mirror image
    seen.index = Eigen::VectorXi::LinSpaced(own.cols(), 0, static_cast<int>(own.cols()) - 1);
    seen.points = own;
    seen.sigma.setConstant(own.cols(), 1e-3);
    EXPECT_LT(AlignedRms(motion.nodes, seen), 1e-12);
  }
}

TEST(MoveNodes, VelocitiesAgreeWithCentralDifferencesOfAllDistances) {
  std::mt19937_64 random(13);
  for (int draw = 0; draw < 10; ++draw) {
    const TentacleDesign design = RandomDesign(random);
    const TentacleLayout layout = LayOut(design).value();
    Place at;
    const NodeMotion motion = MoveNodes(layout, ExactFoldAt(design, layout, at));
    for (int k = 0; k < kFoldDirections; ++k) {
      const double step = 1e-6;
      Place low = at, high = at;
      low[k] -= step;
      high[k] += step;
      const Eigen::VectorXd numeric = (Distances(MoveNodes(layout, ExactFoldAt(design, layout, high)).nodes) -
                                       Distances(MoveNodes(layout, ExactFoldAt(design, layout, low)).nodes)) /
                                      (2 * step);
      const Eigen::Matrix3Xd& v = motion.velocity[static_cast<std::size_t>(k)];
      Eigen::Index row = 0;
      for (Eigen::Index i = 0; i < v.cols(); ++i) {
        for (Eigen::Index j = i + 1; j < v.cols(); ++j, ++row) {
          const Eigen::Vector3d chord = motion.nodes.col(i) - motion.nodes.col(j);
          ASSERT_NEAR(chord.dot(v.col(i) - v.col(j)) / chord.norm(), numeric[row], 2e-7)
              << i << " " << j << " " << k;
        }
      }
    }
  }
}

SeenNodes Noisy(const Eigen::Matrix3Xd& nodes, std::mt19937_64& random) {
  SeenNodes seen;
  std::vector<int> kept;
  for (int i = 0; i < nodes.cols(); ++i) {
    if (i % 5 != 3) kept.push_back(i);
  }
  const Eigen::Index n = static_cast<Eigen::Index>(kept.size());
  seen.index = Eigen::Map<Eigen::VectorXi>(kept.data(), n);
  seen.points.resize(3, n);
  seen.sigma.resize(n);
  const Eigen::Matrix3d turn = Eigen::Quaterniond(0.1, 0.7, -0.3, 0.6).normalized().toRotationMatrix();
  for (Eigen::Index i = 0; i < n; ++i) {
    seen.points.col(i) = turn * nodes.col(kept[static_cast<std::size_t>(i)]) + Eigen::Vector3d(1, 2, 3);
    for (int k = 0; k < 3; ++k) seen.points(k, i) += test::Normal(random, 1e-3);
    seen.sigma[i] = test::Uniform(random, 0.2e-3, 2e-3);
  }
  return seen;
}

TEST(ResidualOf, CostGradientAgreesWithCentralDifferences) {
  std::mt19937_64 random(17);
  for (const ShapeResidualKind kind :
       {ShapeResidualKind::kAlignedWindows, ShapeResidualKind::kLocalDistances}) {
    for (const int window : {5, 9, 100}) {
      ShapeResidualOptions options;
      options.kind = kind;
      options.window = window;
      const TentacleDesign design = RandomDesign(random);
      const TentacleLayout layout = LayOut(design).value();
      Place at;
      const auto model = [&](const Place& p) { return MoveNodes(layout, ExactFoldAt(design, layout, p)); };
      const SeenNodes seen = Noisy(model(Place{0.23, 0, 1}).nodes, random);
      const ShapeResidual residual = ResidualOf(model(at), seen, options);
      ASSERT_EQ(residual.value.size(), ResidualRows(seen, design.holes, options));
      ASSERT_GT(residual.value.size(), 0);
      for (int k = 0; k < kFoldDirections; ++k) {
        const double step = 1e-5;
        Place low = at, high = at;
        low[k] -= step;
        high[k] += step;
        const double numeric = (ResidualOf(model(high), seen, options).value.squaredNorm() -
                                ResidualOf(model(low), seen, options).value.squaredNorm()) /
                               (4 * step);
        EXPECT_NEAR(residual.value.dot(residual.slope.col(k)), numeric, 1e-5 * (1 + std::abs(numeric)))
            << "window " << window << " direction " << k;
      }
    }
  }
}

TEST(ResidualOf, SlopesOfDistancesWithScatterAgreeWithCentralDifferences) {
  std::mt19937_64 random(23);
  for (const int creases : {1, 3}) {
    ShapeResidualOptions options;
    options.creases = creases;
    const TentacleDesign design = RandomDesign(random);
    const TentacleLayout layout = LayOut(design).value();
    const auto residual = [&](const std::array<double, 5>& at, const SeenNodes& seen) {
      return ResidualOf(MoveNodes(layout, FoldAt(design, layout, {at[0], at[1], at[2]}).value()), seen,
                        options, {at[3], at[4]});
    };
    const std::array<double, 5> at = {0.2, 0.3, 1.2, 0.8, -0.4};
    const SeenNodes seen =
        Noisy(MoveNodes(layout, FoldAt(design, layout, {0.22, 0, 1}).value()).nodes, random);
    const ShapeResidual here = residual(at, seen);
    for (std::size_t k = 0; k < 5; ++k) {
      std::array<double, 5> low = at, high = at;
      low[k] -= 1e-6;
      high[k] += 1e-6;
      const Eigen::VectorXd numeric = (residual(high, seen).value - residual(low, seen).value) / 2e-6;
      EXPECT_LT((numeric - here.slope.col(static_cast<Eigen::Index>(k < 3 ? k : k - 3 + kFoldDirections)))
                    .cwiseAbs()
                    .maxCoeff(),
                1e-6 * (1 + numeric.cwiseAbs().maxCoeff()))
          << "direction " << k;
    }
  }
}

TEST(ResidualOf, DoesNotSeeThePose) {
  std::mt19937_64 random(19);
  const TentacleDesign design;
  const TentacleLayout layout = LayOut(design).value();
  const NodeMotion model = MoveNodes(layout, FoldAt(design, layout, {0.3, 0, 1}).value());
  for (const double far : {0.0, 1e6}) {  // a million metres costs digits, not sense
    SeenNodes seen = Noisy(model.nodes, random);
    const Eigen::VectorXd distances = ResidualOf(model, seen, {}).value;
    ShapeResidualOptions windows;
    windows.kind = ShapeResidualKind::kAlignedWindows;
    const Eigen::VectorXd before = ResidualOf(model, seen, windows).value;
    const Eigen::Matrix3d turn = Eigen::Quaterniond(0.5, -0.2, 0.3, 0.1).normalized().toRotationMatrix();
    seen.points = (turn * seen.points).colwise() + Eigen::Vector3d(far, 0, far);
    EXPECT_LT((ResidualOf(model, seen, {}).value - distances).cwiseAbs().maxCoeff(), far == 0 ? 1e-9 : 1e-4);
    const Eigen::VectorXd after = ResidualOf(model, seen, windows).value;
    // Components turn with the pose; their lengths per node do not.
    for (Eigen::Index i = 0; i < before.size(); i += 3) {
      EXPECT_NEAR(before.segment<3>(i).norm(), after.segment<3>(i).norm(), far == 0 ? 1e-9 : 1e-4);
    }
  }
}

TEST(ResidualOf, AStraightTentacleIsFinite) {
  const TentacleDesign design;
  const TentacleLayout layout = LayOut(design).value();
  const NodeMotion flat = MoveNodes(layout, FoldAt(design, layout, {0, 0, 1}).value());
  SeenNodes seen;
  seen.index = Eigen::VectorXi::LinSpaced(49, 0, 48);
  seen.points = flat.nodes;
  seen.sigma.setZero(49);
  const NodeMotion bent = MoveNodes(layout, FoldAt(design, layout, {0.2, 0, 1}).value());
  for (const NodeMotion& model : {flat, bent}) {
    for (const ShapeResidualKind kind :
         {ShapeResidualKind::kAlignedWindows, ShapeResidualKind::kLocalDistances}) {
      ShapeResidualOptions options;
      options.kind = kind;
      const ShapeResidual residual = ResidualOf(model, seen, options);
      EXPECT_TRUE(residual.value.allFinite());
      EXPECT_TRUE(residual.slope.allFinite());
    }
  }
}

}  // namespace
}  // namespace tendril
