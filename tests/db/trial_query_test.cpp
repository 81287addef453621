// db/trial_query.h: trials are found, and rates count what they say.
#include "db/trial_query.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "db/simulation_store.h"
#include "tests/support/lab_test.h"

namespace tendril {
namespace {

using testing::HasSubstr;
using Keys = std::vector<std::pair<std::string, std::string>>;

class Rates : public testing_support::LabTest {
 protected:
  // A simulated trial that a rule judged.
  std::string Simulated(bool grasped, const SimulationRow& row) {
    TrialSpec spec;
    spec.kind = TrialKind::kSimulated;
    const std::string id = Begin(spec);
    EXPECT_TRUE(StoreSimulation(lab(), id, row, {"tendril 0.1.0", "{}", {}}).ok());
    EXPECT_TRUE(SetTrialState(lab(), id, TrialState::kRecorded).ok());
    Judge(id, grasped, "rule", false);
    return id;
  }

  std::vector<RateGroup> Counted(const RateQuestion& question) {
    const auto groups = CountGrasps(lab(), question);
    EXPECT_TRUE(groups.ok()) << groups.error().message;
    return groups.value();
  }
};

SimulationRow Tested(const std::string& test, double friction = 0.3, const std::string& level = "standard") {
  SimulationRow row;
  row.level = level;
  row.friction = friction;
  if (test.empty()) return row;
  row.holding.emplace().test = test;
  row.holding->rule = "a rule";
  return row;
}

TEST_F(Rates, RatesCountJudgedFinishedTrialsOfOneKindThatAreNotVoid) {
  TrialSpec near;
  near.design_name = "paper";
  near.object_distance = 0.1;
  TrialSpec far = near;
  far.object_distance = 0.3;
  Judged(true, near);
  Judged(false, near);
  Judged(true, far);
  TrialSpec rendered = near;
  rendered.kind = TrialKind::kVirtual;
  Judged(true, rendered);
  const std::string voided = Judged(true, near);
  ASSERT_TRUE(VoidTrial(lab(), voided, "string tore", "ada").ok());
  const std::string unfinished = Begin(near);
  Judge(unfinished, true, "ada", true);
  const std::string failed = Begin(near);
  ASSERT_TRUE(SetTrialState(lab(), failed, TrialState::kFailed, "no light").ok());
  Judge(failed, true, "ada", true);
  ASSERT_TRUE(SetTrialState(lab(), Begin(near), TrialState::kRecorded).ok());  // not judged

  const auto groups = CountGrasps(lab(), {.by = {"design", "distance"}, .where = {{"medium", "air"}}});
  ASSERT_TRUE(groups.ok()) << groups.error().message;
  ASSERT_EQ(groups.value().size(), 2U);
  EXPECT_EQ(groups.value()[0].keys,
            (std::vector<std::pair<std::string, std::string>>{{"design", "paper"}, {"distance", "0.1"}}));
  EXPECT_EQ(groups.value()[0].trials, 2);
  EXPECT_EQ(groups.value()[0].grasped, 1);
  EXPECT_EQ(groups.value()[1].trials, 1);
  const auto virtuals = CountGrasps(lab(), {.kind = TrialKind::kVirtual});
  ASSERT_TRUE(virtuals.ok());
  ASSERT_EQ(virtuals.value().size(), 1U);
  EXPECT_EQ(virtuals.value()[0].trials, 1);
  EXPECT_TRUE(CountGrasps(lab(), {.where = {{"medium", "water"}}}).value().empty());
}

TEST_F(Rates, RateNamesAreChecked) {
  EXPECT_THAT(CountGrasps(lab(), {.by = {"desing"}}).error().message, HasSubstr("did you mean design?"));
  EXPECT_THAT(CountGrasps(lab(), {.by = {"kind"}}).error().message, HasSubstr("--kind"));
  EXPECT_FALSE(CountGrasps(lab(), {.by = {"design; DROP TABLE trial"}}).ok());
  EXPECT_FALSE(CountGrasps(lab(), {.where = {{"distance", "near"}}}).ok());
  const auto injected = CountGrasps(lab(), {.where = {{"medium", "air' OR '1'='1"}}});
  ASSERT_TRUE(injected.ok());
  EXPECT_TRUE(injected.value().empty());
}

TEST_F(Rates, ATrialIsFoundByIdPrefixAndLabel) {
  TrialSpec spec;
  spec.label = "monday-1";
  const std::string id = Begin(spec);
  const std::string other = Begin();
  EXPECT_EQ(FindTrial(lab(), id).value(), id);
  EXPECT_EQ(FindTrial(lab(), "monday-1").value(), id);
  size_t shared = 0;
  while (id[shared] == other[shared]) ++shared;
  EXPECT_EQ(FindTrial(lab(), id.substr(0, shared + 1)).value(), id);
  EXPECT_EQ(FindTrial(lab(), id.substr(0, 8)).error().kind, ErrorKind::kBadInput);
  EXPECT_THAT(FindTrial(lab(), "mondey-1").error().message, HasSubstr("did you mean monday-1?"));
  EXPECT_EQ(FindTrial(lab(), "").error().kind, ErrorKind::kNotFound);
}

TEST_F(Rates, SimulationsThatAreNotTrustedCountWhereAskedForOnly) {
  const auto simulated = [&](bool grasped, bool trusted, const std::string& medium) {
    TrialSpec spec;
    spec.kind = TrialKind::kSimulated;
    spec.medium = medium;
    const std::string id = Begin(spec);
    SimulationRow row;
    row.scene_toml = "duration = 1";
    row.level = "standard";
    if (!trusted) row.doubts = {"bodies overlap by 30 % of a radius"};
    EXPECT_TRUE(StoreSimulation(lab(), id, row, {"tendril 0.1.0", "{}", {}}).ok());
    EXPECT_TRUE(SetTrialState(lab(), id, TrialState::kRecorded).ok());
    Judge(id, grasped, "rule", false);
    return id;
  };
  simulated(true, true, "air");
  simulated(false, true, "water");
  const std::string doubted = simulated(true, false, "air");
  Judged(true, TrialSpec());  // a real one
  RateQuestion question{.kind = TrialKind::kSimulated};
  const auto counted = [&] {
    const auto groups = CountGrasps(lab(), question);
    EXPECT_TRUE(groups.ok()) << groups.error().message;
    return groups.value().empty() ? std::pair<std::int64_t, std::int64_t>{}
                                  : std::pair{groups.value()[0].grasped, groups.value()[0].trials};
  };
  EXPECT_EQ(counted(), std::pair(std::int64_t{1}, std::int64_t{2}));
  EXPECT_EQ(CountLeftOut(lab(), question).value(), 1);
  // A person's judgement says what happened, not whether the physics can be believed.
  Judge(doubted, true, "ada", true);
  EXPECT_EQ(CountLeftOut(lab(), question).value(), 1);
  question.where = {{"medium", "water"}};
  EXPECT_EQ(CountLeftOut(lab(), question).value(), 0) << "none of those in water";
  question.where = {{"pull", "0.3"}};
  EXPECT_EQ(CountLeftOut(lab(), question).value(), 1);
  question.where.clear();
  question.include_untrusted = true;
  EXPECT_EQ(counted(), std::pair(std::int64_t{2}, std::int64_t{3}));
  EXPECT_EQ(CountLeftOut(lab(), question).value(), 0);
  question = {.where = {{"distance", "near"}}};
  EXPECT_FALSE(CountLeftOut(lab(), question).ok());
  const auto trials = ListTrials(lab(), {.kind = TrialKind::kSimulated});
  EXPECT_FALSE(trials.value()[2].trusted);
  EXPECT_TRUE(trials.value()[0].trusted);
  EXPECT_EQ(Ask("SELECT sum(trusted) FROM grasp_rate_input"), "3") << "the real one, and two simulated";
}

TEST_F(Rates, SimulationsThatWereTestedDifferentlyAreNotOneRate) {
  Simulated(true, Tested("lift"));
  RateQuestion one{.kind = TrialKind::kSimulated};
  EXPECT_FALSE(SplitByTest(lab(), one).value()) << "there is one test only";
  EXPECT_TRUE(one.by.empty());
  Simulated(false, Tested("lift", 0.1, "fast"));
  Simulated(true, Tested("load"));
  Simulated(false, Tested(""));  // a person judged it
  RateQuestion question{.by = {"level"}, .kind = TrialKind::kSimulated};
  EXPECT_TRUE(SplitByTest(lab(), question).value());
  EXPECT_EQ(question.by, (std::vector<std::string>{"test", "level"}));
  const std::vector<RateGroup> groups = Counted(question);
  ASSERT_EQ(groups.size(), 4U);
  EXPECT_EQ(groups[0].keys, (Keys{{"test", "lift"}, {"level", "fast"}}));
  EXPECT_EQ(groups[2].keys, (Keys{{"test", "load"}, {"level", "standard"}}));
  EXPECT_EQ(groups[3].keys, (Keys{{"test", "none"}, {"level", "standard"}}));
  EXPECT_EQ(groups[0].trials + groups[1].trials + groups[2].trials + groups[3].trials, 4);
  // Who names a test, as key or condition, has chosen.
  RateQuestion chosen{.where = {{"test", "lift"}}, .kind = TrialKind::kSimulated};
  EXPECT_FALSE(SplitByTest(lab(), chosen).value());
  EXPECT_EQ(Counted(chosen)[0].trials, 2);
  RateQuestion by{.by = {"friction", "test"}, .kind = TrialKind::kSimulated};
  EXPECT_FALSE(SplitByTest(lab(), by).value());
  EXPECT_EQ(Counted(by)[0].keys, (Keys{{"friction", "0.1"}, {"test", "lift"}}));
  EXPECT_EQ(Counted({.where = {{"friction", "0.3"}}, .kind = TrialKind::kSimulated})[0].trials, 3);
  // Of trials that are no simulations nothing is known of these.
  Judged(true, TrialSpec());
  RateQuestion real{.by = {"test", "friction"}};
  EXPECT_FALSE(SplitByTest(lab(), real).value());
  EXPECT_EQ(Counted(real)[0].keys, (Keys{{"test", ""}, {"friction", ""}}));
}

TEST_F(Rates, ARunThatWasStoredAgainCountsOnceAsItWasLast) {
  SimulationRow row = Tested("lift");
  row.run_key = "one run";
  Simulated(true, row);
  const RateQuestion question{.kind = TrialKind::kSimulated};
  EXPECT_EQ(CountRepeats(lab(), question).value(), 0);
  const std::string last = Simulated(false, row);
  row.run_key = "another";
  Simulated(true, row);
  row.run_key.clear();  // not known: each for itself
  Simulated(true, row);
  Simulated(true, row);
  EXPECT_EQ(Counted(question)[0].trials, 4);
  EXPECT_EQ(Counted(question)[0].grasped, 3);
  EXPECT_EQ(CountRepeats(lab(), question).value(), 1);
  // Void, the last no longer stands for the run.
  ASSERT_TRUE(VoidTrial(lab(), last, "wrong scene", "ada").ok());
  EXPECT_EQ(Counted(question)[0].grasped, 4);
  EXPECT_EQ(CountRepeats(lab(), question).value(), 0);
}

}  // namespace
}  // namespace tendril
