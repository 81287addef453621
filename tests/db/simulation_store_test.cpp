// db/simulation_store.h: what a simulation says of itself is kept whole, and a run is found again.
#include "db/simulation_store.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/lab_test.h"

namespace tendril {
namespace {

using Simulations = testing_support::LabTest;

TEST_F(Simulations, ASimulationIsReplacedAndScenesAreFoundByTheirText) {
  TrialSpec spec;
  spec.kind = TrialKind::kSimulated;
  const std::string a = Begin(spec), b = Begin(spec);
  const Provenance made{"tendril 0.1.0", "{}", {}};
  SimulationRow row;
  row.scene_name = "octagon";
  row.scene_toml = "duration = 10";
  row.level = "standard";
  row.least_axis_share = 0.9;
  ASSERT_TRUE(StoreSimulation(lab(), a, row, made).ok());
  EXPECT_EQ(Ask("SELECT nothing_passed IS NULL FROM simulation"), "1") << "not looked at is not false";
  row.nothing_passed = true;
  row.divergence = "at 3 s";
  ASSERT_TRUE(StoreSimulation(lab(), a, row, made).ok());
  ASSERT_TRUE(StoreSimulation(lab(), b, row, made).ok());
  EXPECT_EQ(Ask("SELECT count(*) FROM simulation"), "2");
  EXPECT_EQ(Ask("SELECT count(*) FROM scene"), "1");
  EXPECT_EQ(Ask("SELECT count(*) FROM provenance"), "2") << "the replaced row's is gone";
  EXPECT_EQ(Ask("SELECT nothing_passed || divergence FROM simulation LIMIT 1"), "1at 3 s");
  row.level = "slow";
  EXPECT_FALSE(StoreSimulation(lab(), a, row, made).ok());
  EXPECT_EQ(Ask("SELECT count(*) FROM simulation"), "2") << "the row before is kept";
}

TEST_F(Simulations, ASimulationIsReadAsItWasStored) {
  TrialSpec spec;
  spec.kind = TrialKind::kSimulated;
  const std::string a = Begin(spec), b = Begin(spec);
  const Provenance made{"tendril 0.1.0", "{}", {}};
  SimulationRow row;
  row.scene_name = "ball";
  row.scene_toml = "duration = 1";
  row.level = "fast";
  row.doubts = {"bodies overlap by 30 % of a radius", "it diverged"};
  row.longest_stick_share = 0.02;
  row.friction = 0.4;
  row.medium = "water";
  row.holding.emplace();
  row.holding->test = "strike";
  row.holding->lifted = true;
  row.holding->rise_m = -0.01;
  row.holding->strikes = 7;
  row.holding->rule = "still there after all strikes";
  ASSERT_TRUE(StoreSimulation(lab(), a, row, made).ok());
  const auto read = LoadSimulation(lab(), a);
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_TRUE(read.value().has_value());
  EXPECT_FALSE(read.value()->trusted);
  const SimulationRow& got = read.value()->row;
  EXPECT_EQ(got.doubts, row.doubts);
  EXPECT_EQ(got.friction, 0.4);
  EXPECT_EQ(got.medium, "water");
  EXPECT_EQ(got.longest_stick_share, 0.02);
  EXPECT_FALSE(got.nothing_passed.has_value());
  ASSERT_TRUE(got.holding.has_value());
  EXPECT_EQ(got.holding->strikes, 7);
  EXPECT_EQ(got.holding->rise_m, -0.01);
  EXPECT_TRUE(std::isnan(got.holding->payload_kg));
  EXPECT_TRUE(got.holding->lifted && !got.holding->held);

  // Without a test and without doubts, in the place of the row before.
  row.holding.reset();
  row.doubts.clear();
  ASSERT_TRUE(StoreSimulation(lab(), a, row, made).ok());
  EXPECT_TRUE(LoadSimulation(lab(), a).value()->trusted);
  EXPECT_EQ(Ask("SELECT count(*) FROM holding"), "0");
  EXPECT_FALSE(LoadSimulation(lab(), b).value().has_value());
  row.holding.emplace().test = "shove";
  EXPECT_FALSE(StoreSimulation(lab(), b, row, made).ok());
  EXPECT_EQ(Ask("SELECT count(*) FROM simulation"), "1") << "all or nothing";
}

TEST_F(Simulations, ARunIsFoundByItsKeyWhereItIsThroughAndNotVoid) {
  const auto store = [&](const std::string& label, const std::string& key, const std::string& version) {
    TrialSpec spec;
    spec.kind = TrialKind::kSimulated;
    spec.label = label;
    const std::string id = Begin(spec);
    SimulationRow row;
    row.level = "standard";
    row.run_key = key;
    EXPECT_TRUE(StoreSimulation(lab(), id, row, {version, "{}", {}}).ok());
    return id;
  };
  const auto found = [&](const std::string& key) {
    const auto label = FindRun(lab(), key, "tendril 2");
    EXPECT_TRUE(label.ok()) << label.error().message;
    return label.value().value_or("none");
  };
  const std::string a = store("a", "one", "tendril 2");
  EXPECT_EQ(found("one"), "none") << "not through yet";
  ASSERT_TRUE(SetTrialState(lab(), a, TrialState::kRecorded).ok());
  EXPECT_EQ(found("one"), "a");
  EXPECT_EQ(found("two"), "none");
  const std::string failed = store("failed", "two", "tendril 2");
  ASSERT_TRUE(SetTrialState(lab(), failed, TrialState::kFailed, "it diverged").ok());
  EXPECT_EQ(found("two"), "none");
  const std::string other = store("other", "three", "tendril 1");
  ASSERT_TRUE(SetTrialState(lab(), other, TrialState::kRecorded).ok());
  EXPECT_EQ(found("three"), "none") << "another program's";
  const std::string without = store("without", "", "tendril 2");
  ASSERT_TRUE(SetTrialState(lab(), without, TrialState::kRecorded).ok());
  EXPECT_EQ(found(""), "none") << "a key that is not known is no key";
  ASSERT_TRUE(VoidTrial(lab(), a, "wrong scene", "ada").ok());
  EXPECT_EQ(found("one"), "none");
}

}  // namespace
}  // namespace tendril
