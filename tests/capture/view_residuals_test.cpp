// capture/track/view_residuals.h: tags against a chain whose poses are known, projected by OpenCV.
#include "capture/track/view_residuals.h"

#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <random>

#include "tests/support/synthetic_view.h"

namespace tendril {
namespace {

using testing_support::CamerasAround;
using testing_support::Imperfection;
using testing_support::MakeTruth;
using testing_support::Truth;

constexpr Imperfection kNone{.hole = 0,
                             .crease = 0,
                             .crease_angle = 0,
                             .fold_angle = 0,
                             .pull = 0,
                             .bend = 0,
                             .sag = 0,
                             .tag_turn = 0,
                             .tag_place = 0,
                             .corner_px = 0};

// Pixel of a lab point by OpenCV's own projection; no or Brown's distortion.
Eigen::Vector2d ByOpenCv(const Camera& camera, const Eigen::Vector3d& in_lab) {
  const Eigen::Vector3d p = camera.camera_from_lab * in_lab;
  const cv::Matx33d pinhole(camera.focal_x_px, 0, camera.center_x_px, 0, camera.focal_y_px,
                            camera.center_y_px, 0, 0, 1);
  std::vector<double> lens;
  if (camera.distortion == Distortion::kBrown)
    lens.assign(camera.coefficients.begin(), camera.coefficients.end());
  std::vector<cv::Point2d> pixels;
  cv::projectPoints(std::vector<cv::Point3d>{{p.x(), p.y(), p.z()}}, cv::Vec3d(), cv::Vec3d(), pinhole, lens,
                    pixels);
  return {pixels[0].x, pixels[0].y};
}

TEST(AppendResiduals, AreFoundMinusWhereOpenCvProjectsTheTrueTag) {
  const std::vector<Camera> rig = CamerasAround(2);
  std::mt19937_64 random(5);
  Truth truth = MakeTruth({}, 0.3, rig, {}, kNone, random);
  const ChainSolution solution = SolveChain(truth.model, rig, truth.views);
  // What was found is moved after the solution was made: the residuals must say so.
  for (std::size_t v = 0; v < truth.views.size(); ++v) {
    truth.views[v].corners_px.row(0).array() += 0.5 * static_cast<double>(v);
    truth.views[v].corners_px(1, 2) -= 3;
  }
  std::vector<ResidualRow> rows;
  AppendResiduals(rig, truth.model.layout, truth.views, solution, 9, rows);
  ASSERT_EQ(rows.size(), truth.views.size());
  ASSERT_GT(rows.size(), 20U);
  for (std::size_t v = 0; v < rows.size(); ++v) {
    const TagView& view = truth.views[v];
    EXPECT_EQ(rows[v].frame, 9);
    EXPECT_EQ(rows[v].camera, view.camera);
    EXPECT_EQ(rows[v].tag, view.place->id);
    EXPECT_TRUE(rows[v].used);
    for (int k = 0; k < 4; ++k) {
      const Eigen::Vector3d corner = truth.lab_from_sheet[static_cast<std::size_t>(view.place->facet)] *
                                     Eigen::Vector3d(view.place->corners_in_sheet.col(k));
      const Eigen::Vector2d expected =
          view.corners_px.col(k) - ByOpenCv(rig[static_cast<std::size_t>(view.camera)], corner);
      // The solution is the truth to some thousandths of a pixel.
      EXPECT_LT((rows[v].corners_px.col(k) - expected).norm(), 0.02) << v << " corner " << k;
    }
  }
}

TEST(AppendResiduals, AViewThatWasLeftOutKeepsItsDistanceAndSaysSo) {
  const std::vector<Camera> rig = CamerasAround(2);
  std::mt19937_64 random(6);
  Truth truth = MakeTruth({}, 0.3, rig, {}, kNone, random);
  truth.views[4].corners_px.row(0).array() += 40;
  const ChainSolution solution = SolveChain(truth.model, rig, truth.views);
  std::vector<ResidualRow> rows;
  AppendResiduals(rig, truth.model.layout, truth.views, solution, 0, rows);
  for (std::size_t v = 0; v < rows.size(); ++v) {
    EXPECT_EQ(rows[v].used, v != 4);
    EXPECT_NEAR(rows[v].corners_px.rowwise().mean().x(), v == 4 ? 40 : 0, 0.1) << v;
  }
}

}  // namespace
}  // namespace tendril
