// calibrate/cameras/calibrate_from_tags.h: a made-up rig of three fisheye cameras comes back from the tags
// that it would see, and with it a box of tags whose places nobody measured.
#include "calibrate/cameras/calibrate_from_tags.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <random>

#include "calibrate/cameras/frame_stamps.h"
#include "capture/track/tag_pose.h"
#include "db/files/recording_logs.h"
#include "tests/support/program.h"

namespace tendril {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kBorder = 0.1;

std::vector<Camera> Truth() {
  std::vector<Camera> cameras(3);
  const double along[3] = {0, 0.2, 0.5};
  const double turn[3] = {0, 0.2, -0.3};
  for (size_t i = 0; i < 3; ++i) {
    Camera& c = cameras[i];
    c.name = "c" + std::to_string(i);
    c.width_px = 1280;
    c.height_px = 1024;
    c.focal_x_px = c.focal_y_px = 470;
    c.center_x_px = 640;
    c.center_y_px = 512;
    c.distortion = Distortion::kEquidistant;
    c.coefficients = {-0.013, -0.0099, 0.012, -0.0045, 0};
    Eigen::Isometry3d lab_from_camera = Eigen::Isometry3d::Identity();
    lab_from_camera.translation() = Eigen::Vector3d(along[i], 0.1 * along[i], 0);
    lab_from_camera.linear() =
        Eigen::AngleAxisd(turn[i], Eigen::Vector3d(0.2, 1, 0.1).normalized()).toRotationMatrix();
    c.camera_from_lab = lab_from_camera.inverse();
  }
  return cameras;
}

std::vector<TagInPicture> Views(const std::vector<Camera>& cameras, int count, double noise_px, int wrong) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::normal_distribution<double> noise(0, noise_px);
  std::vector<TagInPicture> views;
  for (int i = 0; i < count; ++i) {
    Eigen::Isometry3d lab_from_tag = Eigen::Isometry3d::Identity();
    lab_from_tag.translation() =
        Eigen::Vector3d(0.25 + 0.5 * unit(random), 0.4 * unit(random), 1.3 + 0.4 * unit(random));
    lab_from_tag.linear() =
        Eigen::AngleAxisd(0.9 * unit(random),
                          Eigen::Vector3d(unit(random), unit(random), unit(random)).normalized())
            .toRotationMatrix();
    for (size_t c = 0; c < cameras.size(); ++c) {
      TagInPicture view{.stamp = i / 4, .tag = i % 4, .camera = static_cast<int>(c), .corners_px = {}};
      for (int k = 0; k < 4; ++k) {
        const auto p = Project(cameras[c], lab_from_tag * Eigen::Vector3d(TagCorners3d(kBorder).col(k)));
        if (!p) return views;
        view.corners_px.col(k) = *p + Eigen::Vector2d(noise(random), noise(random));
      }
      if (i < wrong && c == 1) view.corners_px.array() += 40;  // another tag taken for this one
      views.push_back(view);
    }
  }
  return views;
}

// Two tags on each of five sides of a box of 0.3 m, and where each is.
std::vector<Eigen::Isometry3d> BoxOfTags() {
  std::vector<Eigen::Isometry3d> tags;
  const double quarter = std::numbers::pi / 2;
  const Eigen::Matrix3d sides[5] = {Eigen::Matrix3d::Identity(),
                                    Eigen::AngleAxisd(quarter, Eigen::Vector3d::UnitY()).toRotationMatrix(),
                                    Eigen::AngleAxisd(-quarter, Eigen::Vector3d::UnitY()).toRotationMatrix(),
                                    Eigen::AngleAxisd(quarter, Eigen::Vector3d::UnitX()).toRotationMatrix(),
                                    Eigen::AngleAxisd(-quarter, Eigen::Vector3d::UnitX()).toRotationMatrix()};
  for (const Eigen::Matrix3d& side : sides) {
    for (const double x : {-0.07, 0.07}) {
      Eigen::Isometry3d box_from_tag = Eigen::Isometry3d::Identity();
      box_from_tag.linear() = side * Eigen::AngleAxisd(3 * x, Eigen::Vector3d::UnitZ()).toRotationMatrix();
      box_from_tag.translation() = side * Eigen::Vector3d(x, 0.02, -0.15);  // seen from -z
      tags.push_back(box_from_tag);
    }
  }
  return tags;
}

