// db/migrations.h, db/connection.h, db/lab.h: a step is in or it is not; newer and foreign files stay
// untouched; two programs may come at once; old files become new ones.
#include "db/migrations.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <thread>

#include "db/files/safe_file.h"
#include "db/lab.h"
#include "db/trial_query.h"
#include "db/trial_store.h"
#include "tests/support/program.h"

namespace tendril {
namespace {

using testing::HasSubstr;
using testing_support::TemporaryFolder;

std::string Ask(Connection& connection, const std::string& sql) {
  return connection.handle().execAndGet(sql).getString();
}

TEST(Migrate, AStepThatFailsLeavesTheVersionBeforeIt) {
  auto opened = Connection::InMemory();
  ASSERT_TRUE(opened.ok());
  Connection& db = opened.value();
  const Migration bad[] = {{1, "good", "CREATE TABLE a (x)"},
                           {2, "half", "CREATE TABLE b (x); CREATE TABLE b (x); CREATE TABLE c (x)"}};
  const Status s = Migrate(db, bad);
  ASSERT_FALSE(s.ok());
  EXPECT_THAT(s.error().message, HasSubstr("schema step 2 'half'"));
  EXPECT_EQ(Ask(db, "PRAGMA user_version"), "1");
  EXPECT_EQ(Ask(db, "SELECT group_concat(name) FROM sqlite_master"), "a");
  const Migration mended[] = {bad[0], {2, "whole", "CREATE TABLE b (x)"}};
  EXPECT_TRUE(Migrate(db, mended).ok());
  EXPECT_EQ(Ask(db, "PRAGMA user_version"), "2");
}

TEST(Migrate, OurOwnStepsLeadToWhatTheyPromise) {
  auto db = Connection::InMemory();
  ASSERT_TRUE(db.ok());
  ASSERT_TRUE(Migrate(db.value()).ok());
  EXPECT_EQ(SchemaVersion(db.value()).value(), Migrations().back().version);
  EXPECT_EQ(Ask(db.value(),
                "SELECT count(*) FROM pragma_table_list WHERE type = 'table' AND strict = 0 "
                "AND name NOT LIKE 'sqlite_%'"),
            "0");
  EXPECT_EQ(Ask(db.value(), "PRAGMA foreign_keys"), "1");
  for (const Migration& step : Migrations()) EXPECT_FALSE(step.title.empty());
}

TEST(Migrate, ANewerFileIsRefusedAndLeftUntouched) {
  const TemporaryFolder folder;
  const std::string lab = folder / "lab";
  ASSERT_TRUE(Lab::Create(lab).ok());
  {
    auto db = Connection::Open(lab + "/lab.db");
    ASSERT_TRUE(db.ok());
    db.value().handle().exec("PRAGMA user_version = 1000");
  }
  const std::string before = Sha256OfFile(lab + "/lab.db").value();
  const auto opened = Lab::Open(lab);
  ASSERT_FALSE(opened.ok());
  EXPECT_EQ(opened.error().kind, ErrorKind::kBadInput);
  EXPECT_THAT(opened.error().message, HasSubstr("schema version is 1000"));
  EXPECT_EQ(Sha256OfFile(lab + "/lab.db").value(), before);
}

TEST(Migrate, AFileOfAnotherProgramIsRefusedAndLeftUntouched) {
  const TemporaryFolder folder;
  {
    auto db = Connection::Open(folder / "lab.db", Connection::Mode::kCreate);
    ASSERT_TRUE(db.ok());
    db.value().handle().exec("CREATE TABLE bookmarks (url TEXT)");
  }
  const std::string before = Sha256OfFile(folder / "lab.db").value();
  EXPECT_THAT(Lab::Open(folder.path()).error().message, HasSubstr("not a lab's"));
  EXPECT_EQ(Sha256OfFile(folder / "lab.db").value(), before);
  testing_support::WriteText(folder / "lab.db", "this is a text about tentacles, not a database at all");
  EXPECT_THAT(Lab::Open(folder.path()).error().message, HasSubstr("not a SQLite database"));
  EXPECT_EQ(Lab::Open(folder.path()).error().kind, ErrorKind::kBadInput);
}

// Runs `work` in so many processes at once; the number of them that did not succeed.
template <class Work>
int InProcesses(int count, Work work) {
  std::vector<pid_t> children;
  for (int i = 0; i < count; ++i) {
    const pid_t child = fork();
    if (child == 0) _exit(work(i) ? 0 : 1);
    children.push_back(child);
  }
  int failed = 0;
  for (const pid_t child : children) {
    int status = 0;
    waitpid(child, &status, 0);
    failed += WIFEXITED(status) && WEXITSTATUS(status) == 0 ? 0 : 1;
  }
  return failed;
}

TEST(Migrate, ProcessesThatComeAtOnceAllFindItDone) {
  const TemporaryFolder folder;
  const std::string file = folder / "lab.db";
  {
    auto db = Connection::Open(file, Connection::Mode::kCreate);
    ASSERT_TRUE(db.ok() && db.value().UseWriteAheadLog().ok());
  }
  EXPECT_EQ(InProcesses(6,
                        [&](int) {
                          auto db = Connection::Open(file);
                          return db.ok() && Migrate(db.value()).ok();
                        }),
            0);
  auto db = Connection::Open(file);
  EXPECT_EQ(SchemaVersion(db.value()).value(), Migrations().back().version);
  EXPECT_EQ(Ask(db.value(), "PRAGMA integrity_check"), "ok");
}

TEST(Lab, OnlyOneOfManyInitsMakesTheLab) {
  const TemporaryFolder folder;
  const std::string lab = folder / "lab";
  EXPECT_EQ(InProcesses(5, [&](int) { return Lab::Create(lab).ok(); }), 4);
  EXPECT_TRUE(Lab::Open(lab).ok());
  for (const auto& entry : std::filesystem::directory_iterator(lab)) {
    EXPECT_EQ(entry.path().filename().string().find(".tmp"), std::string::npos) << entry.path();
  }
}

TEST(Lab, WritersInManyProcessesLoseNoTrial) {
  const TemporaryFolder folder;
  const std::string home = folder / "lab";
  ASSERT_TRUE(Lab::Create(home).ok());
  EXPECT_EQ(InProcesses(4,
                        [&](int) {
                          auto lab = Lab::Open(home);
                          bool good = lab.ok();
                          for (int i = 0; good && i < 5; ++i) {
                            TrialSpec spec;
                            spec.design_name = "paper";
                            good = BeginTrial(lab.value(), spec).ok();
                          }
                          return good;
                        }),
            0);
  auto lab = Lab::Open(home);
  ASSERT_TRUE(lab.ok());
  EXPECT_EQ(ListTrials(lab.value()).value().size(), 20U);
  EXPECT_EQ(Ask(lab.value().db(), "SELECT count(*) FROM design"), "1");
}

TEST(Lab, ASecondInitChangesNothing) {
  const TemporaryFolder folder;
  ASSERT_TRUE(Lab::Create(folder / "lab").ok());
  const auto again = Lab::Create(folder / "lab");
  ASSERT_FALSE(again.ok());
  EXPECT_EQ(again.error().kind, ErrorKind::kBadInput);
  EXPECT_TRUE(Lab::Open(folder / "lab").ok());
}

TEST(Lab, AnInitThatFailsLeavesNoFolders) {
  const TemporaryFolder folder;
  testing_support::WriteText(folder / "file", "");
  EXPECT_FALSE(Lab::Create(folder / "file/lab").ok());
  testing_support::WriteText(folder / "trials", "a file where a folder should be");
  EXPECT_FALSE(Lab::Create(folder.path()).ok());
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 2);
}

TEST(Lab, IsFoundFromAnyFolderInIt) {
  const TemporaryFolder folder;
  const std::string home = folder / "lab";
  ASSERT_TRUE(Lab::Create(home).ok());
  const auto found = Lab::Find(home + "/trials");
  ASSERT_TRUE(found.ok());
  EXPECT_TRUE(std::filesystem::equivalent(found.value(), home));
  const auto none = Lab::Find(folder.path());
  EXPECT_EQ(none.error().kind, ErrorKind::kNotFound);
  EXPECT_THAT(none.error().message, HasSubstr("tendril init"));
  EXPECT_THAT(Lab::Open(folder.path()).error().message, HasSubstr("tendril init"));
}

// tests/data/db/schema_<n>.sql: a small lab of each released schema, as `sqlite3 lab.db .dump` writes it,
// with its version and application id in front.
TEST(Lab, OfEveryReleasedSchemaComesToTheNewestWithAllItHad) {
  const std::filesystem::path data = std::filesystem::path(TENDRIL_SOURCE_DIR) / "tests/data/db";
  for (const Migration& step : Migrations()) {
    const TemporaryFolder folder;
    const auto dump = ReadText(data / ("schema_" + std::to_string(step.version) + ".sql"));
    ASSERT_TRUE(dump.ok()) << dump.error().message;
    {
      auto db = Connection::Open(folder / "lab.db", Connection::Mode::kCreate);
      ASSERT_TRUE(db.ok());
      db.value().handle().exec("PRAGMA foreign_keys = OFF");
      db.value().handle().exec(dump.value());
      ASSERT_EQ(Ask(db.value(), "PRAGMA user_version"), std::to_string(step.version));
    }
    auto lab = Lab::Open(folder.path());
    ASSERT_TRUE(lab.ok()) << lab.error().message;
    EXPECT_EQ(SchemaVersion(lab.value().db()).value(), Migrations().back().version);
    EXPECT_EQ(Ask(lab.value().db(), "SELECT count(*) FROM pragma_foreign_key_check"), "0");
    const auto groups = CountGrasps(lab.value(), {.by = {"design"}});
    ASSERT_TRUE(groups.ok()) << groups.error().message;
    ASSERT_EQ(groups.value().size(), 1U);
    EXPECT_EQ(groups.value()[0].trials, 2);
    EXPECT_EQ(groups.value()[0].grasped, 1);
    EXPECT_EQ(Ask(lab.value().db(), "SELECT count(*) FROM trial"), "4");
    EXPECT_EQ(Ask(lab.value().db(), "SELECT value FROM fit_latest"), "1.2");
  }
}

// A simulation of before counts as trusted unless what it kept speaks against it.
TEST(Lab, SimulationsOfBeforeAreDoubtedByTheRuleOfNow) {
  const auto dump = ReadText(std::filesystem::path(TENDRIL_SOURCE_DIR) / "tests/data/db/schema_2.sql");
  ASSERT_TRUE(dump.ok()) << dump.error().message;
  const auto after = [&](const std::string& change) {
    const TemporaryFolder folder;
    {
      auto db = Connection::Open(folder / "lab.db", Connection::Mode::kCreate);
      db.value().handle().exec("PRAGMA foreign_keys = OFF");
      db.value().handle().exec(dump.value());
      db.value().handle().exec("UPDATE simulation SET " + change);
    }
    auto lab = Lab::Open(folder.path());
    return Ask(lab.value().db(), "SELECT trusted || ':' || replace(doubts, char(10), '|') FROM simulation");
  };
  EXPECT_EQ(after("least_axis_share = 0.92"), "1:");
  EXPECT_EQ(after("least_axis_share = NULL, nothing_passed = NULL"), "1:") << "not looked at is no doubt";
  EXPECT_EQ(after("least_axis_share = 0.875"), "1:") << "a quarter of a radius is still believed";
  EXPECT_EQ(after("least_axis_share = 0.85"), "0:bodies overlap by 30 % of a radius");
  EXPECT_EQ(after("nothing_passed = 0, divergence = 'at 3 s'"),
            "0:a body may have passed through another|it diverged");
}

TEST(Lab, ARunOfBeforeThatWasStoredTwiceCountsOnce) {
  const auto dump = ReadText(std::filesystem::path(TENDRIL_SOURCE_DIR) / "tests/data/db/schema_3.sql");
  ASSERT_TRUE(dump.ok()) << dump.error().message;
  const auto counted = [&](const std::string& change) {
    const TemporaryFolder folder;
    {
      auto db = Connection::Open(folder / "lab.db", Connection::Mode::kCreate);
      db.value().handle().exec("PRAGMA foreign_keys = OFF");
      db.value().handle().exec(dump.value());
      // The lab's first trial as a second of its simulation's run.
      db.value().handle().exec(
          "CREATE TEMP TABLE twin AS SELECT * FROM simulation; UPDATE twin SET trial_id = "
          "(SELECT min(id) FROM trial), provenance_id = provenance_id");
      db.value().handle().exec(change);
      db.value().handle().exec("INSERT INTO simulation SELECT * FROM twin");
    }
    auto lab = Lab::Open(folder.path());
    return Ask(lab.value().db(),
               "SELECT count(DISTINCT run_key) || ' of ' || count(run_key) FROM simulation");
  };
  EXPECT_EQ(counted("SELECT 1"), "1 of 2");
  EXPECT_EQ(counted("UPDATE twin SET level = 'fast'"), "2 of 2");
  EXPECT_EQ(counted("UPDATE twin SET trial_number = 7"), "2 of 2");
}

// Every block of SQL in docs/database.md runs on a lab.
TEST(Docs, QueriesOfTheDatabasePageRun) {
  const std::filesystem::path source = TENDRIL_SOURCE_DIR;
  const auto page = ReadText(source / "docs/database.md");
  ASSERT_TRUE(page.ok()) << page.error().message;
  auto db = Connection::InMemory();
  ASSERT_TRUE(db.ok() && Migrate(db.value()).ok());
  const std::string open = "```sql\n";
  int blocks = 0;
  for (size_t at = page.value().find(open); at != std::string::npos; at = page.value().find(open, at)) {
    at += open.size();
    const std::string sql = page.value().substr(at, page.value().find("```", at) - at);
    EXPECT_NO_THROW(db.value().handle().exec(sql)) << sql;
    ++blocks;
  }
  EXPECT_GE(blocks, 1);
}

}  // namespace
}  // namespace tendril
