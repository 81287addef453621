// cli/scene_video.h and cli/scene_film.h: films and pictures read back, what they show of a run, and what is
// left when there is none.
#include "cli/scene_video.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "capture/record/video_file.h"
#include "cli/scene_film.h"
#include "model/fold/gripper.h"
#include "tests/support/program.h"

namespace tendril::cli {
namespace {

namespace fs = std::filesystem;
using testing_support::TemporaryFolder;

// Two rods that swing, at the rate given.
SceneFilm Swinging(int frames, double fps) {
  SceneFilm film{.name = "swing"};
  for (int rod = 0; rod < 2; ++rod) {
    CurveSeries series;
    series.name = "rod" + std::to_string(rod);
    series.time = Eigen::VectorXd(frames);
    for (int f = 0; f < frames; ++f) {
      series.time[f] = f / fps;
      FramedCurve curve;
      curve.points.resize(3, 21);
      for (int i = 0; i < 21; ++i) {
        const double along = i / 20.0;
        curve.points.col(i) << 0.1 * rod + 0.2 * along * std::sin(0.3 * f), 0, -0.3 * along;
      }
      series.curves.push_back(curve);
    }
    film.curves.push_back(series);
    film.radius.push_back(Eigen::VectorXd::LinSpaced(21, 0.02, 0.01));
  }
  SceneObject bar;
  bar.shape = {{.kind = PrimitiveKind::kCapsule, .radius = 0.02, .half = {0, 0, 0.15}}};
  bar.pose = Eigen::Translation3d(0.05, 0.1, -0.2) *
             Eigen::AngleAxisd(0.5 * std::numbers::pi, Eigen::Vector3d::UnitY());
  film.objects = {bar};
  film.lines.assign(static_cast<std::size_t>(frames), {"mutual link 0.10 turns"});
  return film;
}

std::vector<VideoFrame> FramesOf(const fs::path& file) {
  std::vector<VideoFrame> frames;
  Result<VideoReader> reader = VideoReader::Open(file);
  EXPECT_TRUE(reader.ok()) << (reader.ok() ? "" : reader.error().message);
  while (reader.ok()) {
    Result<std::optional<VideoFrame>> next = reader.value().Next();
    EXPECT_TRUE(next.ok()) << (next.ok() ? "" : next.error().message);
    if (!next.ok() || !next.value()) break;
    frames.push_back(*next.value());
  }
  return frames;
}

TEST(WriteSceneVideo, CanBeReadBackWithAllFramesAtTheirTimes) {
  const TemporaryFolder folder;
  const fs::path file = folder / "swing.mp4";
  const Status written = WriteSceneVideo(Swinging(12, 30), file);
  ASSERT_TRUE(written.ok()) << written.error().message;
  const std::vector<VideoFrame> frames = FramesOf(file);
  ASSERT_EQ(frames.size(), 12u);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].image.size(), cv::Size(1280, 720));
    EXPECT_NEAR(frames[i].time - frames[0].time, static_cast<double>(i) / 30, 1e-4);
  }
  // Rods move: frames differ from each other.
  EXPECT_GT(cv::norm(frames[0].image, frames[5].image, cv::NORM_INF), 50);
  // One file, and the index before the pictures.
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 1);
  const std::string bytes = testing_support::ReadText(file);
  EXPECT_LT(bytes.find("moov"), bytes.find("mdat"));
}

TEST(WriteSceneVideo, RunsSlowerWhereFramesAreTooManyASecond) {
  const TemporaryFolder folder;
  const fs::path file = folder / "fast.mp4";
  ASSERT_TRUE(WriteSceneVideo(Swinging(4, 600), file).ok());
  const std::vector<VideoFrame> frames = FramesOf(file);
  ASSERT_EQ(frames.size(), 4u);
  EXPECT_NEAR(frames[3].time - frames[0].time, 3.0 / 60, 1e-3);
}

TEST(WriteSceneVideo, GivesTheSameBytesAgain) {
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteSceneVideo(Swinging(3, 30), folder / "a.mp4").ok());
  ASSERT_TRUE(WriteSceneVideo(Swinging(3, 30), folder / "b.mp4").ok());
  EXPECT_EQ(testing_support::ReadText(folder / "a.mp4"), testing_support::ReadText(folder / "b.mp4"));
}

TEST(WriteSceneVideo, ASingleFrameIsAFilmToo) {
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteSceneVideo(Swinging(1, 30), folder / "one.mp4").ok());
  EXPECT_EQ(FramesOf(folder / "one.mp4").size(), 1u);
}

