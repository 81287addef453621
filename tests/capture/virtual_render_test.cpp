// capture/rig/virtual_render.h: libapriltag finds the tags where the camera model projects their true
// corners; nearer things hide farther ones; nothing but noise where nothing is.
#include "capture/rig/virtual_render.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <map>
#include <opencv2/core.hpp>

namespace tendril {
namespace {

using Vector3 = Eigen::Vector3d;

// Tags of 51 px. At half of that libapriltag's own corners lie 0.18 px outward (its edge fit reaches the next
// module), whoever draws them.
Camera TestCamera() {
  Camera camera;
  camera.name = "test";
  camera.width_px = 1240;
  camera.height_px = 920;
  camera.focal_x_px = 3000;
  camera.focal_y_px = 3006;
  camera.center_x_px = 622;
  camera.center_y_px = 456;
  camera.distortion = Distortion::kBrown;
  camera.coefficients = {-0.2, 0.1, 1e-3, -5e-4, 0};
  // At (0.5, 0, 0), looking along -x: the lab's y is to the right, z is up.
  camera.camera_from_lab.linear() << 0, 1, 0, 0, 0, -1, -1, 0, 0;
  camera.camera_from_lab.translation() = Vector3(0, 0, 0.5);
  return camera;
}

constexpr double kBorder = 0.0064;  // 8 of 10 modules of an 8 mm footprint

// A tag in the middle of a sheet's facet, upright when the sheet's z is up.
TagPlace Tag(int id, int facet, TagSide side) {
  TagPlace tag;
  tag.id = id;
  tag.facet = facet;
  tag.side = side;
  tag.footprint = 0.008;
  const double h = 0.5 * kBorder;
  const double right = side == TagSide::kOuter ? 1 : -1;  // y is to the right when seen from +x
  tag.corners_in_sheet << 0, 0, 0, 0, -right * h, right * h, right * h, -right * h, -h, -h, h, h;
  return tag;
}

TrueStrip Facet(int facet, const Eigen::Isometry3d& lab_from_sheet) {
  TrueStrip strip;
  strip.facet = facet;
  strip.corners_in_sheet.resize(3, 4);
  strip.corners_in_sheet << 0, 0, 0, 0, -0.006, 0.006, 0.006, -0.006, -0.006, -0.006, 0.006, 0.006;
  strip.hole_in_sheet = {0, 1};  // outside the facet: no hole
  strip.lab_from_sheet = lab_from_sheet;
  return strip;
}

Eigen::Isometry3d Pose(const Vector3& at, double yaw, double pitch, double roll) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translate(at);
  pose.rotate(Eigen::AngleAxisd(yaw, Vector3::UnitZ()));
  pose.rotate(Eigen::AngleAxisd(pitch, Vector3::UnitY()));
  pose.rotate(Eigen::AngleAxisd(roll, Vector3::UnitX()));
  return pose;
}

struct Scene {
  TrueShape shape;
  TagLayout tags;
  Scene() {
    tags.family = "tag36h11";
    shape.tentacles.resize(1);
    shape.object.radius = 0;
  }
  void Add(int facet, const Eigen::Isometry3d& pose, TagSide side = TagSide::kOuter) {
    shape.tentacles[0].strips.push_back(Facet(facet, pose));
    tags.tags.push_back(Tag(10 + facet, facet, side));
  }
};

// Twenty facets over the whole image, each turned its own way by up to 40 degrees.
Scene Wall(TagSide side = TagSide::kOuter) {
  Scene scene;
  const double turn = side == TagSide::kOuter ? 0 : M_PI;
  for (int i = 0; i < 20; ++i) {
    const Vector3 at(0.02 * std::sin(i), -0.08 + 0.04 * (i % 5), -0.05 + 0.035 * (i / 5));
    scene.Add(i, Pose(at, turn + 0.7 * std::sin(1.7 * i), 0.7 * std::cos(2.3 * i), 3 * std::sin(0.9 * i)),
              side);
  }
  return scene;
}

std::map<int, Eigen::Matrix<double, 2, 4>> Detect(const cv::Mat& image) {
  apriltag_family_t* family = tag36h11_create();
  apriltag_detector_t* detector = apriltag_detector_create();
  apriltag_detector_add_family(detector, family);
  detector->quad_decimate = 1;
  cv::Mat copy = image.clone();
  image_u8_t view = {copy.cols, copy.rows, static_cast<int>(copy.step), copy.data};
  zarray_t* found = apriltag_detector_detect(detector, &view);
  std::map<int, Eigen::Matrix<double, 2, 4>> corners;
  for (int i = 0; i < zarray_size(found); ++i) {
    apriltag_detection_t* d = nullptr;
    zarray_get(found, i, &d);
    // libapriltag counts from the pixel's corner, the camera model from its centre.
    for (int c = 0; c < 4; ++c) corners[d->id].col(c) = Eigen::Vector2d(d->p[c][0] - 0.5, d->p[c][1] - 0.5);
  }
  apriltag_detections_destroy(found);
  apriltag_detector_destroy(detector);
  tag36h11_destroy(family);
  return corners;
}

// Root mean square distance of detected from projected corners; counts the tags found.
double CornerError(const Scene& scene, const cv::Mat& image, int& tags_found) {
  const Camera camera = TestCamera();
  const auto found = Detect(image);
  double sum = 0;
  tags_found = 0;
  for (std::size_t i = 0; i < scene.tags.tags.size(); ++i) {
    const TagPlace& tag = scene.tags.tags[i];
    const auto it = found.find(tag.id);
    if (it == found.end()) continue;
    ++tags_found;
    const TrueStrip& strip = scene.shape.tentacles[0].strips[i];
    for (int c = 0; c < 4; ++c) {
      const Vector3 p =
          camera.camera_from_lab * (strip.lab_from_sheet * Vector3(tag.corners_in_sheet.col(c)));
      sum += (it->second.col(c) - ProjectInCamera<double>(camera, p)).squaredNorm();
    }
  }
  return std::sqrt(sum / (4 * tags_found));
}

cv::Mat Picture(const Scene& scene, const VirtualOptics& optics, unsigned seed = 1) {
  const auto camera = VirtualCamera::Make(TestCamera(), scene.tags, 0.002, optics);
  EXPECT_TRUE(camera.ok()) << camera.error().message;
  std::mt19937_64 random(seed);
  return camera.value().Render(scene.shape, random);
}

VirtualOptics Noiseless() {
  VirtualOptics optics;
  optics.read_noise = optics.shot_noise = 0;
  return optics;
}

TEST(VirtualCamera, TagsAreDetectedWhereTheirCornersProject) {
  const Scene scene = Wall();
  int found = 0;
  const double clean = CornerError(scene, Picture(scene, Noiseless()), found);
  EXPECT_EQ(found, 20);
  EXPECT_LT(clean, 0.1);
  RecordProperty("rms_px_without_noise", std::to_string(clean));
  const double noisy = CornerError(scene, Picture(scene, VirtualOptics{}), found);
  EXPECT_EQ(found, 20);
  EXPECT_LT(noisy, 0.1);
  RecordProperty("rms_px_with_noise", std::to_string(noisy));
  std::printf("corner error %.4f px without, %.4f px with noise\n", clean, noisy);
}

TEST(VirtualCamera, InnerTagsShowOnTheBack) {
  Scene scene = Wall(TagSide::kInner);
  int found = 0;
  EXPECT_LT(CornerError(scene, Picture(scene, Noiseless()), found), 0.1);
  EXPECT_EQ(found, 20);
  for (TagPlace& tag : scene.tags.tags) tag.side = TagSide::kOuter;
  EXPECT_TRUE(Detect(Picture(scene, Noiseless())).empty());
}

TEST(VirtualCamera, TheNearerFacetHidesTheFarther) {
  for (const bool swapped : {false, true}) {  // whatever the order they are drawn in
    Scene scene;
    scene.Add(0, Pose({swapped ? 0.05 : 0, 0, 0}, 0, 0, 0));
    scene.Add(1, Pose({swapped ? 0 : 0.05, 0, 0}, 0, 0, 0));
    const auto found = Detect(Picture(scene, Noiseless()));
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found.begin()->first, swapped ? 10 : 11);
  }
}