// The box turned about at many moments; a tag is seen from its front, up to 70 degrees off.
std::vector<TagInPicture> BoxViews(const std::vector<Camera>& cameras, int moments, double noise_px) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::normal_distribution<double> noise(0, noise_px);
  const auto box = BoxOfTags();
  std::vector<TagInPicture> views;
  for (int i = 0; i < moments; ++i) {
    Eigen::Isometry3d lab_from_box = Eigen::Isometry3d::Identity();
    lab_from_box.translation() = Eigen::Vector3d(0.25 + 0.2 * unit(random), 0.2 * unit(random), 1.1);
    lab_from_box.linear() =
        Eigen::AngleAxisd(1.2 * unit(random), Eigen::Vector3d(unit(random), unit(random), 0).normalized())
            .toRotationMatrix();
    for (size_t c = 0; c < cameras.size(); ++c) {
      for (size_t k = 0; k < box.size(); ++k) {
        const Eigen::Isometry3d tag = cameras[c].camera_from_lab * lab_from_box * box[k];
        if (tag.linear().col(2).dot(tag.translation().normalized()) < 0.35) continue;
        TagInPicture view{
            .stamp = i, .tag = 100 + static_cast<int>(k), .camera = static_cast<int>(c), .corners_px = {}};
        for (int j = 0; j < 4; ++j) {
          view.corners_px.col(j) =
              ProjectInCamera<double>(cameras[c], tag * Eigen::Vector3d(TagCorners3d(kBorder).col(j))) +
              Eigen::Vector2d(noise(random), noise(random));
        }
        views.push_back(view);
      }
    }
  }
  return views;
}

CalibrateFromTagsOptions Moving() {
  CalibrateFromTagsOptions options{.border = kBorder, .tags_move = true, .cameras = {}};
  options.cameras.folds = 0;
  return options;
}

double FarthestOff(const std::vector<Camera>& found, const std::vector<Camera>& truth) {
  double worst = 0;
  for (size_t i = 0; i < truth.size(); ++i) {
    const Eigen::Isometry3d off = found[i].camera_from_lab * truth[i].camera_from_lab.inverse();
    worst = std::max({worst, off.translation().norm(), Eigen::AngleAxisd(off.linear()).angle()});
  }
  return worst;
}

TEST(CalibrateFromTags, FindsTheRigExactlyWithoutNoise) {
  const auto truth = Truth();
  const auto fit = CalibrateFromTags(truth, Views(truth, 40, 0, 0), Moving());
  ASSERT_TRUE(fit.ok()) << fit.error().message;
  EXPECT_TRUE(fit.value().calibration.converged);
  EXPECT_EQ(fit.value().calibration.views, 120);
  EXPECT_LT(FarthestOff(fit.value().calibration.cameras, truth), 1e-6);
}

TEST(CalibrateFromTags, NoiseAndAFewWrongTagsDoLittle) {
  const auto truth = Truth();
  const auto fit = CalibrateFromTags(truth, Views(truth, 200, 0.1, 6), Moving());
  ASSERT_TRUE(fit.ok()) << fit.error().message;
  EXPECT_LT(FarthestOff(fit.value().calibration.cameras, truth), 0.002);
}

