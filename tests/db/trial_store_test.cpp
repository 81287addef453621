// db/trial_store.h, db/trial_query.h: trials begin and end whole, events are only added, rates count what
// they say.
#include "db/trial_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <set>

#include "db/files/safe_file.h"
#include "db/simulation_store.h"
#include "db/trial_query.h"
#include "tests/support/program.h"

namespace tendril {
namespace {

using testing::HasSubstr;

class Store : public testing::Test {
 protected:
  void SetUp() override {
    auto made = Lab::Create(folder_ / "lab");
    ASSERT_TRUE(made.ok()) << made.error().message;
    lab_ = std::make_unique<Lab>(std::move(made).value());
  }

  Lab& lab() { return *lab_; }

  std::string Begin(TrialSpec spec = TrialSpec()) {
    if (spec.design_name.empty()) spec.design_name = "paper";
    auto trial = BeginTrial(lab(), std::move(spec));
    EXPECT_TRUE(trial.ok()) << trial.error().message;
    return trial.ok() ? trial.value().id : "";
  }

  std::string Judged(bool grasped, TrialSpec spec) {
    const std::string id = Begin(std::move(spec));
    EXPECT_TRUE(SetTrialState(lab(), id, TrialState::kRecorded).ok());
    Judge(id, grasped, "ada", true);
    return id;
  }

  void Judge(const std::string& id, bool grasped, const std::string& by, bool person) {
    const Status s = AddOutcome(lab(), id, {.grasped = grasped, .judged_by = by, .by_person = person});
    EXPECT_TRUE(s.ok()) << s.error().message;
  }

  std::string Ask(const std::string& sql) {
    std::string answer;
    const Status s = lab().db().Read([&](SQLite::Database& db) -> Status {
      answer = db.execAndGet(sql).getString();
      return Ok{};
    });
    EXPECT_TRUE(s.ok()) << s.error().message;
    return answer;
  }

  Status Try(const std::string& sql) {
    return lab().db().Write([&](SQLite::Database& db) -> Status {
      db.exec(sql);
      return Ok{};
    });
  }

  testing_support::TemporaryFolder folder_;
  std::unique_ptr<Lab> lab_;
};

constexpr const char* kHash = "0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef";

TEST_F(Store, ATrialBeginsWithItsFolderItsFileAndItsRow) {
  TrialSpec spec;
  spec.label = "first";
  spec.pull = 0.25;
  const std::string id = Begin(spec);
  EXPECT_EQ(Ask("SELECT state FROM trial_overview"), "recording");
  const auto read = LoadTrial(lab(), id);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read.value().label, "first");
  EXPECT_EQ(read.value().pull, 0.25);
  EXPECT_EQ(Ask("SELECT sha256 FROM recording WHERE role = 'trial'"),
            Sha256OfFile(lab().TrialFolder(id) / "trial.toml").value());
}

TEST_F(Store, IdsAreUuidsThatSortByTime) {
  std::string before;
  for (std::int64_t ns = 1'700'000'000'000'000'000; ns < 1'700'000'000'003'000'000; ns += 1000) {
    const std::string id = NewTrialId(ns);
    EXPECT_TRUE(IsTrialId(id)) << id;
    EXPECT_EQ(id[14], '7');
    EXPECT_THAT("89ab", HasSubstr(std::string(1, id[19])));
    EXPECT_LT(before, id);
    before = id;
  }
  // The time field of RFC 9562's own example: 0x017F22E279B0 ms.
  EXPECT_EQ(NewTrialId(0x017F22E279B0LL * 1'000'000).substr(0, 13), "017f22e2-79b0");
}

TEST_F(Store, ATakenLabelLeavesNothingBehind) {
  TrialSpec spec;
  spec.label = "twice";
  Begin(spec);
  spec.design_name = "other";
  const auto again = BeginTrial(lab(), spec);
  ASSERT_FALSE(again.ok());
  EXPECT_EQ(again.error().kind, ErrorKind::kBadInput);
  EXPECT_THAT(again.error().message, HasSubstr("twice"));
  EXPECT_EQ(Ask("SELECT count(*) FROM trial"), "1");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(lab().folder() / "trials"), {}), 1);
}

TEST_F(Store, AFolderThatCannotBeMadeLeavesNoRow) {
  std::filesystem::remove(lab().folder() / "trials");
  std::ofstream(lab().folder() / "trials") << "a file where the folder should be";
  TrialSpec spec;
  spec.design_name = "paper";
  const auto trial = BeginTrial(lab(), spec);
  ASSERT_FALSE(trial.ok());
  EXPECT_EQ(trial.error().kind, ErrorKind::kIo);
  EXPECT_EQ(Ask("SELECT count(*) FROM trial"), "0");
  EXPECT_EQ(Ask("SELECT count(*) FROM design"), "0");
}

