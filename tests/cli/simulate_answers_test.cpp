// tendril simulate: what is said first, which links are told, and that a lab keeps a run once.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/support/plate_on_a_fork.h"
#include "tests/support/program.h"

namespace tendril {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;
using testing_support::Call;
using testing_support::Json;
using testing_support::kAway;
using testing_support::kFalling;
using testing_support::PlateOnAFork;
using testing_support::ProgramRun;
using testing_support::ReadText;
using testing_support::RunProgram;
using testing_support::TemporaryFolder;
using testing_support::WriteText;

std::vector<std::string> LinesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

TEST(SimulateAnswers, ThePlanIsShortAndTheVerdictComesFirst) {
  const TemporaryFolder folder;
  const std::string scene = PlateOnAFork(folder);
  const auto said = [&](const std::vector<std::string>& more) {
    return LinesOf(RunProgram(Call({"simulate", scene, "--fps", "10"}, more)).out);
  };
  const std::vector<std::string> fell = said(kFalling);
  ASSERT_GT(fell.size(), 5U);
  EXPECT_THAT(fell[0], StartsWith("level fast, steps of "));
  EXPECT_THAT(fell[1], StartsWith("  on:  "));
  EXPECT_THAT(fell[2], StartsWith("  off: "));
  EXPECT_THAT(fell[3], HasSubstr("--plan"));
  EXPECT_EQ(fell[4], "plate: free: it fell by 196 mm, no rod touches it");
  EXPECT_THAT(said(kAway)[4], "plate: hanging: from its string alone, no rod touches it");
  EXPECT_THAT(said({"--set", "duration=1.5"})[4], StartsWith("plate: free: rods bear 1"));
  EXPECT_THAT(said({"--set", "medium.gravity=[0, 0, 0]", "--set", "object.0.velocity=[0, 0, 0.5]"})[4],
              "plate: free, without weight: at the end no rod touches it, moves at 500 mm/s");
  EXPECT_THAT(said({"--then", "lift"})[4], StartsWith("lift: lifted: "));
  // Each term has its line where they are asked for.
  const std::vector<std::string> plan = said({"--plan"});
  EXPECT_THAT(plan[1], AllOf(HasSubstr("contact of rods: "), Not(StartsWith("  on:"))));
  // With words for programs alone.
  const json told = Json(RunProgram(Call({"simulate", scene, "--fps", "10", "--json"}, kFalling)));
  EXPECT_THAT(told.at("without_test")[0].at("fate"), HasSubstr("it fell by 196 mm"));
  EXPECT_TRUE(told.at("least_axis_share").is_null()) << "nothing touched";
}

// docs/formats.md: the scene that is shown whole begins, as it stands there.
TEST(SimulateAnswers, TheSceneOfTheFormatsPageRuns) {
  const std::string page = ReadText(TENDRIL_SOURCE_DIR "/docs/formats.md");
  const std::string open = "```toml\n";
  const std::size_t block = page.find(open, page.find("A grasp, whole."));
  ASSERT_NE(block, std::string::npos);
  const std::size_t begin = block + open.size();
  const TemporaryFolder folder;
  WriteText(folder / "paper.toml", "");
  WriteText(folder / "tube.toml", page.substr(begin, page.find("```", begin) - begin));
  const json told =
      Json(RunProgram({"simulate", folder / "tube.toml", "--then", "lift", "--plan", "--json"}));
  EXPECT_EQ(told.at("level"), "fast");
  const json run = Json(RunProgram({"simulate", folder / "tube.toml", "--set", "duration=0.1", "--json"}));
  EXPECT_FALSE(run.contains("warnings")) << run.at("warnings");
  EXPECT_EQ(run.at("objects")[0].at("motion"), "hanging");
  EXPECT_EQ(run.at("trusted"), true);
}

TEST(SimulateAnswers, ADesignThatWasFittedSaysByWhichLawItFolds) {
  const TemporaryFolder folder;
  WriteText(folder / "drawn.toml", "");
  WriteText(folder / "fitted.toml",
            "[crease]\nlaw = \"exact\"\nrest_angle_deg = 12\n[tendon]\npull_scale = 0.95\nfriction = 0.02\n");
  const auto plan = [&](const std::string& design) {
    WriteText(folder / "scene.toml",
              "duration = 1\n[gripper]\ndesign = \"" + design +
                  "\"\ntentacles = 2\npull = 0.1\n[gripper.rod]\nbase_radius = 0.01\nyoungs_modulus = 1.6e6\n"
                  "density = 400\nelements = 50\n");
    const auto run = RunProgram({"simulate", folder / "scene.toml", "--plan"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.out;
  };
  EXPECT_THAT(plan("drawn.toml"), Not(HasSubstr("folds by")));
  EXPECT_THAT(plan("fitted.toml"),
              AllOf(HasSubstr("folds by law exact, as the design states it"), HasSubstr("pull_scale 0.95"),
                    HasSubstr("rest angle 12 deg"), HasSubstr("friction 0.02")));
  const json told = Json(RunProgram({"simulate", folder / "scene.toml", "--plan", "--json"}));
  EXPECT_EQ(told.at("fold_law").at("law"), "exact");
  EXPECT_EQ(told.at("fold_law").at("pull_scale"), 0.95);
}

TEST(SimulateAnswers, WhatTouchesIsToldAsAShareToo) {
  const TemporaryFolder folder;
  const json told =
      Json(RunProgram({"simulate", PlateOnAFork(folder), "--set", "duration=0.5", "--fps", "10", "--json"}));
  EXPECT_GT(told.at("least_axis_share").get<double>(), 0.5);
  EXPECT_LT(told.at("least_axis_share").get<double>(), 1);
}

TEST(SimulateAnswers, LinksAreThoseOfTheGraspBeforeItsTest) {
  const TemporaryFolder folder;
  const std::string scene = PlateOnAFork(folder), lab = folder / "lab";
  ASSERT_EQ(RunProgram({"init", lab}).exit_code, 0);
  // Pulled until the test, which then unwinds: links of the end are others.
  const std::vector<std::string> call = {"simulate", scene,
                                         "--set",    "gripper.pull=0.2",
                                         "--set",    "gripper.pull_rate=1",
                                         "--fps",    "10",
                                         "--then",   "release",
                                         "--set",    "duration=0.4",
                                         "--lab",    lab,
                                         "--label",  "r"};
  const json told = Json(RunProgram(Call(call, {"--json"})));
  EXPECT_NEAR(told.at("link_time_s").get<double>(), 0.4, 1e-12);
  const json& over_time = told.at("link");
  EXPECT_NEAR(over_time[4].at("time").get<double>(), 0.4, 1e-12);
  EXPECT_EQ(told.at("mutual_link"), over_time[4].at("mutual_link"));
  EXPECT_GT(std::abs(over_time.back().at("mutual_link").get<double>() - told.at("mutual_link").get<double>()),
            1e-3);
  const json again = Json(RunProgram({"link", "--trial", "r", "--lab", lab, "--json"}));
  EXPECT_EQ(again.at("time_s"), told.at("link_time_s"));
  EXPECT_NEAR(again.at("mutual_link").get<double>(), told.at("mutual_link").get<double>(), 1e-9);
}

TEST(SimulateAnswers, AnObjectWithoutAnAxisHasNoObjectLink) {
  const TemporaryFolder folder;
  const std::string scene = PlateOnAFork(folder), lab = folder / "lab";
  ASSERT_EQ(RunProgram({"init", lab}).exit_code, 0);
  // A fixed bar, which has an axis, is not what is to be grasped.
  WriteText(scene,
            ReadText(scene) +
                "[[object]]\nkind = \"cylinder\"\nradius = 0.01\nlength = 0.1\nposition = [0, 0, 0.5]\n");
  const ProgramRun words = RunProgram({"simulate", scene, "--fps", "10", "--lab", lab, "--label", "plate"});
  ASSERT_EQ(words.exit_code, 0) << words.err;
  EXPECT_THAT(words.out, HasSubstr("no object link: a box has no axis"));
  const json told = Json(RunProgram({"simulate", scene, "--fps", "10", "--json"}));
  EXPECT_TRUE(told.at("object_link").is_null());
  EXPECT_TRUE(told.at("link")[0].at("object_link").is_null());
  const json measured = Json(RunProgram({"link", "--trial", "plate", "--lab", lab, "--json"}));
  EXPECT_TRUE(measured.at("object_link").is_null());
  EXPECT_TRUE(measured.at("performance").is_null());
  EXPECT_FALSE(measured.at("mutual_link").is_null());
  EXPECT_THAT(RunProgram({"link", "--trial", "plate", "--lab", lab}).out, HasSubstr("a box has no axis"));
  EXPECT_EQ(RunProgram({"plot", "link", "plate", "--lab", lab, "--out", folder / "link.svg"}).exit_code, 0);
}

TEST(SimulateAnswers, ALabKeepsARunOnce) {
  const TemporaryFolder folder;
  const std::string scene = PlateOnAFork(folder), lab = folder / "lab";
  ASSERT_EQ(RunProgram({"init", lab}).exit_code, 0);
  const auto run = [&](const std::vector<std::string>& more) {
    return Json(RunProgram(Call({"simulate", scene, "--fps", "10", "--lab", lab, "--json"}, more)));
  };
  const json first = run({"--label", "first"});
  EXPECT_EQ(first.at("already_there"), false);
  const json again = run({});
  EXPECT_EQ(again.at("already_there"), true);
  EXPECT_EQ(again.at("trial"), "first");
  EXPECT_THAT(again.at("warnings")[0], HasSubstr("in the lab already, as trial first"));
  // What says the same in other words is the same run: a remark, another name, the level from the call.
  WriteText(scene, "# A remark.\n" + ReadText(scene));
  EXPECT_EQ(run({"--set", "name=renamed", "--level", "fast"}).at("trial"), "first");
  // What is another in any of these is another run.
  EXPECT_EQ(run({"--trial", "1"}).at("already_there"), false);
  EXPECT_EQ(run({"--set", "contact.friction=0.5"}).at("already_there"), false);
  EXPECT_EQ(run({"--level", "standard"}).at("already_there"), false);
  const auto kept = [&] {
    return Json(RunProgram({"trials", "list", "--lab", lab, "--json"})).at("trials").size();
  };
  EXPECT_EQ(kept(), 4U);
  // A trial that is void stands for nothing.
  ASSERT_EQ(RunProgram({"trials", "void", "first", "--reason", "wrong scene", "--by", "Ada", "--lab", lab})
                .exit_code,
            0);
  EXPECT_EQ(run({}).at("already_there"), false);
  EXPECT_EQ(kept(), 5U);
  EXPECT_EQ(RunProgram({"db", "check", "--lab", lab}).exit_code, 0);
}

TEST(SimulateAnswers, RatesOfALabAreOfOneTestOfHolding) {
  const TemporaryFolder folder;
  const std::string scene = PlateOnAFork(folder), lab = folder / "lab";
  ASSERT_EQ(RunProgram({"init", lab}).exit_code, 0);
  for (const std::string test : {"lift", "release"}) {
    ASSERT_EQ(RunProgram({"simulate", scene, "--then", test, "--fps", "10", "--lab", lab}).exit_code, 0);
  }
  const auto stats = [&](const std::vector<std::string>& more) {
    return RunProgram(Call({"stats", "--lab", lab, "--kind", "simulated"}, more));
  };
  const ProgramRun mixed = stats({"--by", "level", "--json"});
  EXPECT_THAT(mixed.err, HasSubstr("a rate is of one kind of test"));
  ASSERT_EQ(Json(mixed).at("groups").size(), 2U);
  EXPECT_EQ(Json(mixed).at("groups")[0].at("test"), "lift");
  EXPECT_EQ(Json(mixed).at("groups")[1].at("test"), "release");
  EXPECT_THAT(stats({"--csv"}).out, HasSubstr("\nlift,1,"));
  const ProgramRun lifts = stats({"--by", "friction", "--where", "test=lift", "--json"});
  EXPECT_THAT(lifts.err, Not(HasSubstr("one kind")));
  EXPECT_EQ(Json(lifts).at("groups")[0].at("friction"), 0.4);
  EXPECT_EQ(Json(lifts).at("groups")[0].at("n"), 1);
}

TEST(SimulateAnswers, TheLevelOfTheCallIsCheckedWithTheScene) {
  const TemporaryFolder folder;
  const ProgramRun run = RunProgram({"simulate", PlateOnAFork(folder), "--level", "static"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_EQ(LinesOf(run.err).size(), 1U) << run.err;
  EXPECT_THAT(run.err, AllOf(HasSubstr("--level static"), HasSubstr("an object moves")));
}

TEST(SimulateAnswers, WhatStartsInsideAnotherIsSaidAtOnce) {
  const TemporaryFolder folder;
  const std::string scene = PlateOnAFork(folder);
  const auto at = [&](const std::string& height) {
    return RunProgram({"simulate", scene, "--fps", "10", "--set", "object.0.position.2=" + height, "--json"});
  };
  // The rods' upper side is 3 mm above their axes where the plate, 10 mm thick, reaches over them.
  const ProgramRun shallow = at("0.0076");
  EXPECT_EQ(shallow.exit_code, 0) << shallow.err;
  EXPECT_THAT(Json(shallow).at("warnings")[0],
              AllOf(HasSubstr("deep in plate"), HasSubstr("they start inside")));
  EXPECT_LT(shallow.err.find("they start inside"), shallow.err.find("100 %")) << "before the run";
  const ProgramRun deep = at("0.0066");
  EXPECT_EQ(deep.exit_code, 2);
  EXPECT_THAT(deep.err, AllOf(HasSubstr("deep in plate"), HasSubstr("move them apart")));
}

TEST(SimulateAnswers, TheSpeedOfARunThatGoesOnIsOfWhatWasSimulatedSince) {
  const TemporaryFolder folder;
#ifdef __SANITIZE_ADDRESS__  // many times slower
  const std::string duration = "duration=1";
#else
  const std::string duration = "duration=20";
#endif
  const std::string state = folder / "run.state";
  // Frames far apart: the last one kept says little of how far it came.
  std::string command = TENDRIL_PROGRAM;
  const std::vector<std::string> call = {"simulate", PlateOnAFork(folder), "--set", duration, "--fps",
                                         "0.04",     "--checkpoint",       state,   "--json"};
  for (const std::string& word : call) command += " " + word;
  command += " >/dev/null 2>&1";
  for (int k = 1; k < 50 && !std::filesystem::exists(state); ++k) {
    ASSERT_NE(std::system(("timeout -s INT " + std::to_string(0.1 * k) + " " + command).c_str()), 0)
        << "it was never stopped";
  }
  const json rest = Json(RunProgram(call));
  const double resumed_at = rest.at("resumed_at_s").get<double>();
  EXPECT_GT(resumed_at, 0);
  const double whole = std::stod(duration.substr(duration.find('=') + 1));
  EXPECT_NEAR(rest.at("times_real_time").get<double>() * rest.at("wall_s").get<double>(), whole - resumed_at,
              1e-9 * whole);
}

}  // namespace
}  // namespace tendril
