// tendril simulate: what programs rely on, and what a wrong scene gets.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "db/files/curve_files.h"
#include "tests/support/program.h"

namespace tendril {
namespace {

using testing_support::ProgramRun;
using testing_support::RunProgram;
using testing_support::TemporaryFolder;
using testing_support::WriteText;

const std::string kScenes = TENDRIL_SOURCE_DIR "/examples/scenes/";

TEST(SimulateCommand, WritesCurvesAtFramesAndAtTheTimesAskedFor) {
  const TemporaryFolder folder;
  const std::string out = folder / "helix.csv";
  const ProgramRun run =
      RunProgram({"simulate", kScenes + "helix.toml", "--out", out, "--fps", "2", "--at", "0.123", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_GT(json.at("steps").get<int>(), 1000);
  EXPECT_EQ(json.at("level"), "standard");
  EXPECT_EQ(json.at("diverged"), false);
  EXPECT_GT(json.at("wall_s").get<double>(), 0);
  EXPECT_EQ(json.at("link").size(), 8u);
  const auto curves = ReadCurves(out);
  ASSERT_TRUE(curves.ok()) << curves.error().message;
  ASSERT_EQ(curves.value().size(), 1u);
  EXPECT_EQ(curves.value()[0].time.size(), 8);
  EXPECT_EQ(curves.value()[0].time[1], 0.123);
}

TEST(SimulateCommand, PlanSaysWhatTheSceneRequiresWithoutRunning) {
  const ProgramRun run = RunProgram({"simulate", kScenes + "paper.toml", "--plan", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_EQ(json.at("time_step_s"), 2e-5);
  EXPECT_FALSE(json.contains("steps"));
  for (const auto& term : json.at("terms")) EXPECT_TRUE(term.at("on").get<bool>()) << term;
}

// The paper's gripper for a few steps: everything that it switches on works together.
TEST(SimulateCommand, ThePapersSceneBegins) {
  const TemporaryFolder folder;
  std::string scene = testing_support::ReadText(kScenes + "paper.toml");
  scene.replace(scene.find("duration = 10.0"), 15, "duration = 0.002");
  std::filesystem::create_directory(folder / "designs");
  std::filesystem::copy_file(TENDRIL_SOURCE_DIR "/examples/designs/paper.toml",
                             folder / "designs/paper.toml");
  WriteText(folder / "short.toml", scene);
  const ProgramRun run = RunProgram({"simulate", folder / "short.toml", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_EQ(json.at("steps"), 100);
  EXPECT_EQ(json.at("bodies_passed"), 0);
}

TEST(SimulateCommand, BadScenesAreOneLineAndExitTwo) {
  const TemporaryFolder folder;
  const auto message = [&](const std::string& text) {
    WriteText(folder / "scene.toml", text);
    const ProgramRun run = RunProgram({"simulate", folder / "scene.toml"});
    EXPECT_EQ(run.exit_code, 2) << text << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    return run.err;
  };
  EXPECT_NE(message("duraton = 3\n").find("duration"), std::string::npos);
  EXPECT_NE(message("duration = 3\n").find("[[rod]]"), std::string::npos);
  EXPECT_NE(message("[gripper]\ndesign = \"none.toml\"\n").find("none.toml"), std::string::npos);
  EXPECT_NE(message("[[rod]]\nramp = [2, 1]\n").find("ramp"), std::string::npos);
  EXPECT_NE(message("[[object]]\nkind = \"sphere\"\n").find("radius"), std::string::npos);
  EXPECT_NE(message("[[rod]]\nnormal = [0, 0, 1]\n").find("normal"), std::string::npos);
  EXPECT_EQ(RunProgram({"simulate", kScenes + "helix.toml", "--at", "99"}).exit_code, 2);
}

TEST(SimulateCommand, ARunThatDivergesKeepsItsTrajectoryAndFails) {
  const TemporaryFolder folder;
  WriteText(folder / "scene.toml",
            "duration = 1\ntime_step = 0.01\n[[rod]]\nrest_curvature = [0, 6, 0]\nelements = 40\n");
  const std::string out = folder / "curves.csv";
  const ProgramRun run = RunProgram({"simulate", folder / "scene.toml", "--out", out, "--fps", "100"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(run.err.find("try time_step"), std::string::npos) << run.err;
  EXPECT_TRUE(std::filesystem::exists(out));
}

}  // namespace
}  // namespace tendril
