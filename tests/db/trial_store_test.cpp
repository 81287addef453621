// db/trial_store.h: trials begin and end whole, events are only added, derived rows are replaced.
#include "db/trial_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "db/files/safe_file.h"
#include "db/trial_query.h"
#include "tests/support/lab_test.h"

namespace tendril {
namespace {

using testing::HasSubstr;
using Store = testing_support::LabTest;

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
