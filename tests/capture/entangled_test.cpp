// Rods that the simulator tangles, on the virtual rig, before four cameras, through the tracker: tentacles
// follow their rods, and the holes that were seen are found.
#include "tests/support/entangled.h"

#include <gtest/gtest.h>

namespace tendril::testing_support {
namespace {

EntangledOptions AtOnce(double time) {
  EntangledOptions options;
  options.scene = TENDRIL_SOURCE_DIR "/examples/scenes/entangled.toml";
  options.times = {time};
  return options;
}

TEST(Entangled, TentaclesFollowTheRodsThatPressOnEachOther) {
  EntangledOptions options = AtOnce(4);
  TruthRanges& r = options.ranges;
  r.position_sd = r.crease_angle_sd = r.stiffness_sd = r.facet_bend_sd = r.base_position_sd =
      r.base_angle_sd = 0;
  const auto made = MakeEntangledTrial(21, options);
  ASSERT_TRUE(made.ok()) << made.error().message;
  const EntangledTrial& trial = made.value();
  double most_turned = 0;
  for (int t = 0; t < trial.gripper.tentacles; ++t) {
    const auto i = static_cast<std::size_t>(t);
    const TentacleDesign design = DesignOfTentacle(trial.gripper, trial.design, t);
    const TentacleLayout layout = LayOut(design).value();
    const RodShape& rod = trial.rods[0][i];
    const Eigen::VectorXd angle = SolveFold(design, rod.pull).value().angle;
    EXPECT_LT(
        DistancesFromRod(layout, rod.curve.points, trial.shapes[0].tentacles[i].centerline.points).maxCoeff(),
        0.006)
        << "tentacle " << t;
    most_turned =
        std::max(most_turned, (trial.shapes[0].tentacles[i].fold_angle - angle).cwiseAbs().maxCoeff());
  }
  EXPECT_GT(most_turned, 0.02);  // they do press
}

TEST(Entangled, WhatWasSeenOfATangleIsFound) {
  const auto made = MakeEntangledTrial(22, AtOnce(8));
  ASSERT_TRUE(made.ok()) << made.error().message;
  const EntangledTrial& trial = made.value();
  EntangledFilm film(trial, 22);
  const FilmedMoment frame = film.Next(trial.shapes[0]);
  std::vector<ChainSolution> solutions;
  SolveTentacles(trial, trial.shapes[0], frame, LoadedTentacles(), solutions);
  double seen = 0, squares = 0, known = 0, within = 0;
  for (std::size_t t = 0; t < solutions.size(); ++t) {
    const Eigen::Matrix3Xd& holes = trial.shapes[0].tentacles[t].centerline.points;
    for (Eigen::Index i = 0; i < holes.cols(); ++i) {
      const double error = (solutions[t].curve.points.col(i) - holes.col(i)).norm();
      if (std::isnan(solutions[t].sigma[i])) continue;
      ++known;
      within += error < 2 * solutions[t].sigma[i] ? 1 : 0;
      if (solutions[t].interpolated[i] != 0) continue;
      ++seen;
      squares += error * error;
    }
  }
  const double nodes = 8.0 * 49;
  EXPECT_GT(seen / nodes, 0.25);
  EXPECT_LT(seen / nodes, 25.0 / 49);  // more facets carry no tag
  EXPECT_LT(std::sqrt(squares / seen), 0.002);
  EXPECT_GT(within / known, 0.9);
  EXPECT_GT(known / nodes, 0.9);
}

}  // namespace
}  // namespace tendril::testing_support
