// init, trials, stats, db check through the real program: what they print, their JSON, exit codes and
// messages.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "db/trial_store.h"
#include "tests/support/program.h"

namespace tendril {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing_support::ProgramRun;
using testing_support::RunProgram;
using testing_support::TemporaryFolder;

class LabCommands : public testing::Test {
 protected:
  void SetUp() override {
    const ProgramRun made = RunProgram({"init", home_});
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }

  // So many finished trials, not judged; their labels are PREFIX-1, PREFIX-2, ...
  void Add(TrialKind kind, const std::string& prefix, int count, double distance) {
    auto lab = Lab::Open(home_);
    ASSERT_TRUE(lab.ok());
    for (int i = 1; i <= count; ++i) {
      TrialSpec spec;
      spec.kind = kind;
      spec.label = prefix + "-" + std::to_string(i);
      spec.design_name = "paper";
      spec.object_distance = distance;
      const auto trial = BeginTrial(lab.value(), spec);
      ASSERT_TRUE(trial.ok()) << trial.error().message;
      ASSERT_TRUE(SetTrialState(lab.value(), trial.value().id, TrialState::kRecorded).ok());
    }
  }

  ProgramRun In(std::vector<std::string> arguments) { return RunProgram(arguments, home_); }

  // Every refusal: its exit code, one line on stderr, nothing on stdout.
  void ExpectRefused(const std::vector<std::string>& arguments, const std::string& message) {
    const ProgramRun run = In(arguments);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_THAT(run.err, HasSubstr(message));
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_EQ(run.out, "");
  }

  TemporaryFolder folder_;
  std::string home_ = folder_ / "lab";
};

TEST_F(LabCommands, InitMakesTheFoldersOnce) {
  for (const char* name : {"designs", "rigs", "scenes", "sweeps", "trials", "lab.db"}) {
    EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(home_) / name)) << name;
  }
  ExpectRefused({"init", home_}, "there is a lab already");
}