TEST(VirtualCamera, TheCylinderHidesWhatIsBehindItOnly) {
  Scene scene = Wall();
  scene.shape.object = {{0.1, 0, 0.02}, Vector3::UnitY(), 0.008, 0.5};  // across the middle, in front
  const auto hidden = Detect(Picture(scene, Noiseless()));
  EXPECT_LE(hidden.size(), 15U);
  scene.shape.object.center.x() = -0.1;  // behind
  EXPECT_EQ(Detect(Picture(scene, Noiseless())).size(), 20U);
}

// Its nearer end, of known radius and distance, hides all the rest.
TEST(VirtualCamera, ACylinderSeenAlongItsAxisIsADisc) {
  Scene scene;
  scene.shape.object = {{0, 0, 0}, Vector3::UnitX(), 0.02, 0.1};
  Camera camera = TestCamera();
  camera.distortion = Distortion::kNone;
  camera.coefficients = {};
  VirtualOptics optics = Noiseless();
  optics.blur_px = 0;
  const auto made = VirtualCamera::Make(camera, scene.tags, 0.002, optics);
  ASSERT_TRUE(made.ok());
  std::mt19937_64 random(1);
  const cv::Mat image = made.value().Render(scene.shape, random);
  double bright = 0;  // pixels that are not background, by their brightness
  const double front = image.at<std::uint8_t>(456, 622);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      bright += (image.at<std::uint8_t>(y, x) - optics.background) / (front - optics.background);
    }
  }
  const double a = camera.focal_x_px * 0.02 / 0.45;  // the near end is 0.45 m away
  const double b = camera.focal_y_px * 0.02 / 0.45;
  EXPECT_NEAR(bright / (M_PI * a * b), 1, 2e-3);
}

