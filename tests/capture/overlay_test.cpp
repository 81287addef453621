// capture/track/overlay.h: what is drawn where, on a picture whose content is known.
#include "capture/track/overlay.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/synthetic_view.h"

namespace tendril {
namespace {

CurveSeries StraightDown(double sigma, int interpolated) {
  CurveSeries series;
  series.name = "tentacle0";
  series.time = Eigen::VectorXd::Zero(1);
  FramedCurve curve;
  curve.points.resize(3, 5);
  for (int i = 0; i < 5; ++i) curve.points.col(i) = Eigen::Vector3d(0.12, 0, -0.2 - 0.05 * i);
  series.curves = {curve};
  series.sigma = {Eigen::VectorXd::Constant(5, sigma)};
  series.interpolated = {Eigen::VectorXi::Constant(5, interpolated)};
  return series;
}

cv::Vec3b ColorAt(const Camera& camera, const Eigen::Vector3d& in_lab, const cv::Mat& picture) {
  const Eigen::Vector2d pixel = Project(camera, in_lab).value() / 2;
  return picture.at<cv::Vec3b>(static_cast<int>(pixel.y()), static_cast<int>(pixel.x()));
}

TEST(DrawOverlay, NodesHaveTheColorOfWhatIsKnownOfThem) {
  const Camera camera = testing_support::CamerasAround(1).front();
  const cv::Mat gray(camera.height_px, camera.width_px, CV_8UC1, cv::Scalar(100));
  const Eigen::Vector3d node(0.12, 0, -0.3);
  const cv::Mat seen = DrawOverlay(camera, gray, {}, {}, {StraightDown(1e-4, 0)}, 0, 0.5);
  const cv::Mat bridged = DrawOverlay(camera, gray, {}, {}, {StraightDown(1e-4, 1)}, 0, 0.5);
  EXPECT_EQ(seen.size(), cv::Size(camera.width_px / 2, camera.height_px / 2));
  EXPECT_GT(ColorAt(camera, node, seen)[0], 200);     // blue
  EXPECT_GT(ColorAt(camera, node, bridged)[2], 200);  // orange
  EXPECT_LT(ColorAt(camera, node, bridged)[0], 50);
  // The rest is the picture, a little darker.
  EXPECT_EQ(seen.at<cv::Vec3b>(5, 5), cv::Vec3b(70, 70, 70));
}

TEST(DrawOverlay, WithoutPictureSigmaOrCurvesItStillDraws) {
  const Camera camera = testing_support::CamerasAround(1).front();
  CurveSeries bare = StraightDown(std::numeric_limits<double>::quiet_NaN(), 1);
  EXPECT_FALSE(DrawOverlay(camera, {}, {}, {}, {bare}, 0, 1).empty());
  bare.sigma.clear();
  bare.interpolated.clear();
  EXPECT_FALSE(DrawOverlay(camera, {}, {}, {}, {bare}, 0, 0.3).empty());
  EXPECT_FALSE(DrawOverlay(camera, {}, {}, {}, {}, 0, 0.3).empty());
}

TEST(WriteOverlay, AFolderWithoutATrialIsSaidInOneLine) {
  const Result<OverlayFiles> files = WriteOverlay("/nonexistent/trial");
  ASSERT_FALSE(files.ok());
  EXPECT_EQ(files.error().kind, ErrorKind::kNotFound);
  EXPECT_EQ(files.error().message.find('\n'), std::string::npos);
}

}  // namespace
}  // namespace tendril