TEST(CalibrateFromTags, ABoxOfTagsIsFoundWithTheRig) {
  const auto truth = Truth();
  const auto box = BoxOfTags();
  CalibrateFromTagsOptions options{.border = kBorder, .cameras = {}};
  options.cameras.folds = 0;
  const auto exact = CalibrateFromTags(truth, BoxViews(truth, 30, 0), options);
  ASSERT_TRUE(exact.ok()) << exact.error().message;
  EXPECT_LT(FarthestOff(exact.value().calibration.cameras, truth), 1e-6);
  const TagBody& body = exact.value().body;
  ASSERT_EQ(body.tags.size(), 10u);
  for (size_t k = 0; k < 10; ++k) {
    EXPECT_EQ(body.tags[k], 100 + static_cast<int>(k));
    const Eigen::Isometry3d first_from_tag = box[0].inverse() * box[k];
    for (int j = 0; j < 4; ++j) {
      const Eigen::Vector3d at = first_from_tag * Eigen::Vector3d(TagCorners3d(kBorder).col(j));
      EXPECT_LT((body.points.col(4 * static_cast<Eigen::Index>(k) + j) - at).norm(), 1e-6);
    }
  }
  const auto noisy = CalibrateFromTags(truth, BoxViews(truth, 30, 0.1), options);
  ASSERT_TRUE(noisy.ok()) << noisy.error().message;
  EXPECT_LT(FarthestOff(noisy.value().calibration.cameras, truth), 0.001);
}

TEST(CalibrateFromTags, TwoCamerasThatSeeNoTagInCommonArePlacedByTheBodyTheySee) {
  auto truth = Truth();
  auto views = BoxViews(truth, 40, 0.05);
  // Camera 1 sees but the later tags, camera 2 but the earlier; camera 0 sees all, and never at their
  // moments.
  std::erase_if(views, [](const TagInPicture& v) {
    return (v.camera == 1 && v.tag < 104) || (v.camera == 2 && v.tag >= 104) ||
           (v.camera == 0 && v.stamp < 20) || (v.camera != 0 && v.stamp >= 30);
  });
  CalibrateFromTagsOptions options{.border = kBorder, .cameras = {}};
  options.cameras.folds = 0;
  const auto fit = CalibrateFromTags(truth, views, options);
  ASSERT_TRUE(fit.ok()) << fit.error().message;
  EXPECT_LT(FarthestOff(fit.value().calibration.cameras, truth), 0.003);
}

TEST(CalibrateFromTags, ALensThatIsWrongIsRefined) {
  const auto truth = Truth();
  auto lenses = truth;
  lenses[1].center_y_px += 8;
  lenses[2].focal_x_px *= 1.01;
  CalibrateFromTagsOptions options{.border = kBorder, .cameras = {}};
  options.cameras.folds = 0;
  options.cameras.refine_lenses = true;
  options.cameras.board_sigma = 0.001;  // the first lens put the tags wrong
  const auto fit = CalibrateFromTags(lenses, BoxViews(truth, 60, 0.05), options);
  ASSERT_TRUE(fit.ok()) << fit.error().message;
  for (size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(fit.value().calibration.cameras[c].center_y_px, truth[c].center_y_px, 1.5);
    EXPECT_NEAR(fit.value().calibration.cameras[c].focal_x_px, truth[c].focal_x_px, 1.5);
  }
}

