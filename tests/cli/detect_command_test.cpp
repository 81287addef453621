// tendril detect: the fields that programs rely on, and one line for what is wrong.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "tests/support/program.h"
#include "tests/support/render_tag.h"

namespace tendril {
namespace {

using testing_support::RunProgram;
using testing_support::TemporaryFolder;

TEST(DetectCommand, AnswersIdsAndCorners) {
  const TemporaryFolder folder;
  testing_support::Picture picture(200, 150, 210);
  const Eigen::Matrix<double, 2, 4> truth = testing_support::TiltedCorners({90, 70}, 60, 0.4, 0.7, 0.3);
  testing_support::DrawTag(picture, PatternOf("tag36h11", 42).value(), 8, truth);
  testing_support::Blur(picture, 0.6);
  auto bytes = picture.Bytes();
  ASSERT_TRUE(cv::imwrite(folder / "a.png", cv::Mat(150, 200, CV_8U, bytes.data())));
  const auto run = RunProgram({"detect", folder / "a.png", "--json", "--overlay", folder / "o.png"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  ASSERT_EQ(json["images"].size(), 1u);
  EXPECT_EQ(json["images"][0]["file"], folder / "a.png");
  ASSERT_EQ(json["images"][0]["tags"].size(), 1u);
  const auto& tag = json["images"][0]["tags"][0];
  EXPECT_EQ(tag["id"], 42);
  ASSERT_EQ(tag["corners_px"].size(), 4u);
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(tag["corners_px"][static_cast<size_t>(i)][0].get<double>(), truth(0, i), 0.05);
    EXPECT_NEAR(tag["corners_px"][static_cast<size_t>(i)][1].get<double>(), truth(1, i), 0.05);
  }
  const cv::Mat overlay = cv::imread(folder / "o.png");
  EXPECT_EQ(overlay.cols, 200);
}

TEST(DetectCommand, BadInputIsOneLineAndExitTwo) {
  const TemporaryFolder folder;
  testing_support::WriteText(folder / "text.png", "no picture");
  const std::vector<std::vector<std::string>> bad = {
      {"detect", folder / "none.png"},
      {"detect", folder / "text.png"},
      {"detect", folder / "text.png", "--family", "tag9"},
      {"detect", folder / "text.png", "--decimate", "0"},
      {"detect", folder / "text.png", folder / "text.png", "--overlay", "o.png"},
  };
  for (const auto& call : bad) {
    const auto run = RunProgram(call);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_EQ(run.out, "");
  }
}

}  // namespace
}  // namespace tendril
