// capture/track/chain_solve.h: shapes found from synthetic tag corners against the truth they were made from,
// with fewer cameras, fewer tags and gross outliers; and whether sigma says how far off they are.
#include "capture/track/chain_solve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "capture/track/chain_calibration.h"
#include "tests/support/synthetic_view.h"

namespace tendril {
namespace {

using testing_support::CamerasAround;
using testing_support::Imperfection;
using testing_support::MakeTruth;
using testing_support::PlanarDesign;
using testing_support::Truth;
using testing_support::Visibility;

// Errors over several draws.
struct Score {
  double seen_squares = 0;
  double seen_normalised = 0;  // sum of (error / sigma)^2
  int seen = 0;
  double bridged_normalised = 0;
  int bridged = 0;
  int outliers = 0;
  int outliers_used = 0;
  int good = 0;
  int good_left_out = 0;
  int unfinished = 0;

  double rms() const { return std::sqrt(seen_squares / seen); }
};

void Add(const Truth& truth, const ChainSolution& solution, Score& score) {
  EXPECT_TRUE(solution.curve.points.allFinite());
  EXPECT_TRUE(solution.curve.normals.allFinite());
  for (int i = 0; i < truth.holes.cols(); ++i) {
    const double error = (solution.curve.points.col(i) - truth.holes.col(i)).norm();
    const double normalised = std::pow(error / solution.sigma[i], 2);
    if (solution.interpolated[i] == 0) {
      score.seen_squares += error * error;
      score.seen_normalised += normalised;
      ++score.seen;
    } else if (std::isfinite(solution.sigma[i])) {
      score.bridged_normalised += normalised;
      ++score.bridged;
    }
  }
  for (std::size_t v = 0; v < truth.views.size(); ++v) {
    (truth.outlier[v] != 0 ? score.outliers : score.good) += 1;
    if (truth.outlier[v] != 0) score.outliers_used += solution.used[v];
    if (truth.outlier[v] == 0) score.good_left_out += 1 - solution.used[v];
  }
  score.unfinished += solution.converged ? 0 : 1;
}

Score ScoreOf(const TentacleDesign& design, int cameras, const Visibility& picture, int draws) {
  const std::vector<Camera> rig = CamerasAround(cameras);
  Score score;
  for (const double pull : {0.0, 0.1, 0.2, 0.3}) {
    for (int draw = 0; draw < draws; ++draw) {
      std::mt19937_64 random(1000 + draw);
      const Truth truth = MakeTruth(design, pull, rig, picture, Imperfection{}, random);
      Add(truth, SolveChain(truth.model, rig, truth.views), score);
    }
  }
  return score;
}

struct Case {
  const char* name;
  bool planar;
  int cameras;
  Visibility picture;
  double largest_rms;  // m
};

class SolveChainFinds : public testing::TestWithParam<Case> {};

TEST_P(SolveChainFinds, TheTrueHolesWithinItsSigma) {
  const Case& c = GetParam();
  const Score score = ScoreOf(c.planar ? PlanarDesign() : TentacleDesign{}, c.cameras, c.picture, 6);
  EXPECT_LT(score.rms(), c.largest_rms);
  EXPECT_EQ(score.unfinished, 0);
  EXPECT_LE(score.good_left_out, score.good / 100);
  EXPECT_LE(score.outliers_used, score.outliers / 20);
  // Sigmas must cover what real facets do beyond the truth drawn here, so they lean to the large side.
  EXPECT_LT(score.seen_normalised / score.seen, 2.0);
  EXPECT_LT(score.bridged_normalised / score.bridged, 2.0);
  EXPECT_GT(score.seen_normalised / score.seen, c.picture.kept < 1 || c.cameras == 1 ? 0.2 : 0.5);
  RecordProperty("rms_mm", std::to_string(1e3 * score.rms()));
}

INSTANTIATE_TEST_SUITE_P(
    Views, SolveChainFinds,
    testing::Values(Case{"coil_two", false, 2, {}, 0.5e-3}, Case{"planar_two", true, 2, {}, 0.5e-3},
                    Case{"coil_four", false, 4, {}, 0.5e-3}, Case{"coil_one", false, 1, {}, 2e-3},
                    Case{"planar_one", true, 1, {}, 2e-3},
                    Case{"coil_two_few_tags", false, 2, {.kept = 0.3}, 1e-3},
                    Case{"planar_two_few_tags", true, 2, {.kept = 0.3}, 1e-3},
                    Case{"coil_two_stated", false, 2, {.states_sigma = true}, 0.5e-3},
                    Case{"coil_two_outliers", false, 2, {.outliers = 0.05}, 0.5e-3},
                    Case{"coil_one_outliers", false, 1, {.outliers = 0.05}, 2e-3},
                    Case{"planar_two_few_tags_outliers", true, 2, {.kept = 0.3, .outliers = 0.05}, 2e-3}),
    [](const testing::TestParamInfo<Case>& tried) { return std::string(tried.param.name); });

// An independent way: the pictures of a camera are shifted (or stretched) and the chain is solved again.
TEST(SolveChain, ACameraThatIsWrongMovesTheHolesAsForetold) {
  const std::vector<Camera> rig = CamerasAround(2);
  const ChainOptions options;
  std::mt19937_64 random(77);
  const Truth truth = MakeTruth(TentacleDesign{}, 0.2, rig, {}, Imperfection{}, random);
  const auto solved = [&](const std::vector<TagView>& views, std::vector<FacetState> start) {
    const ChainProblem problem = MakeChainProblem(truth.model, rig, views, options);
    Descent run{.facets = std::move(start), .at = {}, .weight = std::vector<double>(views.size(), 1)};
    Descend(problem, run, true);
    return run;
  };
  const Descent run = solved(truth.views, SolveChain(truth.model, rig, truth.views).facets);
  const ChainProblem problem = MakeChainProblem(truth.model, rig, truth.views, options);
  const Eigen::MatrixXd foretold = PosesByCalibration(problem, run, ChainCholesky(run.at.matrix));
  ASSERT_EQ(foretold.cols(), 12);
  const double share = options.sigma_calibration_px / std::sqrt(3.0);
  // Columns: of each camera, constant, slope across, slope down, in x, then in y.
  for (const int column : {0, 3, 2, 6 + 3, 6 + 1}) {
    const int camera = column / 6;
    const int axis = column % 6 / 3;
    std::vector<TagView> views = truth.views;
    for (TagView& view : views) {
      if (view.camera != camera) continue;
      const Eigen::Vector2d middle = view.corners_px.rowwise().mean();
      const Camera& c = rig[static_cast<std::size_t>(camera)];
      const double fields[3] = {1, std::sqrt(3.0) * (2 * middle.x() / c.width_px - 1),
                                std::sqrt(3.0) * (2 * middle.y() / c.height_px - 1)};
      view.corners_px.row(axis).array() += share * fields[column % 3];
    }
    const Descent other = solved(views, run.facets);
    double off = 0;
    double size = 0;
    for (std::size_t i = 0; i < run.facets.size(); ++i) {
      const Eigen::Vector3d moved = other.facets[i].hole - run.facets[i].hole;
      const Eigen::Vector3d told = foretold.block<3, 1>(6 * static_cast<Eigen::Index>(i) + 3, column);
      off += (moved - told).squaredNorm();
      size += moved.squaredNorm();
    }
    EXPECT_GT(std::sqrt(size / 49), 1e-6) << column;
    EXPECT_LT(std::sqrt(off / size), 0.1) << column;
  }
}

TEST(SolveChain, WithoutNoiseAndFaultsTheShapeIsExact) {
  const Imperfection none{.hole = 0,
                          .crease = 0,
                          .crease_angle = 0,
                          .fold_angle = 0,
                          .pull = 0,
                          .bend = 0,
                          .sag = 0,
                          .tag_turn = 0,
                          .tag_place = 0,
                          .corner_px = 0};
  const std::vector<Camera> rig = CamerasAround(2);
  for (const double pull : {0.0, 1e-6, 0.3, 0.45}) {
    std::mt19937_64 random(1);
    const Truth truth = MakeTruth({}, pull, rig, {}, none, random);
    const ChainSolution solution = SolveChain(truth.model, rig, truth.views);
    EXPECT_LT((solution.curve.points - truth.holes).colwise().norm().maxCoeff(), 2e-6) << pull;
    EXPECT_LT(solution.rms_reprojection_px, 1e-3);
    EXPECT_EQ(solution.views_rejected, 0);
    const FacetChain chain = FoldChain(truth.model.layout, truth.model.expected_angle);
    const FramedCurve expected =
        NodesAtHoles(TendonCurveOf(truth.model.layout, chain, truth.model.expected_angle));
    const Eigen::Matrix3Xd normals = truth.model.lab_from_tentacle.linear() * expected.normals;
    EXPECT_LT((solution.curve.normals - normals).colwise().norm().maxCoeff(), 1e-3) << pull;
  }
}

TEST(SolveChain, NoTagAtAllIsTheLawsShapeAndNotSeen) {
  const std::vector<Camera> rig = CamerasAround(2);
  std::mt19937_64 random(2);
  const Truth truth = MakeTruth({}, 0.2, rig, {}, {}, random);
  const ChainSolution solution = SolveChain(truth.model, rig, {});
  EXPECT_TRUE(solution.curve.points.allFinite());
  EXPECT_TRUE(solution.sigma.array().isNaN().all());
  EXPECT_TRUE((solution.interpolated.array() == 1).all());
  EXPECT_TRUE(std::isnan(solution.rms_reprojection_px));
  const FacetChain chain = FoldChain(truth.model.layout, truth.model.expected_angle);
  for (int i = 0; i < truth.holes.cols(); ++i) {
    const Eigen::Vector3d hole = truth.model.lab_from_tentacle * chain.tentacle_from_sheet[i] *
                                 Eigen::Vector3d(0, 0, truth.model.layout.hole_z[i]);
    EXPECT_LT((solution.curve.points.col(i) - hole).norm(), 1e-9);
  }
}

TEST(SolveChain, OneTagSeenTellsOfItsNeighbourhoodOnly) {
  const std::vector<Camera> rig = CamerasAround(2);
  std::mt19937_64 random(3);
  const Truth truth = MakeTruth({}, 0.1, rig, {}, {}, random);
  std::vector<TagView> one;
  for (const TagView& view : truth.views) {
    if (view.place->facet == 30) one.push_back(view);
  }
  ASSERT_FALSE(one.empty());
  one.resize(1);
  const ChainSolution solution = SolveChain(truth.model, rig, one);
  EXPECT_TRUE(solution.curve.points.allFinite());
  EXPECT_EQ(solution.facets_seen, 1);
  EXPECT_EQ(solution.interpolated.sum(), 48);
  EXPECT_TRUE(std::isfinite(solution.sigma[30]));
  EXPECT_TRUE(std::isnan(solution.sigma[0]));
  EXPECT_TRUE(std::isnan(solution.sigma[48]));
  EXPECT_LT((solution.curve.points.col(30) - truth.holes.col(30)).norm(), 3 * solution.sigma[30]);
  // Sigma grows away from what was seen.
  EXPECT_GT(solution.sigma[34], solution.sigma[30]);
}

TEST(SolveChain, CornersThatAreNoNumbersOrFoldedOverAreLeftOut) {
  const std::vector<Camera> rig = CamerasAround(2);
  std::mt19937_64 random(4);
  Truth truth = MakeTruth({}, 0.1, rig, {}, {}, random);
  truth.views[3].corners_px(0, 2) = std::numeric_limits<double>::quiet_NaN();
  truth.views[7].corners_px.setConstant(std::numeric_limits<double>::infinity());
  truth.views[12].corners_px.setConstant(500);
  truth.views[20].corners_px.col(0).swap(truth.views[20].corners_px.col(1));
  const ChainSolution solution = SolveChain(truth.model, rig, truth.views);
  EXPECT_TRUE(solution.curve.points.allFinite());
  for (const int v : {3, 7, 12, 20}) EXPECT_EQ(solution.used[v], 0) << v;
  EXPECT_EQ(solution.views_rejected, 4);
}

TEST(SolveChain, EveryViewWrongIsNotBelieved) {
  const std::vector<Camera> rig = CamerasAround(2);
  std::mt19937_64 random(5);
  const Truth truth = MakeTruth({}, 0.2, rig, {.outliers = 1}, {}, random);
  const ChainSolution solution = SolveChain(truth.model, rig, truth.views);
  EXPECT_TRUE(solution.curve.points.allFinite());
  EXPECT_TRUE(solution.curve.normals.allFinite());
}

// However far the frame before was: from the same shape, from one pulled quite differently, from nonsense.
TEST(SolveChain, TheFrameBeforeChangesTheWayNotTheAnswer) {
  const std::vector<Camera> rig = CamerasAround(2);
  for (const double outliers : {0.0, 0.05}) {
    for (int draw = 0; draw < 4; ++draw) {
      const auto truth_at = [&](double pull) {
        std::mt19937_64 random(300 + draw);
        return MakeTruth({}, pull, rig, {.outliers = outliers}, {}, random);
      };
      const Truth truth = truth_at(0.2);
      const ChainSolution afresh = SolveChain(truth.model, rig, truth.views);
      for (const double pull : {0.2, 0.195, 0.1, 0.0}) {
        const Truth before = truth_at(pull);
        const ChainSolution previous = SolveChain(before.model, rig, before.views);
        const ChainSolution follows = SolveChain(truth.model, rig, truth.views, {}, &previous);
        EXPECT_EQ(follows.used, afresh.used) << draw << ", from " << pull;
        for (int i = 0; i < afresh.sigma.size(); ++i) {
          if (!std::isfinite(afresh.sigma[i])) continue;
          EXPECT_LT((follows.curve.points.col(i) - afresh.curve.points.col(i)).norm(), 0.1 * afresh.sigma[i])
              << draw << ", from " << pull << ", node " << i;
        }
      }
    }
  }
}

TEST(SolveChain, WithoutTheFoldLawAWrongLawDoesNotMoveTheAnswer) {
  const std::vector<Camera> rig = CamerasAround(2);
  std::mt19937_64 random(11);
  const Truth truth = MakeTruth({}, 0.2, rig, {}, {}, random);
  ChainModel wrong_law = truth.model;  // wrong from crease to crease, which no opening takes up
  for (int i = 0; i < wrong_law.expected_angle.size(); ++i)
    wrong_law.expected_angle[i] += 0.1 * std::sin(2.4 * i + 1);
  std::vector<TagView> hidden_base;
  for (const TagView& view : truth.views) {
    if (view.place->facet > 2) hidden_base.push_back(view);
  }
  const auto turned = [&](const std::vector<TagView>& views,
                          bool fold_law) {  // creases by the wrong law, rad
    ChainOptions options;
    options.fold_law = fold_law;
    const ChainSolution right = SolveChain(truth.model, rig, views, options);
    const ChainSolution wrong = SolveChain(wrong_law, rig, views, options);
    return (right.angle - wrong.angle).cwiseAbs().maxCoeff();
  };
  EXPECT_LT(turned(truth.views, false), 1e-4);
  EXPECT_LT(turned(hidden_base, false), 1e-4);
  EXPECT_GT(turned(truth.views, true), 1e-2);
}

TEST(SolveChain, SaysWhichFoldAnglesThePicturesTell) {
  const std::vector<Camera> rig = CamerasAround(4);
  std::mt19937_64 random(12);
  double normalised = 0;  // sum of (error / sigma)^2
  int angles = 0;
  for (int draw = 0; draw < 6; ++draw) {
    const Truth truth = MakeTruth({}, 0.15, rig, {}, {}, random);
    std::vector<TagView> views;
    for (const TagView& view : truth.views) {
      const int facet = view.place->facet;
      if (facet != 10 && (facet < 20 || facet > 24))
        views.push_back(view);  // one gap of one facet, one of five
    }
    const ChainSolution solution = SolveChain(truth.model, rig, views);
    const Eigen::VectorXd& told = solution.angle_by_pictures;
    EXPECT_TRUE(((told.array() >= 0) && (told.array() <= 1)).all());
    EXPECT_GT(told[9], 0.4);
    EXPECT_LT(told[22], 0.15);
    EXPECT_LT(solution.angle_sigma[9], solution.angle_sigma[22]);
    for (int i = 0; i < told.size(); ++i) {
      if (solution.interpolated[i] + solution.interpolated[i + 1] > 0) continue;
      EXPECT_GT(told[i], 0.6) << i;
      EXPECT_GT(told[i], told[9]) << i;
      EXPECT_LT(solution.angle_sigma[i], solution.angle_sigma[9]) << i;
    }
    for (int i = 0; i < told.size(); ++i) {
      const double angle =
          FoldAngleBetween(GeometryOfCrease(truth.model.layout, i), truth.lab_from_sheet[i].linear(),
                           truth.lab_from_sheet[i + 1].linear());
      normalised += std::pow((solution.angle[i] - angle) / solution.angle_sigma[i], 2);
      ++angles;
    }
  }
  EXPECT_GT(normalised / angles, 0.4);
  EXPECT_LT(normalised / angles, 1.3);
}

TEST(SolveChain, WithoutATagThePicturesTellNoAngle) {
  const std::vector<Camera> rig = CamerasAround(2);
  std::mt19937_64 random(2);
  const ChainSolution solution = SolveChain(MakeTruth({}, 0.2, rig, {}, {}, random).model, rig, {});
  EXPECT_LT(solution.angle_by_pictures.maxCoeff(), 1e-3);
  EXPECT_TRUE(solution.angle_sigma.allFinite());
}

TEST(SolveChain, TheCovarianceFactorHasTheStatedSigmas) {
  const std::vector<Camera> rig = CamerasAround(2);
  std::mt19937_64 random(6);
  const Truth truth = MakeTruth({}, 0.3, rig, {.kept = 0.4}, {}, random);
  const ChainSolution solution = SolveChain(truth.model, rig, truth.views);
  const Eigen::MatrixXd& factor = solution.covariance_factor;
  ASSERT_EQ(factor.rows(), 3 * 49);
  EXPECT_LE(factor.cols(), 36);
  for (int i = 0; i < 49; ++i) {
    if (std::isnan(solution.sigma[i])) continue;
    EXPECT_NEAR(factor.middleRows<3>(3 * i).norm(), solution.sigma[i], 1e-6 * solution.sigma[i]);
  }
}

TEST(SolveChain, TwoHolesAndPullNearReach) {
  TentacleDesign two;
  two.holes = 2;
  two.length = 0.04;
  const std::vector<Camera> rig = CamerasAround(2);
  std::mt19937_64 random(7);
  const Truth truth = MakeTruth(two, 0.1, rig, {}, {}, random);
  const ChainSolution solution = SolveChain(truth.model, rig, truth.views);
  EXPECT_TRUE(solution.curve.points.allFinite());
  EXPECT_LT((solution.curve.points - truth.holes).colwise().norm().maxCoeff(), 2e-3);

  std::mt19937_64 again(8);
  const Truth closed = MakeTruth(PlanarDesign(), 0.89, rig, {}, {}, again);
  const ChainSolution folded = SolveChain(closed.model, rig, closed.views);
  EXPECT_TRUE(folded.curve.points.allFinite());
  EXPECT_TRUE(folded.curve.normals.allFinite());
}

}  // namespace
}  // namespace tendril