TEST(WriteSceneVideo, LeavesNothingWhenStoppedOrWrong) {
  const TemporaryFolder folder;
  int calls = 0;
  const Status stopped =
      WriteSceneVideo(Swinging(9, 30), folder / "a.mp4", [&](double) { return ++calls < 3; });
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().kind, ErrorKind::kStopped);
  EXPECT_EQ(calls, 3);
  const auto kind_of = [&](const SceneFilm& film, const std::string& name) {
    const Status s = WriteSceneVideo(film, folder / name);
    return s.ok()                                   ? std::string("written")
           : s.error().kind == ErrorKind::kBadInput ? "bad input"
                                                    : s.error().message;
  };
  EXPECT_EQ(kind_of(Swinging(2, 30), "a.avi"), "bad input");
  EXPECT_EQ(kind_of({}, "a.mp4"), "bad input");
  EXPECT_EQ(kind_of(Swinging(0, 30), "a.mp4"), "bad input");
  SceneFilm film = Swinging(2, 30);
  film.radius[1].resize(3);
  EXPECT_EQ(kind_of(film, "a.mp4"), "bad input");
  film = Swinging(2, 30);
  film.curves[1].curves.pop_back();
  EXPECT_EQ(kind_of(film, "a.mp4"), "bad input");
  film = Swinging(2, 30);
  film.lines.pop_back();
  EXPECT_EQ(kind_of(film, "a.mp4"), "bad input");
  EXPECT_TRUE(fs::is_empty(folder.path()));
  EXPECT_FALSE(WriteSceneVideo(Swinging(2, 30), folder / "none/a.mp4").ok());
}

TEST(WriteScenePicture, IsTheLastFrame) {
  const TemporaryFolder folder;
  const fs::path file = folder / "last.png";
  const Status written = WriteScenePicture(Swinging(3, 30), file);
  ASSERT_TRUE(written.ok()) << written.error().message;
  const cv::Mat picture = cv::imread(file.string());
  EXPECT_EQ(picture.size(), cv::Size(1600, 1000));
  SceneFilm only_last = Swinging(3, 30);
  for (CurveSeries& series : only_last.curves) {
    series.curves.erase(series.curves.begin(), series.curves.begin() + 2);
    series.time = Eigen::VectorXd(series.time.tail(1));
  }
  only_last.lines.resize(1);
  ASSERT_TRUE(WriteScenePicture(only_last, folder / "only.png").ok());
  EXPECT_EQ(cv::norm(picture, cv::imread(folder / "only.png"), cv::NORM_INF), 0);
  EXPECT_FALSE(WriteScenePicture(only_last, folder / "only.jpg").ok());
}

TEST(WriteScenePicture, ShowsObjectsWhereTheLastFrameHasThem) {
  const TemporaryFolder folder;
  SceneFilm film = Swinging(2, 30);
  film.objects[0].kind = "box";
  film.objects[0].shape = {{.kind = PrimitiveKind::kBox, .half = {0.02, 0.03, 0.04}}};
  film.objects[0].pose = Eigen::Isometry3d::Identity();
  film.objects[0].pose.translation() = Eigen::Vector3d(0, 0.05, -0.1);
  const auto drawn = [&](const char* name) {
    const Status written = WriteScenePicture(film, folder / name);
    EXPECT_TRUE(written.ok()) << (written.ok() ? "" : written.error().message);
    return cv::imread(folder / name);
  };
  const cv::Mat at_start = drawn("start.png");
  film.poses = {std::vector<Eigen::Isometry3d>(2, film.objects[0].pose)};
  EXPECT_EQ(cv::norm(at_start, drawn("still.png"), cv::NORM_INF), 0);
  film.poses[0][1].translate(Eigen::Vector3d(0.05, 0, 0));
  EXPECT_GT(cv::norm(at_start, drawn("moved.png"), cv::NORM_INF), 20);
  film.poses[0].pop_back();
  EXPECT_FALSE(WriteScenePicture(film, folder / "short.png").ok());
}

TEST(WriteScenePicture, TellsThePhase) {
  const TemporaryFolder folder;
  SceneFilm film = Swinging(2, 30);
  ASSERT_TRUE(WriteScenePicture(film, folder / "without.png").ok());
  film.phases = {"pull", "lift"};
  ASSERT_TRUE(WriteScenePicture(film, folder / "lift.png").ok());
  film.phases = {"lift", "pull"};
  ASSERT_TRUE(WriteScenePicture(film, folder / "pull.png").ok());
  const auto read = [&](const char* name) { return cv::imread(folder / name); };
  EXPECT_GT(cv::norm(read("without.png"), read("lift.png"), cv::NORM_INF), 50);
  EXPECT_GT(cv::norm(read("pull.png"), read("lift.png"), cv::NORM_INF), 50);
  film.phases.pop_back();
  EXPECT_FALSE(WriteScenePicture(film, folder / "short.png").ok());
}

