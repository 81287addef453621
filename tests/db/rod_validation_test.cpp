// The scenes of examples/scenes/validation against their closed forms, the quick part: at rest, and with half
// the elements what moves. The whole table: rod_validation_table_test.cpp and ./tendril bench rod_validation.
#include "tests/support/rod_validation.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/rod_closed_forms.h"

namespace tendril::testing_support {
namespace {

void ExpectWithin(const std::vector<Figure>& figures, double share) {
  EXPECT_FALSE(figures.empty());
  for (const Figure& f : figures) {
    if (f.reference == 0 || std::isnan(f.reference)) continue;
    EXPECT_LT(f.Error(), share) << f.quantity << ": " << f.ours << " for " << f.reference;
  }
}

double OursOf(const std::vector<Figure>& figures, const std::string& quantity) {
  const auto found =
      std::find_if(figures.begin(), figures.end(), [&](const Figure& f) { return f.quantity == quantity; });
  return found == figures.end() ? std::nan("") : found->ours;
}

// Figures that others have published.
TEST(RodClosedForms, AreThePublishedOnes) {
  EXPECT_NEAR(TipLoadedElastica(1).drop, 0.30172, 6e-6);
  EXPECT_NEAR(TipLoadedElastica(10).drop, 0.81061, 6e-6);
  EXPECT_NEAR(TipLoadedElastica(10).in, 0.55500, 6e-6);
  const double heavy[][2] = {{1, 0.12456}, {10, 1.06680}, {100, 5.88810}};
  for (const auto& [weight, ratio] : heavy) {
    const TipOf tip = HeavyElastica(weight);
    EXPECT_NEAR(tip.drop / (1 - tip.in), ratio, 6e-6 * (1 + ratio)) << weight;
  }
  EXPECT_NEAR(ClampedTwistMoment(), 8.986818916, 1e-9);
  // Simo and Vu-Quoc 1986 with eight straight elements.
  const double bend = 1e7 / 12, area = 1e7;
  Eigen::Matrix3d base;
  base << 0, 0, -1, -1, 0, 0, 0, 1, 0;
  const Eigen::Vector3d tip =
      TipOfLoadedArc({25 * 3.14159265358979, 0.01, bend, bend, 0.5 * area, area}, base, {0, 0, 600});
  EXPECT_LT((tip - Eigen::Vector3d(15.79, 47.23, 53.37)).norm(), 0.2);
}

TEST(RodValidation, RodsAtRestMeetTheirClosedForms) {
  ExpectWithin(ElasticaFigures(true), 3.5e-4);
  ExpectWithin(HeavyElasticaFigures(true), 3e-3);
  ExpectWithin(ThickCantileverFigures(true), 3e-4);
  ExpectWithin(TipCoupleFigures(true), 1e-3);
  EXPECT_LT(OursOf(TipCoupleFigures(true), "gap / L"), 1e-8);
  ExpectWithin(Bend45Figures(true), 4e-4);
  ExpectWithin(ColumnFigures(true), 6e-4);
  ExpectWithin(HelixFigures(true), 2e-4);
}

TEST(RodValidation, TwistedRodsGiveWayWhereTheyShould) {
  ExpectWithin(TwistBucklingFigures(true), 1e-3);
  ExpectWithin(RingFigures(true), 6e-3);
}

TEST(RodValidation, RodsThatMeetExchangeTheirSpeeds) { ExpectWithin(ImpactFigures(true), 1e-3); }

TEST(RodValidation, ARodAboutADrumSlidesAsAThickRopeOnACapstan) { ExpectWithin(CapstanFigures(true), 1e-2); }

TEST(RodValidation, WhatRubsSlidesRollsAndSticksAsItShould) {
  const std::vector<Figure> incline = InclineFigures(true);
  ExpectWithin(incline, 5e-3);
  ExpectWithin(RollingFigures(true), 1e-3);
  ExpectWithin(StickSlipFigures(true), 2e-2);
  EXPECT_LT(std::abs(OursOf(incline, "box: creep at 0.995 mu, m/s")), 1e-9);
  EXPECT_LT(std::abs(OursOf(incline, "rod: creep at 0.995 mu, m/s")), 1e-9);
}

TEST(RodValidation, FrictionGivesNoEnergyAndKeepsMomenta) {
  const std::vector<Figure> tangle = TangleFigures(true), collision = CollisionFigures(true);
  EXPECT_LT(OursOf(tangle, "largest rise of energy / energy at the start"), 1e-3);
  EXPECT_LT(OursOf(tangle, "energy at the end / at the start"), 0.9);
  EXPECT_LT(OursOf(collision, "momentum drift"), 1e-13);
  EXPECT_LT(OursOf(collision, "angular momentum drift"), 1e-11);
}

TEST(RodValidation, ObjectsSinkSwingAndAreHeld) {
  ExpectWithin(SinkingFigures(true), 2e-3);
  ExpectWithin(PendulumFigures(true), 1e-4);
  const std::vector<Figure> held = HeldFigures(true);
  EXPECT_LT(OursOf(held, "way in 60 s, m"), 1e-4);
  EXPECT_LT(OursOf(held, "turn in 60 s, rad"), 1e-3);
}

}  // namespace
}  // namespace tendril::testing_support
