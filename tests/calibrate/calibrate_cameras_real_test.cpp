// calibrate/cameras on real pictures: OpenCV's stereo chessboards (OpenCV 4.6's own answer on its sample's
// corners: 0.4448 px), and held-out pictures beside OpenCV's calibration of the same corners.
#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "calibrate/cameras/calibrate_cameras.h"
#include "capture/track/board.h"
#include "capture/track/tag_pose.h"
#include "tests/support/multicamera.h"
#include "tests/support/shared_data.h"

namespace tendril {
namespace {

constexpr int kColumns = 9;
constexpr double kSquare = 0.025;  // nobody wrote down the real one; it scales distances only

struct Stereo {
  std::vector<Camera> cameras;
  std::vector<BoardView> views;
  Eigen::Matrix3Xd points;
};

// The corners of all 13 pairs, as DetectBoard finds them, or as OpenCV's sample does (windows of 11 px).
Stereo ReadStereo(const std::filesystem::path& folder, bool as_sample) {
  Stereo stereo;
  const Board board = ParseBoard("chessboard:9x6:0.025").value();
  stereo.points = BoardPoints(board);
  for (int camera = 0; camera < 2; ++camera) {
    const std::string name = camera == 0 ? "left" : "right";
    stereo.cameras.emplace_back();
    stereo.cameras.back().name = name;
    stereo.cameras.back().width_px = 640;
    stereo.cameras.back().height_px = 480;
    stereo.cameras.back().distortion = Distortion::kBrown;
    for (int i = 1; i <= 14; ++i) {
      const auto file = folder / (name + (i < 10 ? "0" : "") + std::to_string(i) + ".jpg");
      if (!std::filesystem::exists(file)) continue;
      const cv::Mat gray = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
      BoardView view{i, 0, camera, {}};
      if (as_sample) {
        std::vector<cv::Point2f> corners;
        if (!cv::findChessboardCorners(gray, {9, 6}, corners)) continue;
        cv::cornerSubPix(gray, corners, {11, 11}, {-1, -1},
                         {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 100, 1e-3});
        view.corners.pixels.resize(2, 54);
        for (int k = 0; k < 54; ++k) {
          view.corners.ids.push_back(k);
          view.corners.pixels.col(k) << corners[static_cast<size_t>(k)].x, corners[static_cast<size_t>(k)].y;
        }
      } else {
        const auto seen = DetectBoard({gray.data, gray.cols, gray.rows, static_cast<int>(gray.step)}, board);
        if (!seen.ok() || seen.value().ids.empty()) continue;
        view.corners = seen.value();
      }
      stereo.views.push_back(std::move(view));
    }
  }
  return stereo;
}

// OpenCV's way: each camera alone, then both together with everything free. Returns its stereo RMS.
double CalibrateByOpenCv(const Stereo& stereo, std::vector<Camera>& answer, int fold = -1, int folds = 5) {
  std::vector<std::vector<cv::Point3f>> on_board;
  std::vector<std::vector<cv::Point2f>> pixels[2];
  std::vector<std::int64_t> stamps;
  for (const BoardView& view : stereo.views) {
    if (view.camera == 0) stamps.push_back(view.stamp);
  }
  for (size_t i = 0; i < stamps.size(); ++i) {
    if (fold >= 0 && static_cast<int>(i) % folds == fold) continue;
    for (const BoardView& view : stereo.views) {
      if (view.stamp != stamps[i]) continue;
      std::vector<cv::Point2f> seen;
      std::vector<cv::Point3f> known;
      for (size_t k = 0; k < view.corners.ids.size(); ++k) {
        const auto p = view.corners.pixels.col(static_cast<Eigen::Index>(k));
        const auto q = stereo.points.col(view.corners.ids[k]);
        seen.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
        known.emplace_back(static_cast<float>(q.x()), static_cast<float>(q.y()), 0.F);
      }
      pixels[view.camera].push_back(seen);
      if (view.camera == 0) on_board.push_back(known);
    }
  }
  cv::Mat lens[2];
  cv::Mat bend[2];
  for (int c = 0; c < 2; ++c) {
    std::vector<cv::Mat> turns;
    std::vector<cv::Mat> shifts;
    cv::calibrateCamera(on_board, pixels[c], {640, 480}, lens[c], bend[c], turns, shifts);
  }
  cv::Mat turn;
  cv::Mat shift;
  cv::Mat essential;
  cv::Mat fundamental;
  const double rms =
      cv::stereoCalibrate(on_board, pixels[0], pixels[1], lens[0], bend[0], lens[1], bend[1], {640, 480},
                          turn, shift, essential, fundamental, cv::CALIB_USE_INTRINSIC_GUESS,
                          {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 200, 1e-9});
  answer = stereo.cameras;
  for (size_t c = 0; c < 2; ++c) {
    answer[c].focal_x_px = lens[c].at<double>(0, 0);
    answer[c].focal_y_px = lens[c].at<double>(1, 1);
    answer[c].center_x_px = lens[c].at<double>(0, 2);
    answer[c].center_y_px = lens[c].at<double>(1, 2);
    for (int k = 0; k < 5; ++k) answer[c].coefficients[static_cast<size_t>(k)] = bend[c].at<double>(k);
  }
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) pose(r, c) = turn.at<double>(r, c);
    pose(r, 3) = shift.at<double>(r);
  }
  answer[1].camera_from_lab = pose;
  return rms;
}

