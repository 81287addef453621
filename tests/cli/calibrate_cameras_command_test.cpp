// tendril calibrate cameras: from drawn pictures to a rig file, the fields that programs rely on, and one
// line for what is wrong.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "capture/rig/rig.h"
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

  // Lenses that are known stay.
  const auto again = RunProgram({"calibrate", "cameras", "--board", "chessboard:9x6:0.03", "--camera",
                                 "left=" + folder / "left*.png", "--camera", "right=" + folder / "right*.png",
                                 "--lenses", folder / "rig.toml", "--folds", "0"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_THAT(again.out, HasSubstr("(given)"));
  EXPECT_THAT(again.out, HasSubstr("position_x_m"));
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
  EXPECT_EQ(empty.exit_code, 1);
  EXPECT_THAT(empty.err, HasSubstr("camera a shows 6 or more corners of the board in 0 pictures"));
}

}  // namespace
}  // namespace tendril
