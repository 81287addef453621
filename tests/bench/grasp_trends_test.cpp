// bench/grasp_trends: rows survive the file and a torn end, doubts and misses do not count as grasps, every
// point's scene can be read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <set>

#include "bench/grasp_trends/grasp_outcome.h"
#include "bench/grasp_trends/grasp_points.h"
#include "bench/grasp_trends/grasp_report.h"
#include "tests/support/program.h"

namespace tendril {
namespace {

using testing_support::ReadText;
using testing_support::TemporaryFolder;

const std::filesystem::path kScenes = std::filesystem::path(TENDRIL_SOURCE_DIR) / "examples/scenes/grasp";

GraspOutcome Lifted(std::uint64_t trial, double rise) {
  return {.scene = "tube.toml",
          .settings = "object.0.position.2=-0.15",
          .inputs = "0123456789ab",
          .trial = trial,
          .above = rise > 0,
          .rise = rise,
          .drawn_in = 0.01,
          .borne = GraspOutcome::kNone,
          .mutual_link = 0.5,
          .mutual_open = 0.25,
          .object_link = 1.0 / 3,
          .object_open = 0.125,
          .wall = 12.5};
}

const GraspPoint kTube{.line = "beta 75 degrees",
                       .label = "20 %",
                       .scene = "tube.toml",
                       .settings = {"object.0.position.2=-0.15"}};

TEST(GraspRows, ComeBackFromTheFileAsTheyWere) {
  const TemporaryFolder folder;
  GraspOutcome doubtful = Lifted(1, -0.002);
  doubtful.doubt = "springs drawn by 0.2, expected 0.1";
  ASSERT_TRUE(AppendOutcome(folder / "rows.csv", Lifted(0, 0.26)).ok());
  ASSERT_TRUE(AppendOutcome(folder / "rows.csv", doubtful).ok());
  const auto rows = ReadOutcomes(folder / "rows.csv");
  ASSERT_TRUE(rows.ok()) << rows.error().message;
  ASSERT_EQ(rows.value().size(), 2u);
  const GraspOutcome& row = rows.value()[0];
  EXPECT_EQ(row.settings, kTube.settings[0]);
  EXPECT_TRUE(row.above);
  EXPECT_NEAR(row.rise, 0.26, 1e-9);
  EXPECT_NEAR(row.object_link, 1.0 / 3, 1e-9);
  EXPECT_TRUE(std::isnan(row.borne));
  EXPECT_EQ(row.doubt, "");
  EXPECT_FALSE(rows.value()[1].above);
  EXPECT_EQ(rows.value()[1].doubt, "springs drawn by 0.2; expected 0.1");
}

TEST(GraspRows, ATornLastLineIsCutAndTheFileGoesOn) {
  const TemporaryFolder folder;
  ASSERT_TRUE(AppendOutcome(folder / "rows.csv", Lifted(0, 0.26)).ok());
  const std::string whole = ReadText(folder / "rows.csv");
  std::ofstream(folder / "rows.csv", std::ios::app) << "tube.toml,object.0.pos";
  ASSERT_EQ(ReadOutcomes(folder / "rows.csv").value().size(), 1u);
  EXPECT_EQ(ReadText(folder / "rows.csv"), whole);
  ASSERT_TRUE(AppendOutcome(folder / "rows.csv", Lifted(1, 0.26)).ok());
  EXPECT_EQ(ReadOutcomes(folder / "rows.csv").value().size(), 2u);
}

TEST(GraspRows, AFileThatIsNotThereHasNone) {
  const TemporaryFolder folder;
  EXPECT_TRUE(ReadOutcomes(folder / "none.csv").value().empty());
  std::ofstream(folder / "torn.csv") << "scene,sett";  // killed within the header
  EXPECT_TRUE(ReadOutcomes(folder / "torn.csv").value().empty());
  ASSERT_TRUE(AppendOutcome(folder / "torn.csv", Lifted(0, 0.26)).ok());
  EXPECT_EQ(ReadOutcomes(folder / "torn.csv").value().size(), 1u);
}

TEST(Held, AsksForTheWeightOfWhatHangsAndForTheWayOfWhatFloats) {
  GraspOutcome swung = Lifted(0, 0.03), drawn = Lifted(1, 0.03), dropped = Lifted(2, -0.01);
  swung.borne = 0.1;
  drawn.borne = dropped.borne = 0.96;
  EXPECT_FALSE(Held(swung));
  EXPECT_TRUE(Held(drawn));
  EXPECT_FALSE(Held(dropped));
  GraspOutcome floats = Lifted(3, 0.03);  // half of the lift is 75 mm
  floats.drawn_in = -0.04;
  EXPECT_FALSE(Held(floats));
  floats.drawn_in = -0.12;
  EXPECT_TRUE(Held(floats));
}

TEST(CountGrasps, LeavesDoubtfulTrialsOutAndOtherPoints) {
  GraspOutcome doubtful = Lifted(3, 0.3), other = Lifted(4, 0.3);
  doubtful.doubt = "diverged";
  other.settings = "object.0.position.2=-0.25";
  const GraspCount count =
      CountGrasps(kTube, {Lifted(0, 0.2), Lifted(1, 0.3), Lifted(2, 3e-5), doubtful, other});
  EXPECT_EQ(count.trusted, 3);
  EXPECT_EQ(count.doubtful, 1);
  EXPECT_EQ(count.held, 2);
  EXPECT_EQ(count.raised, 3);
  EXPECT_DOUBLE_EQ(count.rise_held, 0.25);
  EXPECT_DOUBLE_EQ(count.rise_lost, 3e-5);
  // Wilson 1927 with z = 1.96: (p + z^2/2n -+ z sqrt(p (1-p)/n + z^2/4n^2)) / (1 + z^2/n).
  EXPECT_NEAR(count.interval.low, 0.2077, 1e-4);
  EXPECT_NEAR(count.interval.high, 0.9385, 1e-4);
}

TEST(CountGrasps, WithoutATrustedTrialKnowsNoRate) {
  GraspOutcome doubtful = Lifted(0, 0.3);
  doubtful.doubt = "diverged";
  EXPECT_TRUE(std::isnan(CountGrasps(kTube, {doubtful}).Rate()));
  EXPECT_TRUE(std::isnan(CountGrasps(kTube, {}).Rate()));
}

TEST(GraspSeries, EveryPointsSceneCanBeReadAndDiffersFromTheOthers) {
  for (const GraspSeries& series : AllGraspSeries()) {
    for (const GraspPanel& panel : series.panels) {
      std::set<std::string> inputs;
      for (const GraspPoint& point : panel.points) {
        const auto made_from = InputsOf(kScenes, point);
        ASSERT_TRUE(made_from.ok()) << made_from.error().message;
        EXPECT_TRUE(inputs.insert(made_from.value()).second)
            << series.name << ", " << panel.title << ": " << point.line << " at " << point.label;
      }
    }
  }
}

// Two short rods that are not pulled: quick, and nothing can be lifted.
TEST(RunGrasp, WhatIsNotPulledHoldsNothingAndATrialIsRepeatable) {
  GraspPoint idle = kTube;
  for (const char* setting : {"duration=0.2", "gripper.tentacles=2", "gripper.first_azimuth_deg=90",
                              "gripper.rod.elements=8", "gripper.pull=0"}) {
    idle.settings.emplace_back(setting);
  }
  const auto first = RunGrasp(kScenes, idle, "", 0);
  ASSERT_TRUE(first.ok()) << first.error().message;
  EXPECT_EQ(first.value().doubt, "");
  EXPECT_FALSE(Held(first.value()));
  EXPECT_NEAR(first.value().rise, 0, 1e-4);
  EXPECT_NEAR(first.value().borne, 0, 1e-9);
  const auto again = RunGrasp(kScenes, idle, "", 0);
  EXPECT_EQ(again.value().rise, first.value().rise);
  EXPECT_EQ(again.value().object_open, first.value().object_open);
}

}  // namespace
}  // namespace tendril