// A gripper that is lifted and turned by a quarter, with a ball on a string, at three times.
TEST(FilmOf, PutsObjectsCarrierAndPhaseWhereTheRunHasThem) {
  Scene scene;
  SceneGripper gripper;
  gripper.gripper.tentacles = 4;
  scene.gripper = gripper;
  scene.phases = {{.name = "pull", .duration = 1},
                  {.name = "lift", .duration = 1, .move = {0, 0, 0.2}, .turn = 0.5 * std::numbers::pi}};
  SceneObject ball;
  ball.kind = "sphere";
  ball.shape = {{.kind = PrimitiveKind::kSphere, .radius = 0.02}};
  ball.motion = ObjectMotion::kHanging;
  scene.objects = {ball};
  const Eigen::Vector3d times(0, 1, 2);
  Simulated done;
  for (int rod = 0; rod < 4; ++rod) {
    CurveSeries& series = done.curves.emplace_back();
    series.time = times;
    const Eigen::Isometry3d pose = LabFromTentacle(scene.gripper->gripper, rod);
    for (int f = 0; f < 3; ++f) {
      FramedCurve& curve = series.curves.emplace_back();
      const Eigen::Vector3d base = pose.translation() * (f == 0 ? 1 : 1.25);  // the carrier grows
      curve.points = base.replicate(1, 5);
      if (f == 2) curve.points.colwise() += Eigen::Vector3d(0, 0, 0.2);
    }
  }
  done.objects.resize(1);
  done.objects[0].poses.resize(3, Eigen::Isometry3d::Identity());
  done.objects[0].poses[2].translation().z() = 0.15;
  LinkSeries links;
  links.frames.resize(3);
  const SceneFilm film = FilmOf(scene, done, links);
  EXPECT_EQ(film.phases, (std::vector<std::string>{"pull", "lift", "lift"}));
  ASSERT_EQ(film.poses.size(), 1u);
  EXPECT_EQ(film.poses[0][2].translation().z(), 0.15);
  ASSERT_EQ(film.carrier.size(), 3u);
  for (int f = 0; f < 3; ++f) {
    const Eigen::Matrix3Xd& ring = film.carrier[static_cast<std::size_t>(f)];
    const double radius = scene.gripper->gripper.carrier_radius * (f == 0 ? 1 : 1.25);
    ASSERT_GT(ring.cols(), 36);
    for (Eigen::Index i = 0; i < ring.cols(); ++i) {
      EXPECT_NEAR(ring.col(i).head<2>().norm(), radius, 1e-12);
      EXPECT_NEAR(ring(2, i), f == 2 ? 0.2 : 0, 1e-12);
    }
  }
  const TemporaryFolder folder;
  EXPECT_TRUE(WriteScenePicture(film, folder / "film.png").ok());
}

TEST(FilmOf, DrawsACylinderAsWhatItsContactTouches) {
  Scene scene;
  scene.objects.resize(1);
  scene.objects[0].shape = {{.kind = PrimitiveKind::kCylinder, .radius = 0.02, .half = {0, 0, 0.1}}};
  scene.rods.resize(1);
  Simulated done;
  done.curves.resize(1);
  done.curves[0].time = Eigen::VectorXd::Zero(1);
  done.curves[0].curves.resize(1);
  done.curves[0].curves[0].points = Eigen::Matrix3Xd::Zero(3, 4);
  scene.contact.law = ContactLaw::kHertzSegments;
  EXPECT_EQ(FilmOf(scene, done, {}).objects[0].shape[0].kind, PrimitiveKind::kCylinder);
  scene.contact.law = ContactLaw::kHertzCenters;
  EXPECT_EQ(FilmOf(scene, done, {}).objects[0].shape[0].kind, PrimitiveKind::kCapsule);
}

TEST(RadiusAtNodes, IsTheMeanOfTheNeighbours) {
  EXPECT_EQ(RadiusAtNodes(Eigen::Vector3d(3, 2, 1)), Eigen::Vector4d(3, 2.5, 1.5, 1));
  EXPECT_EQ(RadiusAtNodes(Eigen::VectorXd()).size(), 0);
}

}  // namespace
}  // namespace tendril::cli