TEST(VirtualCamera, NothingIsBackgroundWithTheStatedNoise) {
  Scene scene;
  cv::Scalar mean, deviation;
  cv::meanStdDev(Picture(scene, Noiseless()), mean, deviation);
  EXPECT_EQ(mean[0], 10);
  EXPECT_EQ(deviation[0], 0);
  VirtualOptics optics;
  optics.read_noise = std::sqrt(3);
  optics.shot_noise = 0.4;  // 2.6 levels in all: hardly ever below black
  const cv::Mat image = Picture(scene, optics);
  cv::meanStdDev(image, mean, deviation);
  EXPECT_NEAR(mean[0], 10, 0.05);
  EXPECT_NEAR(deviation[0], std::sqrt(3 + 0.4 * 10 + 1 / 12.0), 0.05);
  EXPECT_TRUE(Detect(image).empty());
}

TEST(VirtualCamera, TheSameSeedGivesTheSameBytes) {
  const Scene scene = Wall();
  const cv::Mat a = Picture(scene, VirtualOptics{}, 7);
  EXPECT_EQ(cv::norm(a, Picture(scene, VirtualOptics{}, 7), cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(a, Picture(scene, VirtualOptics{}, 8), cv::NORM_INF), 0);
}

TEST(VirtualCamera, WhatIsBehindTheCameraOrEdgeOnIsNotDrawn) {
  Scene scene;
  scene.Add(0, Pose({0.6, 0, 0}, 0, 0, 0));
  scene.Add(1, Pose({0, 0, 0}, M_PI / 2, 0, 0));
  scene.shape.object.center = {2, 0, 0};
  scene.shape.object.radius = 0.02;
  EXPECT_TRUE(Detect(Picture(scene, VirtualOptics{})).empty());
}

TEST(VirtualCamera, BadInputIsNamed) {
  Scene scene = Wall();
  const auto message = [&](const Camera& camera, const VirtualOptics& optics) {
    const auto made = VirtualCamera::Make(camera, scene.tags, 0.002, optics);
    return made.ok() ? std::string() : made.error().message;
  };
  Camera camera = TestCamera();
  camera.width_px = 0;
  EXPECT_NE(message(camera, {}).find("0 x 920"), std::string::npos);
  camera = TestCamera();
  camera.coefficients = {-40, 0, 0, 0, 0};
  EXPECT_NE(message(camera, {}).find("no inverse"), std::string::npos);
  VirtualOptics optics;
  optics.blur_px = std::nan("");
  EXPECT_NE(message(TestCamera(), optics).find("blur_px"), std::string::npos);
  scene.tags.family = "tag37h11";
  EXPECT_NE(message(TestCamera(), {}).find("tag37h11"), std::string::npos);
}

TEST(VirtualCamera, APictureOfThreeMegapixelsIsQuick) {
  Scene scene;
  Camera camera = TestCamera();
  camera.focal_x_px = camera.focal_y_px = 1500;
  camera.width_px = 1216;
  camera.height_px = 2624;
  camera.center_x_px = 600;
  camera.center_y_px = 1310;
  for (int i = 0; i < 196; ++i) {  // four tentacles' worth of facets
    scene.Add(i, Pose({0, -0.15 + 0.02 * (i % 14), -0.35 + 0.05 * (i / 14)}, 0.3, 0.2, 0.1));
  }
  const auto made = VirtualCamera::Make(camera, scene.tags, 0.002, {});
  ASSERT_TRUE(made.ok());
  std::mt19937_64 random(1);
  double best = 1e9;
  for (int i = 0; i < 3; ++i) {
    const auto start = std::chrono::steady_clock::now();
    made.value().Render(scene.shape, random);
    best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  std::printf("%.3f s for a picture of %d x %d px with 196 facets\n", best, camera.width_px,
              camera.height_px);
  EXPECT_LT(best, 5);  // far above what it takes, so that a busy machine or a sanitizer does not fail it
}

}  // namespace
}  // namespace tendril