TEST(CalibrateFromTags, WhatCannotBeIsNamed) {
  const auto truth = Truth();
  auto views = Views(truth, 40, 0, 0);
  EXPECT_EQ(CalibrateFromTags(truth, views, {.cameras = {}}).error().kind, ErrorKind::kBadInput);
  EXPECT_EQ(CalibrateFromTags({truth[0]}, views, Moving()).error().kind, ErrorKind::kBadInput);
  EXPECT_FALSE(CalibrateFromTags(truth, {}, Moving()).ok());
  auto without = views;
  std::erase_if(without, [](const TagInPicture& v) { return v.camera == 2; });
  const auto alone = CalibrateFromTags(truth, without, Moving());
  ASSERT_FALSE(alone.ok());
  EXPECT_EQ(alone.error().kind, ErrorKind::kUnreachable);
  EXPECT_THAT(alone.error().message, HasSubstr("c2 never sees the board"));
  views[0].camera = 7;
  EXPECT_EQ(CalibrateFromTags(truth, views, Moving()).error().kind, ErrorKind::kBadInput);

  // Tags 106 and 107 are never seen with others.
  auto box = BoxViews(truth, 20, 0);
  for (TagInPicture& v : box) {
    if (v.tag == 106 || v.tag == 107) v.stamp += 1000;
  }
  const auto apart = FindTagBody(truth, box, {.border = kBorder});
  ASSERT_FALSE(apart.ok());
  EXPECT_THAT(apart.error().message, HasSubstr("links tags 106, 107 to the others"));
  std::erase_if(box, [](const TagInPicture& v) { return v.tag != 103; });
  EXPECT_THAT(FindTagBody(truth, box, {.border = kBorder}).error().message,
              HasSubstr("no picture shows two tags"));
}

TEST(UnlinkMoving, OnlyStillPicturesKeepTheirStamp) {
  std::vector<TagInPicture> tags;
  for (int i = 0; i < 10; ++i) {
    TagInPicture tag{.stamp = 10 * i, .tag = 1, .camera = 0, .corners_px = {}};
    tag.corners_px.setConstant(i < 5 ? 100 : 100 + 7.0 * (i - 4));
    tags.push_back(tag);
  }
  const auto motion = MotionOf(tags);
  ASSERT_EQ(motion.size(), 8u);
  EXPECT_NEAR(motion.back().velocity(0, 0), 0.7, 1e-12);
  EXPECT_NEAR(motion.back().px_per_picture, 7 * std::sqrt(2.0), 1e-12);
  std::vector<std::int64_t> stamps;
  for (const TagInPicture& t : UnlinkMoving(tags, 2.5, 3)) stamps.push_back(t.stamp);
  EXPECT_THAT(stamps, ElementsAre(10, 20, 30, -1, -2, -3));
}

TEST(StampsByClock, FreeRunningCamerasShareMomentsAtAnyPhase) {
  const testing_support::TemporaryFolder folder;
  const auto log = [&](const std::string& name, std::int64_t late_ns, int lost) {
    std::vector<FrameRow> rows;
    for (int i = 0; i < 10; ++i) {
      if (i == lost) continue;
      const std::int64_t ns = 10'000'000LL * (i + 1) + late_ns;
      rows.push_back(
          {.frame = static_cast<std::int64_t>(rows.size()), .frame_id = i, .device_ns = ns, .host_ns = ns});
    }
    EXPECT_TRUE(WriteFrameLog(folder / name, rows).ok());
    return std::filesystem::path(folder / name);
  };
  const auto first = log("cam0.csv", 0, -1);
  for (const std::int64_t late_ns : {0, 2'000'000, 4'500'000, 5'000'000, 5'500'000, 9'000'000}) {
    const auto second = log("cam1.csv", late_ns, 4);
    const FrameStamps triggered = StampsByClock({first, second}).value();
    const bool near = late_ns < 4'000'000 || late_ns > 6'000'000;
    EXPECT_EQ(triggered.together > 0, near) << late_ns;
    const FrameStamps free = StampsByClock({first, second}, kFreeRunning).value();
    EXPECT_GE(free.together, 8) << late_ns;
    EXPECT_LE(free.farthest_apart, 0.01 + 1e-9) << late_ns;
    // No frame of camera 0 has two of the other.
    std::vector<std::int64_t> stamps = free.stamps[1];
    std::sort(stamps.begin(), stamps.end());
    EXPECT_EQ(std::adjacent_find(stamps.begin(), stamps.end()), stamps.end()) << late_ns;
  }
}

}  // namespace
}  // namespace tendril
