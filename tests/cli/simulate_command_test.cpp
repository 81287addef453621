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
  for (const auto& term : json.at("terms")) {
    // It has neither: no friction, and elements shorter than their rods are thick.
    const bool without = term.at("name") == "friction" || term.at("name") == "contact within elements";
    EXPECT_NE(term.at("on").get<bool>(), without) << term;
  }
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

// The paper's gripper, shorter and coarser.
std::string SmallGripper(const TemporaryFolder& folder, const std::string& duration) {
  std::filesystem::create_directory(folder / "designs");
  std::filesystem::copy_file(TENDRIL_SOURCE_DIR "/examples/designs/paper.toml",
                             folder / "designs/paper.toml");
  WriteText(folder / "small.toml", "name = \"small\"\nduration = " + duration +
                                       "\nlevel = \"fast\"\n[gripper]\ndesign = \"designs/paper.toml\"\n"
                                       "pull_rate = 0.2\ntentacles = 3\n[gripper.rod]\nelements = 30\n"
                                       "damping = 20\n[[object]]\nkind = \"capsule\"\nradius = 0.02\n"
                                       "length = 0.2\nposition = [0, 0, -0.15]\n");
  return folder / "small.toml";
}

TEST(SimulateCommand, ARunBecomesATrialFilmAndPicture) {
  const TemporaryFolder folder;
  const std::string scene = SmallGripper(folder, "0.5");
  const std::string lab = folder / "lab";
  ASSERT_EQ(RunProgram({"init", lab}).exit_code, 0);
  const ProgramRun run =
      RunProgram({"simulate", scene, "--lab", lab, "--label", "s1", "--fps", "8", "--video",
                  folder / "film.mp4", "--picture", folder / "end.png", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_EQ(json.at("trial"), "s1");
  EXPECT_GT(std::filesystem::file_size(folder / "film.mp4"), 1000u);
  EXPECT_GT(std::filesystem::file_size(folder / "end.png"), 1000u);
  const ProgramRun show = RunProgram({"trials", "list", "--lab", lab, "--kind", "simulated", "--json"});
  ASSERT_EQ(show.exit_code, 0) << show.err;
  EXPECT_NE(show.out.find("\"s1\""), std::string::npos) << show.out;
  EXPECT_EQ(RunProgram({"db", "check", "--lab", lab}).exit_code, 0);
  // The same label again is refused, and a scene without a gripper is no trial.
  EXPECT_EQ(RunProgram({"simulate", scene, "--lab", lab, "--label", "s1", "--fps", "8"}).exit_code, 2);
  EXPECT_EQ(RunProgram({"simulate", kScenes + "helix.toml", "--lab", lab}).exit_code, 2);
}

TEST(SimulateCommand, AStoppedRunGoesOnToTheSameBytes) {
  const TemporaryFolder folder;
#ifdef __SANITIZE_ADDRESS__  // many times slower
  const std::string scene = SmallGripper(folder, "3");
#else
  const std::string scene = SmallGripper(folder, "40");
#endif
  const std::string state = folder / "run.state";
  const std::vector<std::string> call{"simulate", scene, "--fps", "2", "--checkpoint", state};
  const auto with_out = [&](const std::string& out) {
    std::vector<std::string> all = call;
    all.insert(all.end(), {"--out", out});
    return all;
  };
  ASSERT_EQ(RunProgram({"simulate", scene, "--fps", "2", "--out", folder / "whole.csv"}).exit_code, 0);
  // Stopped over and over, each time a little later: a slow program has to start, too.
  std::string command = TENDRIL_PROGRAM;
  for (const std::string& word : with_out(folder / "parts.csv")) command += " " + word;
  command += " >/dev/null 2>&1";
  int stops = 0, code = 1;
  for (; stops < 100 && code != 0; ++stops) {
    const std::string time = std::to_string(0.2 + 0.05 * stops);
    code = std::system(("timeout -s INT " + time + " " + command).c_str());
  }
  EXPECT_EQ(code, 0);
  EXPECT_GT(stops, 1) << "it was never stopped";
  EXPECT_FALSE(std::filesystem::exists(state)) << "gone once the run is through";
  EXPECT_EQ(testing_support::ReadText(folder / "parts.csv"), testing_support::ReadText(folder / "whole.csv"));
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
  EXPECT_NE(message("[[rod]]\nclamp = \"none\"\n[rod.base_motion]\nuntil = 1\n").find("base_motion"),
            std::string::npos);
  EXPECT_NE(message("[[rod]]\nelements = 2\nrest_curvature = [0, 9, 0]\n").find("elements"),
            std::string::npos);
  EXPECT_EQ(RunProgram({"simulate", kScenes + "helix.toml", "--fps", "1e6"}).exit_code, 2);
  EXPECT_EQ(
      RunProgram({"simulate", kScenes + "helix.toml", "--level", "static", "--checkpoint", folder / "s"})
          .exit_code,
      2);
  EXPECT_EQ(RunProgram({"simulate", kScenes + "helix.toml", "--at", "99"}).exit_code, 2);
  EXPECT_EQ(RunProgram({"simulate", kScenes + "helix.toml", "--out", "curves.txt"}).exit_code, 2);
  EXPECT_EQ(RunProgram({"simulate", kScenes + "helix.toml", "--video", folder / "no/film.mp4"}).exit_code, 2);
  EXPECT_NE(message("level = \"static\"\n[[rod]]\nclamp = \"both\"\n").find("free tip"), std::string::npos);
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
