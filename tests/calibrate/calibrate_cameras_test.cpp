// calibrate/cameras: made-up rigs come back exactly without noise and within their intervals with it, weak
// data are told in words, and real chessboards are met better than OpenCV meets them.
#include "calibrate/cameras/calibrate_cameras.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/track/board.h"
#include "tests/support/calibration_rig.h"

namespace tendril {
namespace {

using namespace testing_support;
using testing::HasSubstr;

TEST(CalibrateCameras, AChainOfFourComesBackExactlyWithoutNoise) {
  for (const Distortion lens : {Distortion::kBrown, Distortion::kEquidistant, Distortion::kNone}) {
    std::vector<Camera> truth = FourInARow(lens);
    if (lens == Distortion::kNone) {
      for (Camera& c : truth) c.coefficients = {};
    }
    std::mt19937 random(3);
    const auto fit = CalibrateCameras(Unknown(truth), ChainedViews(truth, Points(), 10, 0, random), Points());
    ASSERT_TRUE(fit.ok()) << fit.error().message;
    EXPECT_LT(fit.value().rms_px, 1e-6);
    EXPECT_LT(fit.value().held_out_rms_px, 1e-5);
    for (size_t c = 0; c < 4; ++c) {
      const Camera& found = fit.value().cameras[c];
      EXPECT_NEAR(found.focal_x_px, truth[c].focal_x_px, 1e-4);
      EXPECT_NEAR(found.center_y_px, truth[c].center_y_px, 1e-4);
      EXPECT_LT((found.camera_from_lab.matrix() - truth[c].camera_from_lab.matrix()).norm(), 1e-6);
    }
  }
}

TEST(CalibrateCameras, AFewWrongCornersDoLittle) {
  const std::vector<Camera> truth = FourInARow(Distortion::kBrown);
  std::mt19937 random(8);
  std::vector<BoardView> views = ChainedViews(truth, Points(), 10, 0.1, random);
  for (size_t i = 0; i < views.size(); i += 3)
    views[i].corners.pixels.col(static_cast<Eigen::Index>(i % 54)).array() += 8;
  const auto fit = CalibrateCameras(Unknown(truth), views, Points(), {.folds = 0});
  ASSERT_TRUE(fit.ok()) << fit.error().message;
  EXPECT_NEAR(fit.value().reports[1].sigma_px, 0.1, 0.01);
  for (size_t c = 0; c < 4; ++c) {
    const CalibratedParameter& focal = fit.value().reports[c].parameters[0];
    EXPECT_LT(std::abs(focal.value - truth[c].focal_x_px), 4.5 * focal.standard_error);
    EXPECT_NEAR(focal.value, truth[c].focal_x_px, 3);
  }
}

TEST(CalibrateCameras, ABentBoardIsFoundWithItsShape) {
  const std::vector<Camera> truth = FourInARow(Distortion::kBrown);
  Eigen::Matrix3Xd bent = Points();
  for (Eigen::Index k = 0; k < bent.cols(); ++k) {
    bent(2, k) = 0.001 * std::pow((bent(0, k) - 0.12) / 0.12, 2);  // 1 mm at the ends
  }
  std::mt19937 random(4);
  const auto views = ChainedViews(truth, bent, 12, 0.1, random);
  const auto flat = CalibrateCameras(Unknown(truth), views, Points());
  const auto fit = CalibrateCameras(Unknown(truth), views, Points(), {.board_sigma = 0.001});
  ASSERT_TRUE(flat.ok() && fit.ok());
  EXPECT_LT(fit.value().rms_px, 0.15);
  EXPECT_GT(flat.value().rms_px, 1.2 * fit.value().rms_px);
  EXPECT_LT(fit.value().held_out_rms_px, 0.9 * flat.value().held_out_rms_px);
  // The shape up to where the board is: the bend about a plane.
  const auto height = [](const Eigen::Matrix3Xd& p) {
    Eigen::MatrixXd plane(p.cols(), 3);
    plane << Eigen::VectorXd::Ones(p.cols()), p.row(0).transpose(), p.row(1).transpose();
    const Eigen::VectorXd z = p.row(2).transpose();
    return Eigen::VectorXd(z - plane * plane.colPivHouseholderQr().solve(z));
  };
  const Eigen::VectorXd off = height(fit.value().points) - height(bent);
  EXPECT_LT(std::sqrt(off.squaredNorm() / static_cast<double>(off.size())), 0.0001);
}

bool Says(const CameraCalibration& fit, const std::string& what) {
  return std::any_of(fit.weaknesses.begin(), fit.weaknesses.end(),
                     [&](const std::string& s) { return s.find(what) != std::string::npos; });
}

TEST(CalibrateCameras, AFrontalBoardInOneCornerIsSaid) {
  const std::vector<Camera> truth{FourInARow(Distortion::kNone)[0]};
  std::vector<Camera> straight = truth;
  straight[0].coefficients = {};
  straight[0].camera_from_lab.setIdentity();
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::normal_distribution<double> noise(0, 0.1);
  std::vector<BoardView> views;
  for (int i = 0; i < 6; ++i) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = Eigen::AngleAxisd(0.05 * unit(random), Eigen::Vector3d::UnitX()).toRotationMatrix();
    pose.translation() = Eigen::Vector3d(-0.3 + 0.02 * unit(random), -0.25 + 0.02 * unit(random), 0.8);
    const auto seen = WholeBoard(straight[0], pose, Points());
    ASSERT_TRUE(seen);
    views.push_back({i, 0, 0, *seen});
    for (double& value : views.back().corners.pixels.reshaped()) value += noise(random);
  }
  const auto fit = CalibrateCameras(Unknown(straight), views, Points());
  ASSERT_TRUE(fit.ok()) << fit.error().message;
  EXPECT_TRUE(Says(fit.value(), "always frontal"));
  EXPECT_TRUE(Says(fit.value(), "6 pictures of the board are few"));
  EXPECT_TRUE(Says(fit.value(), "bottom right")) << testing::PrintToString(fit.value().weaknesses);
  EXPECT_TRUE(Says(fit.value(), "focal length and distance"));
}

TEST(CalibrateCameras, GoodDataAreNotCalledWeak) {
  std::vector<Camera> truth = FourInARow(Distortion::kBrown);
  truth.resize(2);
  std::mt19937 random(6);
  auto views = ChainedViews(truth, Points(), 40, 0.1, random);
  const auto fit = CalibrateCameras(Unknown(truth), views, Points());
  ASSERT_TRUE(fit.ok()) << fit.error().message;
  for (const std::string& sentence : fit.value().weaknesses) {
    EXPECT_THAT(sentence, HasSubstr("no corner of the board was seen"));  // neighbours share half a picture
  }
  EXPECT_GT(fit.value().refit_ratio, 0.6);
  EXPECT_LT(fit.value().refit_ratio, 1.5);
}

TEST(CalibrateCameras, CamerasThatAreNotLinkedAreNamed) {
  const std::vector<Camera> truth = FourInARow(Distortion::kBrown);
  std::mt19937 random(7);
  std::vector<BoardView> views = ChainedViews(truth, Points(), 8, 0.1, random);
  for (BoardView& view : views) {
    if (view.camera >= 2) view.stamp += 1000;  // another clock
  }
  const auto fit = CalibrateCameras(Unknown(truth), views, Points());
  ASSERT_FALSE(fit.ok());
  EXPECT_EQ(fit.error().kind, ErrorKind::kUnreachable);
  EXPECT_THAT(fit.error().message,
              HasSubstr("cam2, cam3 never see the board at a moment when cam0, cam1 see"));
}

TEST(CalibrateCameras, WhatCannotBeIsRefused) {
  const std::vector<Camera> truth = FourInARow(Distortion::kBrown);
  std::mt19937 random(7);
  const std::vector<BoardView> views = ChainedViews(truth, Points(), 3, 0.1, random);
  const auto kind = [&](const auto& cameras, const auto& seen, const CalibrateCamerasOptions& options = {}) {
    const auto fit = CalibrateCameras(cameras, seen, Points(), options);
    return fit.ok() ? ErrorKind::kIo : fit.error().kind;
  };
  EXPECT_EQ(kind(std::vector<Camera>{}, views), ErrorKind::kBadInput);
  EXPECT_EQ(kind(Unknown(truth), std::vector<BoardView>{}), ErrorKind::kUnreachable);
  EXPECT_EQ(kind(std::vector<Camera>(2, Unknown(truth)[0]), views), ErrorKind::kBadInput);
  EXPECT_EQ(kind(Unknown(truth), views, {.board_sigma = -1}), ErrorKind::kBadInput);
  EXPECT_EQ(kind(Unknown(truth), views, {.confidence = 1}), ErrorKind::kBadInput);
  std::vector<BoardView> wrong = views;
  wrong[0].corners.ids[3] = 54;
  EXPECT_EQ(kind(Unknown(truth), wrong), ErrorKind::kBadInput);
  wrong = views;
  wrong[0].corners.pixels(0, 0) = NAN;
  EXPECT_EQ(kind(Unknown(truth), wrong), ErrorKind::kBadInput);
  const auto few = CalibrateCameras(Unknown(truth), {views[0], views[1]}, Points());
  ASSERT_FALSE(few.ok());
  EXPECT_THAT(few.error().message,
              HasSubstr("camera cam0 shows 6 or more corners of the board in 1 pictures"));
}

}  // namespace
}  // namespace tendril
