// cli/scene_video.h: films and pictures read back, and what is left when there is none.
#include "cli/scene_video.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "capture/record/video_file.h"
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
  bar.body = {.start = {-0.1, 0.1, -0.2}, .end = {0.2, 0.1, -0.2}, .radius = 0.02};
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

TEST(RadiusAtNodes, IsTheMeanOfTheNeighbours) {
  EXPECT_EQ(RadiusAtNodes(Eigen::Vector3d(3, 2, 1)), Eigen::Vector4d(3, 2.5, 1.5, 1));
  EXPECT_EQ(RadiusAtNodes(Eigen::VectorXd()).size(), 0);
}

}  // namespace
}  // namespace tendril::cli
