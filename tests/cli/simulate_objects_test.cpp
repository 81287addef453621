// tendril simulate with objects that move: what is written and told of them, tests of holding, trials that
// are trusted or not, and the same bytes however a run is made.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "db/files/curve_files.h"
#include "tests/support/plate_on_a_fork.h"
#include "tests/support/program.h"

namespace tendril {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing_support::Call;
using testing_support::Json;
using testing_support::kAway;
using testing_support::kFalling;
using testing_support::kSoftContact;
using testing_support::PlateOnAFork;
using testing_support::ProgramRun;
using testing_support::ReadText;
using testing_support::RunProgram;
using testing_support::TemporaryFolder;

TEST(SimulateObjects, WhatFallsFreelyIsWrittenAndToldAsItFell) {
  const TemporaryFolder folder;
  const std::string out = folder / "c.h5";
  const json told = Json(
      RunProgram(Call({"simulate", PlateOnAFork(folder), "--fps", "20", "--out", out, "--json"}, kFalling)));
  const json& object = told.at("objects").at(0);
  const double fallen = 0.5 * 9.80665 * 0.2 * 0.2;
  EXPECT_EQ(object.at("name"), "plate");
  EXPECT_EQ(object.at("motion"), "free");
  EXPECT_EQ(object.at("start_m"), json({0, 0, -1}));
  EXPECT_NEAR(object.at("end_m")[2].get<double>(), -1 - fallen, 1e-6);
  EXPECT_NEAR(object.at("moved_m").get<double>(), fallen, 1e-6);
  EXPECT_EQ(object.at("touched_at_end"), false);
  EXPECT_EQ(told.at("trusted"), true);
  const auto read = ReadObjectsOverTime(out);
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read.value().objects.size(), 1U);
  const ObjectSeries& series = read.value().objects[0];
  EXPECT_EQ(series.name, "plate");
  ASSERT_EQ(read.value().time.size(), 5);
  for (Eigen::Index f = 0; f < 5; ++f) {
    const double t = read.value().time[f];
    const std::size_t frame = static_cast<std::size_t>(f);
    EXPECT_NEAR(series.poses[frame].translation().z(), -1 - 0.5 * 9.80665 * t * t, 1e-6) << t;
    EXPECT_EQ(series.forces[frame], Eigen::Vector3d::Zero());
  }
}

TEST(SimulateObjects, RodsBearTheWeightOfWhatLiesOnThem) {
  const TemporaryFolder folder;
  const std::string scene = PlateOnAFork(folder);
  const std::string out = folder / "c.h5";
  const json told =
      Json(RunProgram({"simulate", scene, "--set", "duration=1.5", "--fps", "10", "--out", out, "--json"}));
  EXPECT_EQ(told.at("objects")[0].at("touched_at_end"), true);
  const auto read = ReadObjectsOverTime(out);
  ASSERT_TRUE(read.ok());
  // Once it has come to rest: m g upward.
  EXPECT_NEAR(read.value().objects[0].forces.back().z(), 0.01 * 9.80665, 0.02 * 0.01 * 9.80665);
  const ProgramRun words = RunProgram({"simulate", scene, "--fps", "10"});
  EXPECT_THAT(words.out, HasSubstr("object plate: free, from (0, 0, 0.0102) to"));
  EXPECT_THAT(words.out, HasSubstr("at the end rods press on it with"));
}

