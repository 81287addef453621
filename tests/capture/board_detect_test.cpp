// capture/track/board.h and board_detect.h, against drawn boards whose corners are known exactly, and real
// AprilGrids.
#include "capture/track/board_detect.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "tests/support/render_board.h"
#include "tests/support/shared_data.h"

namespace tendril {
namespace {

using testing_support::Picture;
using testing_support::RenderBoard;
using testing_support::SharedFolder;

Camera Looking() {
  Camera camera;
  camera.width_px = 400;
  camera.height_px = 300;
  camera.focal_x_px = camera.focal_y_px = 420;
  camera.center_x_px = 203.3;
  camera.center_y_px = 148.6;
  camera.distortion = Distortion::kBrown;
  camera.coefficients = {-0.2, 0.05, 0.001, -0.001, 0};
  return camera;
}

// The board's middle at a distance in front of the camera, turned.
Eigen::Isometry3d Placed(const Board& board, double distance, double tilt, double axis, double roll,
                         const Eigen::Vector2d& aside = Eigen::Vector2d::Zero()) {
  const Eigen::Matrix3Xd points = BoardPoints(board);
  const Eigen::Vector3d middle = 0.5 * (points.rowwise().minCoeff() + points.rowwise().maxCoeff());
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = (Eigen::AngleAxisd(tilt, Eigen::Vector3d(std::cos(axis), std::sin(axis), 0)) *
                   Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ()))
                      .toRotationMatrix();
  pose.translation() = Eigen::Vector3d(aside.x(), aside.y(), distance) - pose.linear() * middle;
  return pose;
}

struct Errors {
  int found = 0;
  double worst = 0;
  double sum2 = 0;
  Eigen::Vector2d bias = Eigen::Vector2d::Zero();
  double rms() const { return std::sqrt(sum2 / std::max(1, found)); }
};

Errors Measure(const Board& board, double distance, double tilt_limit, int pictures, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  const Camera camera = Looking();
  const Eigen::Matrix3Xd points = BoardPoints(board);
  Errors errors;
  for (int i = 0; i < pictures; ++i) {
    const Eigen::Isometry3d pose =
        Placed(board, distance * (1 + 0.1 * unit(random)), tilt_limit * unit(random), 6.28 * unit(random),
               6.28 * unit(random), {0.004 * unit(random), 0.004 * unit(random)});
    const auto bytes = RenderBoard(camera, pose, board, 0.7, 1.5, random).Bytes();
    const auto seen = DetectBoard({bytes.data(), 400, 300, 400}, board);
    EXPECT_TRUE(seen.ok());
    if (!seen.ok()) return errors;
    for (size_t k = 0; k < seen.value().ids.size(); ++k) {
      const auto truth = Project(camera, pose * Eigen::Vector3d(points.col(seen.value().ids[k])));
      const Eigen::Vector2d off = seen.value().pixels.col(static_cast<Eigen::Index>(k)) - *truth;
      ++errors.found;
      errors.bias += off;
      errors.sum2 += off.squaredNorm();
      errors.worst = std::max(errors.worst, off.norm());
    }
  }
  errors.bias /= std::max(1, errors.found);
  return errors;
}

// Half a pixel missed would show as a bias of 0.5; wrong numbers as errors of squares.
TEST(DetectBoard, AChessboardsCornersAreNumberedAndCountedFromThePixelsCentre) {
  const Board board = ParseBoard("chessboard:8x5:0.02").value();
  const Errors e = Measure(board, 0.27, 0.6, 12, 3);
  EXPECT_EQ(e.found, 12 * 40);
  EXPECT_LT(e.bias.cwiseAbs().maxCoeff(), 0.01) << e.bias.transpose();
  EXPECT_LT(e.rms(), 0.05);
  EXPECT_LT(e.worst, 0.3);
}

TEST(DetectBoard, AnAprilGridsCornersAreNumberedWithBordersOfOneAndTwoBits) {
  for (const std::string text : {"aprilgrid:4x3:0.03:0.3:1", "aprilgrid:4x3:0.03:0.3:2"}) {
    const Board board = ParseBoard(text).value();
    const Errors e = Measure(board, 0.30, 0.5, 8, 7);
    EXPECT_GE(e.found, 8 * 45) << text;
    EXPECT_LT(e.bias.cwiseAbs().maxCoeff(), 0.015) << text << ": " << e.bias.transpose();
    EXPECT_LT(e.rms(), 0.08) << text;
    EXPECT_LT(e.worst, 0.5) << text;
  }
}

// OpenCV draws the board; its print puts corner 0 one square in from the top left.
TEST(DetectBoard, ACharucoBoardIsSeenInParts) {
  const Board board = ParseBoard("charuco:7x5:0.04:0.03:4x4_50").value();
  const auto drawn = cv::aruco::CharucoBoard::create(
      7, 5, 0.04F, 0.03F, cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_50));
  cv::Mat picture;
  drawn->draw({560, 400}, picture, 0, 1);
  cv::copyMakeBorder(picture, picture, 40, 40, 40, 40, cv::BORDER_CONSTANT, 255);
  cv::GaussianBlur(picture, picture, {5, 5}, 0.8);
  const Eigen::Matrix3Xd points = BoardPoints(board);
  for (const int hidden : {0, 250}) {
    picture.colRange(0, hidden).setTo(200);
    const auto seen = DetectBoard({picture.data, 640, 480, static_cast<int>(picture.step)}, board);
    ASSERT_TRUE(seen.ok()) << seen.error().message;
    EXPECT_EQ(seen.value().ids.size(), hidden == 0 ? 24u : 12u);  // a corner needs both its markers
    for (size_t k = 0; k < seen.value().ids.size(); ++k) {
      const Eigen::Vector2d truth = 2000 * points.col(seen.value().ids[k]).head<2>().array() + 39.5;
      EXPECT_LT((seen.value().pixels.col(static_cast<Eigen::Index>(k)) - truth).norm(), 0.05);
    }
  }
}

