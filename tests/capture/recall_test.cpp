// What creases out of sight are recalled to have done.
#include "capture/track/recall.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/synthetic_view.h"

namespace tendril {
namespace {

using testing_support::CamerasAround;
using testing_support::MakeTruth;
using testing_support::Truth;

MomentAngles Moment(double time, double expected, double angle, double sigma, double by_pictures) {
  return {.time = time,
          .expected = Eigen::VectorXd::Constant(1, expected),
          .angle = Eigen::VectorXd::Constant(1, angle),
          .sigma = Eigen::VectorXd::Constant(1, sigma),
          .by_pictures = Eigen::VectorXd::Constant(1, by_pictures)};
}

TEST(RecallAngles, OnlyWhatPicturesToldIsRecalledAndOnlyWhereTheyTellLittleNow) {
  const MomentAngles now = Moment(1, 0.5, 0.52, 0.02, 0.1);
  const std::vector<MomentAngles> guess = {Moment(0.9, 0.5, 0.6, 0.001, 0.3)};
  EXPECT_TRUE(std::isnan(RecallAngles(now, guess, {}).sigma[0]));
  EXPECT_TRUE(std::isnan(RecallAngles(now, {}, {}).sigma[0]));
  const std::vector<MomentAngles> known = {Moment(0.9, 0.5, 0.6, 0.01, 0.9)};
  EXPECT_TRUE(std::isnan(RecallAngles(Moment(1, 0.5, 0.52, 0.02, 0.8), known, {}).sigma[0]));
  EXPECT_EQ(RecallAngles(now, known, {}).angle[0], 0.6);
  EXPECT_GT(RecallAngles(now, known, {}).sigma[0], 0.01);
}

TEST(RecallAngles, WhatAMomentOwedToExpectationsIsNotCountedAgain) {
  // Law and pictures each knew it to 0.02: that moment to 0.02 / sqrt(2), its pictures to 0.02.
  ChainOptions still;
  still.sigma_recall_walk = 0;
  const std::vector<MomentAngles> known = {Moment(0.9, 0.5, 0.6, 0.02 / std::sqrt(2.0), 0.5)};
  EXPECT_NEAR(RecallAngles(Moment(1, 0.5, 0.52, 0.02, 0.1), known, still).sigma[0], 0.02, 1e-12);
}

TEST(RecallAngles, TheMomentThatKnowsBestIsAskedAndTheLawCarriesItOver) {
  const MomentAngles now = Moment(1, 0.5, 0.52, 0.02, 0.0);
  const std::vector<MomentAngles> near = {
      Moment(0.0, 0.5, 0.9, 0.01, 0.9), Moment(0.99, 0.4, 0.43, 0.01, 0.9), Moment(1.01, 0.5, 0.7, 0.5, 0.9)};
  ChainOptions options;
  options.sigma_recall_walk = 0.05;
  const RecalledAngles with = RecallAngles(now, near, options);
  EXPECT_NEAR(with.angle[0], 0.53, 1e-12);  // as far off the law as then
  options.fold_law = false;
  const RecalledAngles without = RecallAngles(now, {&near[1], 1}, options);
  EXPECT_EQ(without.angle[0], 0.43);
  EXPECT_GT(without.sigma[0], with.sigma[0]);  // the law's change is not believed
}

TEST(RecallAngles, BringHiddenCreasesNearerToTheTruth) {
  const std::vector<Camera> rig = CamerasAround(4);
  std::mt19937_64 random(31);
  double alone_squares = 0;
  double recalled_squares = 0;
  double normalised = 0;
  int angles = 0;
  for (int draw = 0; draw < 8; ++draw) {
    const Truth truth = MakeTruth({}, 0.2, rig, {}, {}, random);
    std::vector<TagView> views;
    for (const TagView& view : truth.views) {
      if (view.place->facet < 18 || view.place->facet > 24) views.push_back(view);
    }
    const ChainSolution alone = SolveChain(truth.model, rig, views);
    const std::vector<MomentAngles> before = {
        AnglesOf(0.9, truth.model, SolveChain(truth.model, rig, truth.views))};
    ChainModel model = truth.model;
    model.recalled = RecallAngles(AnglesOf(1, model, alone), before, {});
    const ChainSolution found = SolveChain(model, rig, views, {}, &alone);
    for (int i = 18; i < 24; ++i) {
      const double angle =
          FoldAngleBetween(GeometryOfCrease(model.layout, i), truth.lab_from_sheet[i].linear(),
                           truth.lab_from_sheet[i + 1].linear());
      alone_squares += std::pow(alone.angle[i] - angle, 2);
      recalled_squares += std::pow(found.angle[i] - angle, 2);
      normalised += std::pow((found.angle[i] - angle) / found.angle_sigma[i], 2);
      ++angles;
      EXPECT_LT(found.angle_sigma[i], alone.angle_sigma[i]);
    }
  }
  EXPECT_LT(recalled_squares, 0.4 * alone_squares);
  EXPECT_LT(normalised / angles, 1.5);
}

}  // namespace
}  // namespace tendril