TEST_F(LabCommands, StatsGivesTheFieldsThatProgramsRelyOn) {
  Add(TrialKind::kReal, "r", 29, 0.15);
  Add(TrialKind::kVirtual, "v", 3, 0.15);
  ASSERT_EQ(In({"trials", "outcome", "r-1", "--success", "--by", "Ada"}).exit_code, 0);
  for (int i = 2; i <= 29; ++i) {
    const ProgramRun run = In({"trials", "outcome", "r-" + std::to_string(i), "--failure", "--by", "Ada"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  const ProgramRun run = In({"stats", "--by", "design,distance", "--where", "medium=air", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json groups = json::parse(run.out)["groups"];
  ASSERT_EQ(groups.size(), 1U);
  const json& group = groups[0];
  EXPECT_EQ(group["design"], "paper");
  EXPECT_EQ(group["distance"], 0.15);
  EXPECT_EQ(group["n"], 29);
  EXPECT_EQ(group["k"], 1);
  EXPECT_DOUBLE_EQ(group["rate"], 1.0 / 29);
  // Newcombe 1998, table I: 1/29, methods 3 and 5.
  EXPECT_NEAR(group["wilson95"][0], 0.0061, 5e-5);
  EXPECT_NEAR(group["wilson95"][1], 0.1718, 5e-5);
  EXPECT_NEAR(group["clopper_pearson95"][0], 0.0009, 5e-5);
  EXPECT_NEAR(group["clopper_pearson95"][1], 0.1776, 5e-5);

  const ProgramRun csv = In({"stats", "--by", "design,distance", "--csv"});
  EXPECT_THAT(csv.out,
              AllOf(HasSubstr("design,distance_m,n,k,rate,wilson95_low"), HasSubstr("paper,0.15,29,1,")));
  EXPECT_THAT(In({"stats"}).out, HasSubstr("success rates of real trials"));
}

TEST_F(LabCommands, StatsNeverMixesKindsAndSaysWhatElseThereIs) {
  Add(TrialKind::kVirtual, "v", 2, 0.15);
  ASSERT_EQ(In({"trials", "outcome", "v-1", "--success", "--by", "Ada"}).exit_code, 0);
  const ProgramRun real = In({"stats", "--json"});
  EXPECT_EQ(real.exit_code, 0);
  EXPECT_THAT(real.err, HasSubstr("1 virtual (--kind virtual)"));
  EXPECT_TRUE(json::parse(real.out)["groups"].empty());
  const ProgramRun rendered = In({"stats", "--kind", "virtual", "--json"});
  EXPECT_EQ(json::parse(rendered.out)["groups"][0]["n"], 1);
}

TEST_F(LabCommands, BadCallsExitWithTwoAndOneLine) {
  Add(TrialKind::kReal, "r", 1, 0.15);
  ExpectRefused({"stats", "--by", "desing"}, "did you mean design?");
  ExpectRefused({"stats", "--by", "1; DROP TABLE trial"}, "unknown name");
  ExpectRefused({"stats", "--where", "medium"}, "expected NAME=VALUE");
  ExpectRefused({"stats", "--where", "distance=near"}, "expected a number in m");
  ExpectRefused({"trials", "show", "r-2"}, "did you mean r-1?");
  ExpectRefused({"trials", "outcome", "r-1", "--by", "Ada"}, "--success or --failure");
  ExpectRefused({"trials", "outcome", "r-1", "--success", "--failure", "--by", "Ada"},
                "--success or --failure");
  ExpectRefused({"trials", "outcome", "r-1", "--success", "--by", "Ada", "--load-N", "-1"}, "force >= 0 N");
  ExpectRefused({"trials", "note", "r-1", "", "--by", "Ada"}, "note");
  EXPECT_EQ(In({"trials", "outcome", "r-1", "--success"}).exit_code, 2);
  EXPECT_EQ(In({"stats", "--kind", "imagined"}).exit_code, 2);
  EXPECT_THAT(In({"trials", "show", "r-1"}).out, HasSubstr("outcome: -"));
  // Programs get the message, too, also of a call that cannot be parsed.
  for (const std::vector<std::string>& call : std::vector<std::vector<std::string>>{
           {"stats", "--csv", "--json"}, {"stats", "--kind", "imagined", "--json"}, {"statz", "--json"}}) {
    const ProgramRun run = In(call);
    EXPECT_EQ(run.exit_code, 2);
    const json told = json::parse(run.out, nullptr, false);
    ASSERT_TRUE(told.contains("error")) << call[0] << run.out;
    EXPECT_THAT(run.err, HasSubstr(told.value("error", "nothing")));
  }
}

TEST_F(LabCommands, ATrialTellsItsStory) {
  Add(TrialKind::kReal, "r", 1, 0.15);
  ASSERT_EQ(In({"trials", "outcome", "r-1", "--failure", "--by", "Ada", "--method", "by eye"}).exit_code, 0);
  ASSERT_EQ(In({"trials", "outcome", "r-1", "--success", "--by", "Bob", "--load-N", "4.25"}).exit_code, 0);
  ASSERT_EQ(In({"trials", "note", "r-1", "it slipped, then held", "--by", "Bob"}).exit_code, 0);
  const json shown = json::parse(In({"trials", "show", "r-1", "--json"}).out);
  EXPECT_EQ(shown["label"], "r-1");
  EXPECT_EQ(shown["grasped"], true);
  ASSERT_EQ(shown["events"].size(), 3U);
  EXPECT_EQ(shown["events"][0]["counts"], false);
  EXPECT_EQ(shown["events"][1]["counts"], true);
  EXPECT_EQ(shown["events"][1]["load_N"], 4.25);
  EXPECT_EQ(shown["files"][0]["file"], "trial.toml");
  EXPECT_THAT(In({"trials", "list"}).out, AllOf(HasSubstr("r-1"), HasSubstr("success")));
  ASSERT_EQ(In({"trials", "void", "r-1", "--reason", "string tore", "--by", "Bob"}).exit_code, 0);
  EXPECT_THAT(In({"trials", "list"}).out, AllOf(HasSubstr("void"), Not(HasSubstr("success"))));
  EXPECT_THAT(In({"stats"}).err, HasSubstr("no trial of this lab counts yet"));
}

TEST_F(LabCommands, DbCheckFindsAChangedFileAndAMissingOne) {
  Add(TrialKind::kReal, "r", 2, 0.15);
  EXPECT_THAT(In({"db", "check"}).out, HasSubstr("all is well"));
  const json trials = json::parse(In({"trials", "list", "--json"}).out)["trials"];
  const std::filesystem::path folder = std::filesystem::path(home_) / "trials";
  testing_support::WriteText(folder / std::string(trials[0]["id"]) / "trial.toml", "id = \"other\"\n");
  std::filesystem::remove(folder / std::string(trials[1]["id"]) / "trial.toml");
  const ProgramRun run = In({"db", "check", "--json"});
  EXPECT_EQ(run.exit_code, 1);
  const json checked = json::parse(run.out);
  ASSERT_EQ(checked["problems"].size(), 2U);
  EXPECT_THAT(std::string(checked["problems"][0]), HasSubstr("was changed after it was recorded"));
  EXPECT_EQ(checked["schema_steps"].size(), checked["schema_version"].get<size_t>());
}

TEST_F(LabCommands, WithoutALabTheProgramSaysHowToMakeOne) {
  const TemporaryFolder elsewhere;
  const ProgramRun run = RunProgram({"trials", "list"}, elsewhere.path());
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("tendril init"));
  EXPECT_EQ(RunProgram({"trials", "list", "--lab", home_}, elsewhere.path()).exit_code, 0);
  EXPECT_EQ(RunProgram({"trials", "list"}, home_ + "/trials").exit_code, 0)
      << "any folder within the lab will do";
}

TEST_F(LabCommands, ALabOfANewerSchemaIsRefusedByEveryCommand) {
  {
    auto db = Connection::Open(home_ + "/lab.db");
    ASSERT_TRUE(db.ok());
    db.value().handle().exec("PRAGMA user_version = 99");
  }
  for (const std::vector<std::string>& call : std::vector<std::vector<std::string>>{
           {"trials", "list"}, {"stats"}, {"db", "check"}, {"trials", "note", "x", "y", "--by", "z"}}) {
    ExpectRefused(call, "schema version is 99");
  }
}

TEST_F(LabCommands, BadDesignFilesExitWithTwoAndOneLine) {
  const auto with = [&](const std::string& toml) {
    testing_support::WriteText(folder_ / "d.toml", toml);
    return folder_ / "d.toml";
  };
  ExpectRefused({"fold", with("[tentacle]\nlength = -0.75\n"), "--pull", "0.3"},
                "d.toml:2: tentacle.length = -0.75");
  ExpectRefused({"fold", with("[tentacle]\nholes = \"many\"\n"), "--pull", "0.3"}, "expected a whole number");
  ExpectRefused({"fold", with("[tentacle]\nbeta = 75\n"), "--pull", "0.3"}, "did you mean");
  ExpectRefused({"fold", with("[tentacle\n"), "--pull", "0.3"}, "d.toml:1: not TOML");
  ExpectRefused({"fold", folder_ / "none.toml", "--pull", "0.3"}, "none.toml");
}

}  // namespace
}  // namespace tendril