TEST(DetectBoard, RealAprilGridsShowAsManyTagsAsAnotherDetectorFinds) {
  const std::filesystem::path folder = SharedFolder() / "data" / "aprilgrid";
  TENDRIL_SKIP_WITHOUT(folder);
  const std::map<std::string, size_t> tags{
      {"000.jpg", 36}, {"001.jpg", 36}, {"003.jpg", 36}, {"EuRoC.png", 26}, {"TUM_VI.png", 29}};
  const Board board = ParseBoard("aprilgrid:6x6:0.088:0.3:2").value();
  const Eigen::Matrix3Xd points = BoardPoints(board);
  for (const auto& [file, count] : tags) {
    const cv::Mat gray = cv::imread((folder / file).string(), cv::IMREAD_GRAYSCALE);
    ASSERT_FALSE(gray.empty());
    const auto seen = DetectBoard({gray.data, gray.cols, gray.rows, static_cast<int>(gray.step)}, board);
    ASSERT_TRUE(seen.ok()) << seen.error().message;
    std::set<int> ids;
    for (const int id : seen.value().ids) ids.insert(id / 4);
    EXPECT_EQ(ids.size(), count) << file;
    // Right numbers lie as the board says: within a tag's side of a homography, whatever the lens.
    std::vector<cv::Point2f> from;
    std::vector<cv::Point2f> to;
    for (size_t k = 0; k < seen.value().ids.size(); ++k) {
      const auto p = points.col(seen.value().ids[k]);
      const auto q = seen.value().pixels.col(static_cast<Eigen::Index>(k));
      from.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
      to.emplace_back(static_cast<float>(q.x()), static_cast<float>(q.y()));
    }
    const cv::Mat homography = cv::findHomography(from, to);
    std::vector<cv::Point2f> fitted;
    cv::perspectiveTransform(from, fitted, homography);
    double sum2 = 0;
    for (size_t k = 0; k < to.size(); ++k) sum2 += std::pow(cv::norm(fitted[k] - to[k]), 2);
    const double rms = std::sqrt(sum2 / static_cast<double>(to.size()));
    std::printf("%s: %zu tags, %zu corners, %.2f px from a homography\n", file.c_str(), ids.size(), to.size(),
                rms);
    EXPECT_LT(rms, file[0] == '0' ? 5 : 8) << file;
  }
}

TEST(DetectBoard, NothingIsSeenInAnEmptyPicture) {
  for (const std::string text : {"chessboard:9x6:0.025", "charuco:7x5:0.04:0.03", "aprilgrid:6x6:0.088:0.3:1",
                                 "aprilgrid:6x6:0.088:0.3:2"}) {
    for (const int size : {1, 31, 33, 200}) {
      const std::vector<unsigned char> gray(static_cast<size_t>(size * size), 128);
      const auto seen = DetectBoard({gray.data(), size, size, size}, ParseBoard(text).value());
      ASSERT_TRUE(seen.ok());
      EXPECT_TRUE(seen.value().ids.empty());
    }
  }
  EXPECT_EQ(DetectBoard({}, ParseBoard("chessboard:9x6:0.025").value()).error().kind, ErrorKind::kBadInput);
}

TEST(ParseBoard, WhatItWritesItReads) {
  for (const std::string text : {"chessboard:9x6:0.025", "charuco:7x5:0.04:0.03:5x5_100",
                                 "aprilgrid:6x6:0.088:0.3:1", "aprilgrid:6x6:0.088:0.3:2"}) {
    EXPECT_EQ(BoardText(ParseBoard(text).value()), text);
  }
}

TEST(ParseBoard, WhatIsNoBoardIsNamed) {
  for (const std::string text :
       {"", "chessboard", "chessboard:9x6", "chessboard:9x6:0", "chessboard:9x6:-1", "chessboard:9x6:nan",
        "chessboard:2x6:0.02", "chessboard:9:0.02", "chessboard:9x6:0.02:1", "chess:9x6:0.02",
        "charuco:7x5:0.04", "charuco:7x5:0.03:0.04", "charuco:7x5:0.04:0.03:9x9_50",
        "charuco:20x20:0.04:0.03:4x4_50", "aprilgrid:6x6:0.088", "aprilgrid:6x6:0.088:0.3:3",
        "aprilgrid:30x30:0.088:0.3", "aprilgrid:6x6:0.088:0"}) {
    const auto board = ParseBoard(text);
    ASSERT_FALSE(board.ok()) << text;
    EXPECT_EQ(board.error().kind, ErrorKind::kBadInput);
    EXPECT_THAT(board.error().message, testing::HasSubstr("expected")) << text;
  }
}

}  // namespace
}  // namespace tendril