TEST(SimulateObjects, ALiftIsJudgedKeptAndCounted) {
  const TemporaryFolder folder;
  const std::string scene = PlateOnAFork(folder);
  const std::string lab = folder / "lab";
  ASSERT_EQ(RunProgram({"init", lab}).exit_code, 0);
  const auto simulate = [&](const std::string& label, const std::vector<std::string>& more) {
    return Json(RunProgram(
        Call({"simulate", scene, "--then", "lift", "--fps", "10", "--lab", lab, "--label", label, "--json"},
             more)));
  };
  const json lifted = simulate("lifted", {});
  EXPECT_EQ(lifted.at("holding").at("held"), true);
  // The prongs bend under it.
  EXPECT_GT(lifted.at("holding").at("rise_m").get<double>(), 0.12);
  EXPECT_LT(lifted.at("holding").at("rise_m").get<double>(), 0.15);
  EXPECT_EQ(lifted.at("trusted"), true) << lifted.at("doubts");
  const json left = simulate("left", kAway);
  EXPECT_EQ(left.at("holding").at("held"), false);
  EXPECT_EQ(left.at("holding").at("grasped"), false);
  const json soft = simulate("soft", kSoftContact);
  EXPECT_EQ(soft.at("trusted"), false);

  const auto show = [&](const std::string& label) {
    return Json(RunProgram({"trials", "show", label, "--lab", lab, "--json"}));
  };
  const json trial = show("lifted");
  EXPECT_EQ(trial.at("grasped"), true);
  EXPECT_EQ(trial.at("simulation").at("level"), "fast");
  EXPECT_EQ(trial.at("simulation").at("scene"), "plate on a fork");
  EXPECT_EQ(trial.at("simulation").at("friction"), 0.4);
  EXPECT_EQ(trial.at("simulation").at("medium"), "vacuum");
  EXPECT_EQ(trial.at("simulation").at("holding").at("test"), "lift");
  EXPECT_THAT(trial.at("simulation").at("holding").at("rule"), HasSubstr("above its start"));
  ASSERT_EQ(trial.at("events").size(), 1U);
  EXPECT_EQ(trial.at("events")[0].at("by_person"), false);
  EXPECT_EQ(show("left").at("grasped"), false);
  EXPECT_EQ(show("soft").at("trusted"), false);
  const json away = show("left");
  EXPECT_THAT(away.at("notes"), HasSubstr("object.0.position.2=-0.5"));
  // The scene that is kept is the one that was run.
  EXPECT_THAT(ReadText(lab + "/trials/" + std::string(away.at("id")) + "/scene.toml"), HasSubstr("hanging"));
  const std::string words = RunProgram({"trials", "show", "soft", "--lab", lab}).out;
  EXPECT_THAT(words, AllOf(HasSubstr("level fast"), HasSubstr("not trusted"), HasSubstr("overlap"),
                           HasSubstr("then lift:")));
  EXPECT_THAT(RunProgram({"trials", "list", "--lab", lab}).out, HasSubstr("(not trusted)"));
  const auto objects =
      ReadObjectsOverTime(std::filesystem::path(lab) / "trials" / std::string(trial.at("id")) / "curves.h5");
  ASSERT_TRUE(objects.ok()) << objects.error().message;
  EXPECT_EQ(objects.value().objects.size(), 1U);

  const auto stats = [&](const std::vector<std::string>& more) {
    return RunProgram(Call({"stats", "--lab", lab, "--kind", "simulated", "--json"}, more));
  };
  const ProgramRun trusted = stats({});
  EXPECT_EQ(Json(trusted).at("groups")[0].at("n"), 2);
  EXPECT_EQ(Json(trusted).at("groups")[0].at("k"), 1);
  EXPECT_EQ(Json(trusted).at("left_out_untrusted"), 1);
  EXPECT_THAT(trusted.err, AllOf(HasSubstr("1 simulated trial left out"), HasSubstr("--include-untrusted")));
  const ProgramRun all = stats({"--include-untrusted"});
  EXPECT_EQ(Json(all).at("groups")[0].at("n"), 3);
  EXPECT_EQ(Json(all).at("left_out_untrusted"), 0);
  EXPECT_THAT(all.err, Not(HasSubstr("left out")));
  const std::vector<std::string> plot = {"plot",      "rates", "--lab",    lab,     "--kind",
                                         "simulated", "--by",  "distance", "--out", folder / "rates.svg"};
  EXPECT_THAT(RunProgram(plot).err, HasSubstr("1 simulated trial left out"));
  EXPECT_THAT(RunProgram(Call(plot, {"--include-untrusted"})).err, Not(HasSubstr("left out")));

  // A person's outcome overrules the program's.
  ASSERT_EQ(RunProgram({"trials", "outcome", "lifted", "--failure", "--by", "Ada", "--lab", lab}).exit_code,
            0);
  EXPECT_EQ(Json(stats({})).at("groups")[0].at("k"), 0);
  EXPECT_EQ(RunProgram({"db", "check", "--lab", lab}).exit_code, 0);
}

// Threads, and a run that is stopped over and over, change no byte of what an object did.
TEST(SimulateObjects, StoppingThreadsAndFramesChangeNoByte) {
  const TemporaryFolder folder;
#ifdef __SANITIZE_ADDRESS__  // many times slower
  const std::string duration = "duration=0.5";
#else
  const std::string duration = "duration=6";
#endif
  const std::string scene = PlateOnAFork(folder);
  const auto call = [&](const std::string& out, const std::vector<std::string>& more) {
    // Nine rods: eight go to one thread, one to another.
    return Call({"simulate", scene, "--set", duration, "--set", "gripper.tentacles=9", "--fps", "10", "--out",
                 folder / out},
                more);
  };
  ASSERT_EQ(RunProgram(call("whole.h5", {})).exit_code, 0);
  ASSERT_EQ(RunProgram(call("threads.h5", {"--threads", "2"})).exit_code, 0);
  const std::string state = folder / "run.state";
  std::string command = TENDRIL_PROGRAM;
  for (const std::string& word : call("parts.h5", {"--checkpoint", state})) command += " " + word;
  command += " >/dev/null 2>&1";
  int stops = 0, code = 1;
  for (; stops < 100 && code != 0; ++stops) {
    const std::string time = std::to_string(0.1 + 0.15 * stops);
    code = std::system(("timeout -s INT " + time + " " + command).c_str());
  }
  EXPECT_EQ(code, 0);
  EXPECT_GT(stops, 1) << "it was never stopped";
  const std::string whole = ReadText(folder / "whole.h5");
  EXPECT_TRUE(ReadText(folder / "threads.h5") == whole);
  EXPECT_TRUE(ReadText(folder / "parts.h5") == whole);
}

TEST(SimulateObjects, WhatCannotBeTestedIsSaidBeforeTheRun) {
  const TemporaryFolder folder;
  const std::string scene = PlateOnAFork(folder);
  const auto refused = [](const std::vector<std::string>& words) {
    const ProgramRun run = RunProgram(words);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    const json told = json::parse(run.out, nullptr, false);
    EXPECT_TRUE(told.contains("error")) << run.out;
    EXPECT_THAT(run.err, HasSubstr(told.value("error", "nothing"))) << "the same words in both places";
    return told.value("error", "");
  };
  EXPECT_THAT(refused({"simulate", scene, "--then", "lift", "--fps", "2", "--json"}), HasSubstr("--fps 2"));
  EXPECT_THAT(refused({"simulate", scene, "--then", "lift", "--set", "object.0.motion=fixed", "--json"}),
              HasSubstr("expected an [[object]] with motion"));
  EXPECT_THAT(refused({"simulate", scene, "--set", "object.0.masss=1", "--json"}), HasSubstr("mass"));
  EXPECT_THAT(refused({"simulate", scene, "--then", "shake", "--json"}), HasSubstr("shake"));
  const ProgramRun help = RunProgram({"simulate", "--help"});
  EXPECT_THAT(help.out,
              AllOf(HasSubstr("--set gripper.tentacles=4"), HasSubstr("--then load"), HasSubstr(".h5")));
}

}  // namespace
}  // namespace tendril