double HeldOutByOpenCv(const Stereo& stereo) {
  double sum2 = 0;
  int corners = 0;
  for (int fold = 0; fold < 5; ++fold) {
    std::vector<Camera> cameras;
    CalibrateByOpenCv(stereo, cameras, fold);
    std::vector<const BoardView*> held;
    std::vector<std::int64_t> stamps;
    for (const BoardView& view : stereo.views) {
      if (view.camera == 0) stamps.push_back(view.stamp);
    }
    for (const BoardView& view : stereo.views) {
      const auto rank = std::find(stamps.begin(), stamps.end(), view.stamp) - stamps.begin();
      if (rank % 5 == fold) held.push_back(&view);
    }
    const BundleRms rms = RmsWithPosesFitted(cameras, held, stereo.points);
    sum2 += rms.all_px * rms.all_px * rms.corners;
    corners += rms.corners;
  }
  return std::sqrt(sum2 / corners);
}

void Print(const char* what, const CameraCalibration& fit) {
  std::printf("%s: RMS %.4f px, held out %.4f px, refit ratio %.2f, %d of %d beyond 3 sigmas\n", what,
              fit.rms_px, fit.held_out_rms_px, fit.refit_ratio, fit.down_weighted, fit.corners);
  for (size_t c = 0; c < fit.cameras.size(); ++c) {
    const auto& p = fit.reports[c].parameters;
    std::printf("  %-5s %d views, RMS %.4f, fx %.2f +- %.2f, cx %.2f +- %.2f", fit.cameras[c].name.c_str(),
                fit.reports[c].views, fit.reports[c].rms_px, p[0].value, p[0].standard_error, p[2].value,
                p[2].standard_error);
    if (p.size() > 9) {
      std::printf(", baseline %.4f squares +- %.4f",
                  fit.cameras[c].camera_from_lab.translation().norm() / kSquare,
                  p[9].standard_error / kSquare);
    }
    std::printf("\n");
  }
  for (const std::string& s : fit.weaknesses) std::printf("  %s\n", s.c_str());
}

