// tendril calibrate cameras: from drawn pictures to a rig file, the fields that programs rely on, and one
// line for what is wrong.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/imgcodecs.hpp>

#include "capture/record/video_file.h"
#include "capture/rig/rig.h"
#include "capture/track/tag_pose.h"
#include "db/files/recording_logs.h"
#include "tests/support/calibration_rig.h"
#include "tests/support/program.h"
#include "tests/support/render_board.h"

namespace tendril {
namespace {

using testing::HasSubstr;
using namespace testing_support;

TEST(CalibrateCamerasCommand, DrawnPicturesBecomeARigFile) {
  const TemporaryFolder folder;
  std::vector<Camera> truth = FourInARow(Distortion::kBrown);
  truth.resize(2);
  truth[0].name = "left";
  truth[1].name = "right";
  const Board board = ParseBoard("chessboard:9x6:0.03").value();
  std::mt19937 random(11);
  for (int i = 0; i < 8; ++i) {
    const Eigen::Isometry3d pose = ShownTo(truth, 0, BoardPoints(board), random);
    for (const Camera& camera : truth) {
      const Picture picture = RenderBoard(camera, pose, board, 0.7, 2, random, 4);
      auto bytes = picture.Bytes();
      // The right camera lost its third picture: numbers tell.
      if (camera.name == "right" && i == 2) continue;
      ASSERT_TRUE(cv::imwrite(folder / (camera.name + std::to_string(i) + ".png"),
                              cv::Mat(picture.height, picture.width, CV_8U, bytes.data())));
    }
  }
  const auto run = RunProgram({"calibrate", "cameras", "--board", "chessboard:9x6:0.03", "--camera",
                               "left=" + folder / "left*.png", "--camera", "right=" + folder / "right*.png",
                               "--out", folder / "rig.toml", "--report", folder / "map.png", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_LT(json["rms_px"].get<double>(), 0.12);
  EXPECT_LT(json["held_out_rms_px"].get<double>(), 0.15);
  EXPECT_EQ(json["stamps"], 8);
  EXPECT_EQ(json["views"], 15);
  ASSERT_EQ(json["cameras"].size(), 2u);
  EXPECT_EQ(json["cameras"][1]["name"], "right");
  EXPECT_EQ(json["cameras"][1]["parameters"].size(), 15u);
  EXPECT_EQ(json["cameras"][0]["parameters"][0]["name"], "focal_x_px");
  EXPECT_GT(json["cameras"][0]["parameters"][0]["standard_error"].get<double>(), 0);
  EXPECT_THAT(json["weaknesses"].dump(), HasSubstr("8 pictures of the board are few"));

  const auto rig = ReadRig(folder / "rig.toml");
  ASSERT_TRUE(rig.ok()) << rig.error().message;
  ASSERT_EQ(rig.value().cameras.size(), 2u);
  EXPECT_NEAR(rig.value().cameras[0].focal_x_px, truth[0].focal_x_px, 3);
  const Eigen::Vector3d position = rig.value().cameras[1].camera_from_lab.inverse().translation();
  EXPECT_LT((position - truth[1].camera_from_lab.inverse().translation()).norm(), 0.003);
  const cv::Mat map = cv::imread(folder / "map.png");
  EXPECT_GT(map.cols, 1000);

  // A board of other counts.
  const auto wrong = RunProgram({"calibrate", "cameras", "--board", "chessboard:10x7:0.03", "--camera",
                                 "left=" + folder / "left*.png"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_THAT(wrong.err, HasSubstr("chessboard:10x7:0.03: found in none of 8 pictures"));
  EXPECT_THAT(wrong.err, HasSubstr("inner corners across x down"));

  // Lenses that are known stay.
  const auto again = RunProgram({"calibrate", "cameras", "--board", "chessboard:9x6:0.03", "--camera",
                                 "left=" + folder / "left*.png", "--camera", "right=" + folder / "right*.png",
                                 "--lenses", folder / "rig.toml", "--folds", "0"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_THAT(again.out, HasSubstr("(given)"));
  EXPECT_THAT(again.out, HasSubstr("position_x_m"));
}

// A board shown eight times to two cameras, as lossless videos with their frame logs; the right camera lost
// its third frame.
struct ShownBoard {
  std::vector<Camera> cameras = FourInARow(Distortion::kBrown);
  std::vector<Eigen::Isometry3d> poses;

  explicit ShownBoard(const TemporaryFolder& folder) {
    cameras.resize(2);
    const Board board = ParseBoard("chessboard:9x6:0.03").value();
    std::mt19937 random(12);
    for (int i = 0; i < 8; ++i) poses.push_back(ShownTo(cameras, 0, BoardPoints(board), random));
    for (size_t c = 0; c < 2; ++c) {
      const std::string name = fmt::format("cam{}", c);
      auto video = VideoWriter::Open(folder / (name + ".mkv"), 640, 480);
      EXPECT_TRUE(video.ok());
      std::vector<FrameRow> log;
      for (int i = 0; i < 8; ++i) {
        if (c == 1 && i == 2) continue;
        const Picture picture =
            RenderBoard(cameras[c], poses[static_cast<size_t>(i)], board, 0.7, 2, random, 4);
        auto bytes = picture.Bytes();
        const cv::Mat image(picture.height, picture.width, CV_8U, bytes.data());
        EXPECT_TRUE(video.value().Write(image, i).ok());
        const std::int64_t ns = 1'000'000'000LL * (i + 1) + (c == 1 ? 20'000'000 : 0);
        log.push_back(
            {.frame = static_cast<std::int64_t>(log.size()), .frame_id = i, .device_ns = ns, .host_ns = ns});
      }
      EXPECT_TRUE(video.value().Close().ok());
      EXPECT_TRUE(WriteFrameLog(folder / (name + ".csv"), log).ok());
    }
  }
};

TEST(CalibrateCamerasCommand, VideosArePairedByTheirClocksAndABoardSaysWhereTheLabIs) {
  const TemporaryFolder folder;
  const ShownBoard shown(folder);
  const std::vector<std::string> call{"calibrate",        "cameras",
                                      "--board",          "chessboard:9x6:0.03",
                                      "--camera",         "left=" + folder / "cam0.mkv",
                                      "--camera",         "right=" + folder / "cam1.mkv",
                                      "--folds",          "0",
                                      "--json",           "--out",
                                      folder / "rig.toml"};
  auto placed = call;
  placed.insert(placed.end(), {"--lab-board", "3", "--lab-place", "0.1", "-0.2", "0.5"});
  const auto run = RunProgram(placed);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_LT(json["rms_px"].get<double>(), 0.12);
  EXPECT_THAT(json["warnings"].dump(),
              HasSubstr("paired by the clock: 7 of 8 are in camera left and another, at "
                        "most 20.00 ms apart"));
  const auto rig = ReadRig(folder / "rig.toml");
  ASSERT_TRUE(rig.ok()) << rig.error().message;
  // In the lab that was asked for, the fourth board's x points along x and its face up.
  Eigen::Isometry3d lab_from_board = Eigen::Isometry3d::Identity();
  lab_from_board.linear() = Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()).toRotationMatrix();
  lab_from_board.translation() << 0.1, -0.2, 0.5;
  for (size_t c = 0; c < 2; ++c) {
    const Eigen::Isometry3d truth =
        lab_from_board * shown.poses[3].inverse() * shown.cameras[c].camera_from_lab.inverse();
    const Eigen::Isometry3d found = rig.value().cameras[c].camera_from_lab.inverse();
    EXPECT_LT((found.translation() - truth.translation()).norm(), 0.006);
    EXPECT_LT(Eigen::AngleAxisd(found.linear() * truth.linear().transpose()).angle(), 0.006);
    EXPECT_GT(found.translation().z(), 0.5);  // cameras look at the board's face from above
  }

  const auto nowhere = [&] {
    auto asked = call;
    asked.insert(asked.end(), {"--lab-board", "77"});
    return RunProgram(asked);
  }();
  EXPECT_EQ(nowhere.exit_code, 2);
  EXPECT_THAT(nowhere.err, HasSubstr("the board's in picture 77, but no camera saw it there"));

  const auto skipped = [&] {
    auto asked = call;
    asked.insert(asked.end(), {"--lab-board", "3", "--every", "2"});
    return RunProgram(asked);
  }();
  EXPECT_EQ(skipped.exit_code, 2);
  EXPECT_THAT(skipped.err, HasSubstr("--lab-board 3 is not looked at with --every 2"));

  // By number alone frames of different moments come together.
  std::filesystem::remove(folder / "cam1.csv");
  const auto numbered = RunProgram(call);
  EXPECT_THAT(numbered.err, HasSubstr("frames are paired by their number"));
  EXPECT_TRUE(numbered.exit_code == 1 || nlohmann::json::parse(numbered.out)["rms_px"].get<double>() > 1);
}

// Two cameras' recorded tags on a sheet that is shown in 12 poses, each for so many frames of 10 ms, and the
// lenses; camera 1 is late by `late_ns` and lost frame 5.
void RecordTags(const TemporaryFolder& folder, const std::vector<Camera>& truth, int held,
                std::int64_t late_ns) {
  const Eigen::Matrix3Xd tag = TagCorners3d(0.1);
  std::mt19937 random(13);
  std::normal_distribution<double> noise(0, 0.05);
  std::vector<DetectionRow> rows;
  std::vector<FrameRow> logs[2];
  Eigen::Isometry3d beside = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 12 * held; ++i) {
    if (i % held == 0) beside = ShownTo(truth, 0, Points(), random);
    for (int c = 0; c < 2; ++c) {
      if (c == 1 && i == 5) continue;  // lost
      auto& log = logs[c];
      const std::int64_t ns = 10'000'000LL * (i + 1) + c * late_ns;
      for (int t = 0; t < 2; ++t) {
        DetectionRow row;
        row.frame = static_cast<std::int64_t>(log.size());
        row.camera = c;
        row.tag = 7 + t;
        for (int k = 0; k < 4; ++k) {
          const Eigen::Vector3d on_sheet = tag.col(k) + Eigen::Vector3d(0.05 + 0.13 * t, 0.07, 0);
          row.corners_px.col(k) = Project(truth[static_cast<size_t>(c)], beside * on_sheet).value() +
                                  Eigen::Vector2d(noise(random), noise(random));
        }
        rows.push_back(row);
      }
      log.push_back(
          {.frame = static_cast<std::int64_t>(log.size()), .frame_id = i, .device_ns = ns, .host_ns = ns});
    }
  }
  ASSERT_TRUE(WriteDetections(folder / "detections.csv", rows).ok());
  for (int c = 0; c < 2; ++c) ASSERT_TRUE(WriteFrameLog(folder / fmt::format("cam{}.csv", c), logs[c]).ok());
  Rig lenses;
  lenses.name = "lenses";
  lenses.cameras = truth;
  for (Camera& camera : lenses.cameras) camera.camera_from_lab.setIdentity();
  WriteText(folder / "lenses.toml", RigToml(lenses));
}

TEST(CalibrateCamerasCommand, RecordedTagsBecomeARigFile) {
  const TemporaryFolder folder;
  std::vector<Camera> truth = FourInARow(Distortion::kBrown);
  truth.resize(2);
  RecordTags(folder, truth, 1, 0);
  const auto run =
      RunProgram({"calibrate", "cameras", "--tags", folder / "detections.csv", "--tag-size", "0.1",
                  "--lenses", folder / "lenses.toml", "--out", folder / "rig.toml", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_LT(json["rms_px"].get<double>(), 0.1);
  ASSERT_EQ(json["tags"].size(), 2u);
  const auto& second = json["tags"][1]["corners_m"][0];
  EXPECT_EQ(json["tags"][1]["tag"], 8);
  EXPECT_NEAR(second[0].get<double>(), TagCorners3d(0.1)(0, 0) + 0.13, 0.001);
  const auto rig = ReadRig(folder / "rig.toml");
  ASSERT_TRUE(rig.ok()) << rig.error().message;
  const Eigen::Vector3d position = rig.value().cameras[1].camera_from_lab.inverse().translation();
  EXPECT_LT((position - truth[1].camera_from_lab.inverse().translation()).norm(), 0.004);
}

TEST(CalibrateCamerasCommand, CamerasInOppositePhaseAreLinkedByStillTags) {
  const TemporaryFolder folder;
  std::vector<Camera> truth = FourInARow(Distortion::kBrown);
  truth.resize(2);
  RecordTags(folder, truth, 4, 5'000'000);
  std::vector<std::string> call{"calibrate",  "cameras",
                                "--tags",     folder / "detections.csv",
                                "--tag-size", "0.1",
                                "--lenses",   folder / "lenses.toml",
                                "--out",      folder / "rig.toml"};
  const auto apart = RunProgram(call);  // as if triggered: nothing belongs together
  EXPECT_EQ(apart.exit_code, 1) << apart.out;
  call.insert(call.end(), {"--still", "2.5"});
  const auto run = RunProgram(call);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto rig = ReadRig(folder / "rig.toml");
  ASSERT_TRUE(rig.ok()) << rig.error().message;
  const Eigen::Vector3d position = rig.value().cameras[1].camera_from_lab.inverse().translation();
  EXPECT_LT((position - truth[1].camera_from_lab.inverse().translation()).norm(), 0.004);
}

TEST(CalibrateCamerasCommand, BadInputIsOneLineAndExitTwo) {
  const TemporaryFolder folder;
  WriteText(folder / "text.png", "no picture");
  WriteText(folder / "text.mkv", "no video");
  const cv::Mat blank(48, 64, CV_8U, cv::Scalar(128));
  const cv::Mat wider(48, 80, CV_8U, cv::Scalar(128));
  ASSERT_TRUE(cv::imwrite(folder / "a1.png", blank) && cv::imwrite(folder / "a2.png", wider));
  ASSERT_TRUE(cv::imwrite(folder / "x.png", blank) && cv::imwrite(folder / "y.png", blank));
  const std::string board = "chessboard:9x6:0.025";
  const std::vector<std::vector<std::string>> bad = {
      {"--board", "chess:9x6:0.025", "--camera", "a=" + folder / "a1.png"},
      {"--board", board, "--camera", folder / "a1.png"},
      {"--board", board, "--camera", "a=" + folder / "none*.png"},
      {"--board", board, "--camera", "a=" + folder / "none.png"},
      {"--board", board, "--camera", "a=" + folder / "text.png"},
      {"--board", board, "--camera", "a=" + folder / "text.mkv"},
      {"--board", board, "--camera", "a=" + folder / "a?.png"},  // sizes differ
      {"--board", board, "--camera", "a=" + folder / "x.png", "--camera", "b=" + folder / "a1.png",
       "--camera", "b=" + folder / "y.png"},  // no numbers, unequal counts
      {"--board", board, "--camera", "a=" + folder / "a1.png", "--lenses", folder / "none.toml"},
      {"--board", board, "--camera", "a=" + folder / "a1.png", "--model", "magic"},
      {"--board", board},
      {"--board", board, "--camera", "a=" + folder / "a1.png", "--lab-place", "0", "0", "1"},
      {"--tags", folder / "none.csv", "--tag-size", "0.1"},
  };
  for (const auto& options : bad) {
    std::vector<std::string> call{"calibrate", "cameras", "--json"};
    call.insert(call.end(), options.begin(), options.end());
    const auto run = RunProgram(call);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    std::string errors;
    for (size_t at = 0; (at = run.err.find("error:", at)) != std::string::npos; ++at) errors += "!";
    EXPECT_EQ(errors, "!") << run.err;
  }
  const auto empty =
      RunProgram({"calibrate", "cameras", "--board", board, "--camera", "a=" + folder / "a1.png"});
  EXPECT_EQ(empty.exit_code, 2);
  EXPECT_THAT(empty.err, HasSubstr("--board " + std::string(board) + ": found in none of 1 pictures"));
}

}  // namespace
}  // namespace tendril