TEST_F(Store, BadNumbersAreRefusedBeforeAnythingIsMade) {
  TrialSpec spec;
  spec.pull = 1.5;
  EXPECT_THAT(BeginTrial(lab(), spec).error().message, HasSubstr("pull = 1.5"));
  spec = TrialSpec();
  spec.design.length = -1;
  EXPECT_EQ(BeginTrial(lab(), spec).error().kind, ErrorKind::kBadInput);
  spec = TrialSpec();
  spec.object.axis.setZero();
  EXPECT_FALSE(BeginTrial(lab(), spec).ok());
  spec = TrialSpec();
  spec.id = "../../etc";
  EXPECT_FALSE(BeginTrial(lab(), spec).ok());
  EXPECT_TRUE(std::filesystem::is_empty(lab().folder() / "trials"));
}

TEST_F(Store, TheSameDesignIsOneRowAndAnEditedOneGetsItsOwnLabel) {
  TrialSpec spec;
  spec.design_name = "paper";
  Begin(spec);
  Begin(spec);
  spec.design.taper = 1;
  Begin(spec);
  EXPECT_EQ(Ask("SELECT count(*) FROM design"), "2");
  EXPECT_EQ(Ask("SELECT count(DISTINCT label) FROM design"), "2");
  EXPECT_EQ(Ask("SELECT substr(label, 1, 6) FROM design WHERE taper = 1"), "paper@");
  EXPECT_EQ(Ask("SELECT beta_deg FROM design LIMIT 1"), "75.0");
  EXPECT_EQ(Ask("SELECT count(*) FROM object"), "1");
  EXPECT_EQ(Ask("SELECT count(*) FROM gripper"), "1");
}

TEST_F(Store, StatesOnlyGoForward) {
  const std::string id = Begin();
  EXPECT_TRUE(SetTrialState(lab(), id, TrialState::kRecorded).ok());
  EXPECT_TRUE(SetTrialState(lab(), id, TrialState::kDegraded, "12 frames dropped").ok());
  const Status back = SetTrialState(lab(), id, TrialState::kRecording);
  ASSERT_FALSE(back.ok());
  EXPECT_THAT(back.error().message, HasSubstr("degraded and cannot become recording"));
  EXPECT_EQ(SetTrialState(lab(), "nobody", TrialState::kFailed).error().kind, ErrorKind::kNotFound);
}

TEST_F(Store, EventsCannotBeChangedDeletedOrReplaced) {
  const std::string id = Begin();
  Judge(id, true, "ada", true);
  ASSERT_TRUE(AddNote(lab(), id, "slipped twice", "ada").ok());
  ASSERT_TRUE(AddLabel(lab(), id, "slipped", "ada").ok());
  ASSERT_TRUE(VoidTrial(lab(), id, "string tore", "ada").ok());
  for (const std::string table : {"outcome", "note", "label", "void"}) {
    EXPECT_FALSE(Try("UPDATE " + table + " SET at_ns = 0").ok()) << table;
    EXPECT_FALSE(Try("DELETE FROM " + table).ok()) << table;
    EXPECT_FALSE(Try("INSERT OR REPLACE INTO " + table + " SELECT * FROM " + table).ok()) << table;
    EXPECT_EQ(Ask("SELECT count(*) FROM " + table), "1") << table;
  }
  EXPECT_FALSE(Try("DELETE FROM trial").ok());
  EXPECT_FALSE(Try("UPDATE trial SET kind = 'virtual'").ok());
  EXPECT_FALSE(Try("UPDATE trial SET pull = 'a lot'").ok()) << "STRICT tables take no text for a number";
}

TEST_F(Store, TheNewestJudgementByAPersonCountsElseTheNewest) {
  const std::string id = Begin();
  const auto current = [&] { return Ask("SELECT grasped || judged_by FROM outcome_current"); };
  Judge(id, false, "rule 1", false);
  EXPECT_EQ(current(), "0rule 1");
  Judge(id, true, "rule 2", false);
  EXPECT_EQ(current(), "1rule 2");
  Judge(id, false, "ada", true);
  EXPECT_EQ(current(), "0ada");
  Judge(id, true, "rule 3", false);
  EXPECT_EQ(current(), "0ada");
  Judge(id, true, "bob", true);
  EXPECT_EQ(current(), "1bob");
  EXPECT_EQ(Ask("SELECT count(*) FROM outcome"), "5");
}

