// tendril trials import: a made-up limb with a known bend, its loop in tendril plot curvature, and what is
// refused without leaving anything behind.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/support/program.h"

namespace tendril {
namespace {

using testing_support::RunProgram;
using testing_support::TemporaryFolder;
using testing_support::WriteText;

constexpr char kDetectionsHeader[] = "camera,frame,tag,hamming,margin,x0,y0,x1,y1,x2,y2,x3,y3\n";
constexpr char kFramesHeader[] = "frame,frame_id,device_ns,host_ns,status,dropped_before\n";
constexpr long long kStart = 1'700'000'000'000'000'000;

// Five tags 50 px apart on an arc that turns by 0.2 rad per frame; tag 3 is missing in frame 2.
void WriteLimb(const TemporaryFolder& folder) {
  std::string detections = kDetectionsHeader;
  std::string frames = kFramesHeader;
  std::string servo = "host_ns,device_ms,servo,command,position_deg,current_mA,voltage_V,temperature_degC\n";
  for (int f = 0; f < 4; ++f) {
    const std::string ns = std::to_string(kStart + f * 100'000'000LL);
    frames += std::to_string(f) + "," + std::to_string(f) + "," + ns + "," + ns + ",ok,0\n";
    servo += ns + ",,0," + std::to_string(0.1 * f) + ",,,,\n";
    double x = 100;
    double y = 300;
    for (int i = 0; i < 5; ++i) {
      if (f != 2 || i != 2) {
        detections += "0," + std::to_string(f) + "," + std::to_string(i + 1) + ",0,50";
        for (int c = 0; c < 4; ++c) detections += "," + std::to_string(x) + "," + std::to_string(y);
        detections += "\n";
      }
      x += 50 * std::cos(0.2 * f * i / 3.0);
      y -= 50 * std::sin(0.2 * f * i / 3.0);
    }
  }
  WriteText(folder / "detections.csv", detections);
  WriteText(folder / "frames.csv", frames);
  WriteText(folder / "servo.csv", servo);
}

std::vector<std::string> Import(const TemporaryFolder& folder, std::vector<std::string> more) {
  std::vector<std::string> call = {"trials",       "import",
                                   "--lab",        folder / "lab",
                                   "--label",      "limb",
                                   "--detections", folder / "detections.csv",
                                   "--frames",     folder / "frames.csv",
                                   "--servo",      folder / "servo.csv",
                                   "--json"};
  call.insert(call.end(), more.begin(), more.end());
  return call;
}

TEST(TrialsImport, AKnownBendComesBack) {
  const TemporaryFolder folder;
  WriteLimb(folder);
  ASSERT_EQ(RunProgram({"init", folder / "lab"}).exit_code, 0);
  const auto run = RunProgram(Import(folder, {"--chain", "1,2,3,4,5", "--spacing-mm", "20"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_EQ(json["frames"], 4);
  EXPECT_EQ(json["complete_frames"], 3);
  EXPECT_NEAR(json["seen_fraction"].get<double>(), 19.0 / 20, 1e-12);
  EXPECT_NEAR(json["scale_mm_per_px"].get<double>(), 0.4, 1e-6);
  EXPECT_NEAR(json["tip_angle_deg"][1].get<double>(), 0.6 * 180 / M_PI, 1e-4);
  EXPECT_NEAR(json["mean_curvature_per_m"][1].get<double>(), 0.6 / (3 * 0.020), 1e-4);
  const std::filesystem::path trial = json["folder"].get<std::string>();
  for (const char* name :
       {"detections.csv", "cam0.csv", "servo.csv", "curves.h5", "metrics.csv", "trial.toml"}) {
    EXPECT_TRUE(std::filesystem::exists(trial / name)) << name;
  }
  EXPECT_THAT(testing_support::ReadText(trial / "metrics.csv"), testing::HasSubstr("\n2,0.2,,,4\n"));
  const auto shown = RunProgram({"trials", "show", "limb", "--lab", folder / "lab", "--json"});
  ASSERT_EQ(shown.exit_code, 0) << shown.err;
  EXPECT_THAT(shown.out, testing::HasSubstr("\"recorded\""));
  EXPECT_EQ(RunProgram(Import(folder, {})).exit_code, 2);  // the label is taken
}

// Commands up to 0.8 and back in steps of 0.1, twice; the limb bends by 1 rad per command and 0.1 less on the
// way up.
TEST(PlotCurvature, TellsTheLoopOfALimbThatFollowsLate) {
  const TemporaryFolder folder;
  std::string detections = kDetectionsHeader;
  std::string frames = kFramesHeader;
  std::string servo = "host_ns,device_ms,servo,command,position_deg,current_mA,voltage_V,temperature_degC\n";
  for (int f = 0; f < 33; ++f) {
    const int step = f % 16;
    const double command = 0.1 * (step <= 8 ? step : 16 - step);
    const bool rises = f > 0 && (step > 0 && step <= 8);
    const double turn = 0.2 + command - (rises ? 0.1 : 0);
    const std::string ns = std::to_string(kStart + f * 100'000'000LL);
    frames += std::to_string(f) + "," + std::to_string(f) + "," + ns + "," + ns + ",ok,0\n";
    servo += ns + ",,0," + std::to_string(command) + ",,,,\n";
    double x = 100;
    double y = 300;
    for (int i = 0; i < 5; ++i) {
      detections += "0," + std::to_string(f) + "," + std::to_string(i + 1) + ",0,50";
      for (int c = 0; c < 4; ++c) detections += "," + std::to_string(x) + "," + std::to_string(y);
      detections += "\n";
      x += 50 * std::cos(turn * i / 3.0);
      y -= 50 * std::sin(turn * i / 3.0);
    }
  }
  WriteText(folder / "detections.csv", detections);
  WriteText(folder / "frames.csv", frames);
  WriteText(folder / "servo.csv", servo);
  ASSERT_EQ(RunProgram({"init", folder / "lab"}).exit_code, 0);
  const auto made = RunProgram(Import(folder, {"--chain", "1,2,3,4,5", "--spacing-mm", "20"}));
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const std::filesystem::path trial = nlohmann::json::parse(made.out)["folder"].get<std::string>();
  const auto plot = [&](std::vector<std::string> more) {
    std::vector<std::string> call = {
        "plot",  "curvature",        trial / "curves.h5", "--servo", trial / "servo.csv",
        "--out", folder / "loop.svg"};
    call.insert(call.end(), more.begin(), more.end());
    return RunProgram(call);
  };
  const auto run = plot({"--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(std::filesystem::exists(folder / "loop.svg"));
  const auto answer = nlohmann::json::parse(run.out)["curves"][0];
  EXPECT_EQ(answer["frames_known"], 33);
  EXPECT_GT(answer["median_sigma_per_m"].get<double>(), 0);
  const auto& loop = answer["hysteresis"];
  EXPECT_EQ(loop["cycles"].size(), 2u);
  EXPECT_NEAR(loop["width_per_m"].get<double>(), -0.1 / (3 * 0.020), 1e-3);
  EXPECT_LT(loop["standard_error_per_m"].get<double>(), 1e-3);
  const auto words = plot({});
  EXPECT_THAT(words.out, testing::HasSubstr("rising less falling is -1.667 1/m"));
  EXPECT_EQ(plot({"--nodes", "0,3"}).exit_code, 0);
  for (const std::vector<std::string>& bad :
       {std::vector<std::string>{"--nodes", "3,4"}, {"--nodes", "0,5"}, {"--servo-number", "7"}}) {
    const auto refused = plot(bad);
    EXPECT_EQ(refused.exit_code, 2) << bad[0];
    EXPECT_THAT(refused.err, testing::HasSubstr(bad[0]));
    EXPECT_EQ(std::count(refused.err.begin(), refused.err.end(), '\n'), 1) << refused.err;
  }
}

TEST(TrialsImport, BadInputLeavesNothingBehind) {
  const TemporaryFolder folder;
  WriteLimb(folder);
  ASSERT_EQ(RunProgram({"init", folder / "lab"}).exit_code, 0);
  const std::vector<std::vector<std::string>> bad = {
      {"--chain", "1,2,3"},                                                  // no scale
      {"--chain", "1,2,3", "--spacing-mm", "20", "--scale-mm-per-px", "1"},  // two
      {"--chain", "1", "--spacing-mm", "20"},                                // one tag is no chain
      {"--chain", "7,8", "--spacing-mm", "20"},                              // never seen
      {"--chain", "1,2", "--spacing-mm", "-3"},
      {"--chain", "1,2", "--rig", "no-such.toml"},
  };
  for (const auto& more : bad) {
    const auto run = RunProgram(Import(folder, more));
    EXPECT_EQ(run.exit_code, 2) << more[1];
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  }
  WriteText(folder / "detections.csv", std::string(kDetectionsHeader) + "0,0,1,0,fifty,1,1,2,2,3,3,4,4\n");
  const auto run = RunProgram(Import(folder, {}));
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, testing::HasSubstr("detections.csv:2"));
  EXPECT_TRUE(std::filesystem::is_empty(std::filesystem::path(folder / "lab") / "trials"));
}

}  // namespace
}  // namespace tendril