TEST(RealChessboards, AreMetBetterThanByOpenCv) {
  const auto folder = testing_support::SharedFolder() / "data" / "opencv_stereo";
  TENDRIL_SKIP_WITHOUT(folder);
  // On the corners of OpenCV's sample the two are the same least squares but for the robust loss.
  const Stereo sample = ReadStereo(folder, true);
  ASSERT_EQ(sample.views.size(), 26u);
  std::vector<Camera> by_opencv;
  const double sample_rms = CalibrateByOpenCv(sample, by_opencv);
  const auto plain = CalibrateCameras(sample.cameras, sample.views, sample.points, {.outlier = 1e6});
  ASSERT_TRUE(plain.ok()) << plain.error().message;
  Print("sample's corners, no robust loss", plain.value());
  EXPECT_NEAR(sample_rms, 0.4448, 0.002);
  EXPECT_NEAR(plain.value().rms_px, sample_rms, 0.0005);
  EXPECT_NEAR(plain.value().cameras[0].focal_x_px, by_opencv[0].focal_x_px, 0.3);

  const Stereo stereo = ReadStereo(folder, false);
  ASSERT_EQ(stereo.views.size(), 26u);
  const double opencv_rms = CalibrateByOpenCv(stereo, by_opencv);
  const double opencv_held_out = HeldOutByOpenCv(stereo);
  const double sample_held_out = HeldOutByOpenCv(sample);
  std::printf("OpenCV: RMS %.4f px, held out %.4f px; on its sample's corners %.4f and %.4f px\n", opencv_rms,
              opencv_held_out, sample_rms, sample_held_out);
  const auto flat = CalibrateCameras(stereo.cameras, stereo.views, stereo.points);
  ASSERT_TRUE(flat.ok()) << flat.error().message;
  Print("flat board", flat.value());
  const auto bent =
      CalibrateCameras(stereo.cameras, stereo.views, stereo.points, {.board_sigma = 0.02 * kSquare});
  ASSERT_TRUE(bent.ok()) << bent.error().message;
  Print("board corrected", bent.value());
  EXPECT_LT(flat.value().rms_px, 0.25);
  EXPECT_LT(flat.value().held_out_rms_px, 0.5 * sample_held_out);
  EXPECT_LT(bent.value().rms_px, flat.value().rms_px);
  EXPECT_LT(bent.value().held_out_rms_px, opencv_held_out);
  for (const CalibratedCamera& report : flat.value().reports) {
    for (const CalibratedParameter& p : report.parameters) {
      EXPECT_TRUE(std::isfinite(p.standard_error) && p.standard_error > 0) << p.name;
    }
  }
}

// Every tag is a board of four corners with a pose of its own; lenses are those that came with the stream,
// and then fitted from there. Odd stamps are new to both.
TEST(RealTagStream, FourMovingCamerasAreLinkedAndTheirLensesImproved) {
  const auto folder = testing_support::SharedFolder() / "data" / "tagslam_test" / "test_6";
  TENDRIL_SKIP_WITHOUT(folder);
  const auto stream = testing_support::ReadTagStream(folder);
  ASSERT_EQ(stream.cameras.size(), 4u);
  const auto slow = testing_support::Between(MotionOf(stream.views), 0, 2.5);
  const Eigen::Matrix3Xd corners = TagCorners3d(0.125);  // tagslam.yaml
  std::vector<BoardView> halves[2];
  for (const int half : {0, 1}) {
    std::map<std::pair<std::int64_t, int>, int> seen_by;
    const auto tags = testing_support::Half(slow, half);
    for (const TagInPicture& tag : tags) ++seen_by[{tag.stamp, tag.tag}];
    for (const TagInPicture& tag : tags) {
      if (seen_by[{tag.stamp, tag.tag}] < 2) continue;
      halves[half].push_back({tag.stamp, tag.tag, tag.camera, {{0, 1, 2, 3}, tag.corners_px}});
    }
  }
  std::vector<const BoardView*> held;
  for (const BoardView& view : halves[1]) held.push_back(&view);
  CalibrateCamerasOptions options{.folds = 0, .lenses = stream.cameras};
  const auto given = CalibrateCameras(stream.cameras, halves[0], corners, options);
  ASSERT_TRUE(given.ok()) << given.error().message;
  options.refine_lenses = true;
  const auto refined = CalibrateCameras(stream.cameras, halves[0], corners, options);
  ASSERT_TRUE(refined.ok()) << refined.error().message;
  const double held_given = RmsWithPosesFitted(given.value().cameras, held, corners).all_px;
  const double held_refined = RmsWithPosesFitted(refined.value().cameras, held, corners).all_px;
  std::printf("%d views: RMS %.3f px with the stream's lenses, %.3f px fitted; held out %.3f and %.3f px\n",
              given.value().views, given.value().rms_px, refined.value().rms_px, held_given, held_refined);
  for (size_t c = 0; c < 4; ++c) {
    const auto& p = refined.value().reports[c].parameters;
    std::printf("  %s: fx %.2f +- %.2f (stream: %.2f)", refined.value().cameras[c].name.c_str(), p[0].value,
                p[0].standard_error, stream.cameras[c].focal_x_px);
    const auto& q = given.value().reports[c].parameters;
    if (c > 0) std::printf(", position %.4f +- %.4f m", q[8].value, q[8].standard_error);
    std::printf("\n");
    EXPECT_NEAR(p[0].value, stream.cameras[c].focal_x_px, 0.03 * stream.cameras[c].focal_x_px);
  }
  EXPECT_LT(held_given, 1.2);
  EXPECT_LE(held_refined, 1.02 * held_given);
}

}  // namespace
}  // namespace tendril