TEST_F(Store, RatesCountJudgedFinishedTrialsOfOneKindThatAreNotVoid) {
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

TEST_F(Store, RateNamesAreChecked) {
  EXPECT_THAT(CountGrasps(lab(), {.by = {"desing"}}).error().message, HasSubstr("did you mean design?"));
  EXPECT_THAT(CountGrasps(lab(), {.by = {"kind"}}).error().message, HasSubstr("--kind"));
  EXPECT_FALSE(CountGrasps(lab(), {.by = {"design; DROP TABLE trial"}}).ok());
  EXPECT_FALSE(CountGrasps(lab(), {.where = {{"distance", "near"}}}).ok());
  const auto injected = CountGrasps(lab(), {.where = {{"medium", "air' OR '1'='1"}}});
  ASSERT_TRUE(injected.ok());
  EXPECT_TRUE(injected.value().empty());
}

TEST_F(Store, ATrialIsFoundByIdPrefixAndLabel) {
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

TEST_F(Store, DerivedRowsAreReplacedWithTheirProvenanceAndFitsAccumulate) {
  const std::string id = Begin();
  const Provenance first{"tendril 0.1.0", R"({"step": 1})", {{"cam0", kHash}}};
  const Provenance second{"tendril 0.2.0", R"({"step": 2})", {{"cam0", kHash}, {"cam1", kHash}}};
  ASSERT_TRUE(StoreTrack(lab(), id, {.frames = 9, .tentacles = 8}, first).ok());
  ASSERT_TRUE(StoreTrack(lab(), id, {.frames = 10, .tentacles = 8}, second).ok());
  EXPECT_EQ(Ask("SELECT frames FROM track"), "10");
  EXPECT_EQ(Ask("SELECT count(*) FROM provenance"), "1");
  EXPECT_EQ(Ask("SELECT count(*) FROM provenance_input"), "2");
  EXPECT_EQ(Ask("SELECT count(*) FROM track WHERE rms_sigma_m IS NULL"), "1");

  LinkRows rows;
  for (int frame = 0; frame < 3; ++frame) {
    rows.tentacles.push_back({.frame = frame, .time_s = 0.1 * frame, .tentacle = 0, .object_link = 0.5});
    rows.pairs.push_back({.frame = frame, .time_s = 0.1 * frame, .a = 0, .b = 1, .link = -1});
  }
  rows.performance = 1.25;
  for (int again = 0; again < 2; ++again) {
    const Status stored = StoreLink(lab(), id, rows, first);
    ASSERT_TRUE(stored.ok()) << stored.error().message;
  }
  EXPECT_EQ(Ask("SELECT count(*) FROM link_tentacle WHERE self_link IS NULL"), "3");
  EXPECT_EQ(Ask("SELECT count(*) FROM link_pair"), "3");
  EXPECT_EQ(Ask("SELECT performance FROM link_by_trial"), "1.25");

  FitRow fit{.scope = "design paper", .trial_ids = {id}, .parameters = {{"stiffness_ratio", 1.1, 0.1}}};
  ASSERT_TRUE(StoreFit(lab(), fit, first).ok());
  fit.parameters[0].value = 1.2;
  ASSERT_TRUE(StoreFit(lab(), fit, second).ok());
  EXPECT_EQ(Ask("SELECT count(*) FROM fit"), "2");
  EXPECT_EQ(Ask("SELECT value FROM fit_latest"), "1.2");
  EXPECT_EQ(Ask("SELECT kinds FROM fit_latest"), "real");
  EXPECT_EQ(Ask("SELECT count(*) FROM made_from WHERE what = 'fit'"), "3");
}

TEST_F(Store, ASimulationIsReplacedAndScenesAreFoundByTheirText) {
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

TEST_F(Store, ASimulationIsReadAsItWasStored) {
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

TEST_F(Store, SimulationsThatAreNotTrustedCountWhereAskedForOnly) {
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

TEST_F(Store, DerivedRowsThatCannotBeAreRefusedWhole) {
  const std::string id = Begin();
  EXPECT_EQ(StoreTrack(lab(), id, {}, {.parameters_json = "not json"}).error().kind, ErrorKind::kBadInput);
  EXPECT_EQ(StoreTrack(lab(), id, {}, {.input_sha256 = {{"cam0", "123"}}}).error().kind,
            ErrorKind::kBadInput);
  EXPECT_EQ(StoreTrack(lab(), "nobody", {}, {}).error().kind, ErrorKind::kNotFound);
  LinkRows twice;
  twice.tentacles = {{.frame = 0, .tentacle = 0}, {.frame = 0, .tentacle = 0}};
  EXPECT_FALSE(StoreLink(lab(), id, twice, {}).ok());
  EXPECT_FALSE(StoreFit(lab(), {.trial_ids = {id, "nobody"}}, {}).ok());
  EXPECT_FALSE(StoreFit(lab(), {.trial_ids = {id}, .parameters = {{"k", kNotKnown}}}, {}).ok());
  for (const std::string table : {"provenance", "track", "link_metrics", "link_tentacle", "fit"}) {
    EXPECT_EQ(Ask("SELECT count(*) FROM " + table), "0") << table;
  }
}

TEST_F(Store, ARecordedFileReplacesThatOfItsRoleAndStaysInTheFolder) {
  const std::string id = Begin();
  ASSERT_TRUE(AddRecordingFile(lab(), id, "cam0", "cam0.mkv", kHash, 100, 0).ok());
  ASSERT_TRUE(AddRecordingFile(lab(), id, "cam0", "cam0.mkv", kHash, 120, 3).ok());
  EXPECT_EQ(Ask("SELECT frames || ' ' || dropped FROM recording WHERE role = 'cam0'"), "120 3");
  EXPECT_FALSE(AddRecordingFile(lab(), id, "x", "../x", kHash).ok());
  EXPECT_FALSE(AddRecordingFile(lab(), id, "x", "/etc/passwd", kHash).ok());
  EXPECT_FALSE(AddRecordingFile(lab(), id, "x", "x", "no hash").ok());
}

}  // namespace
}  // namespace tendril
